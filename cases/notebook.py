"""pgimp from Python, cell by cell (Jupyter, VS Code), or as a script on any number of ranks.

python cases/notebook.py
mpirun -n 2 python cases/notebook.py
"""

# %% Run a case with some values changed; its results come back. Under mpirun all ranks do this.
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pgimp

here = Path(__file__).parent if "__file__" in globals() else Path()  # Jupyter starts beside it
first_rank = pgimp.world().rank == 0
case = pgimp.load(
    here / "compaction.yaml",
    {"exact": "compaction", "time.end": 0.5, "time.step": {"courant": 0.2}, "grid.size": [55.0]},
)
run = pgimp.run(case, output="notebook.out/column", overwrite=True)

# %% Change a parameter in a loop: error against cost.
rows = []
for cell in (5.0, 2.5, 1.0):
    one = pgimp.run(
        case,
        output=f"notebook.out/{cell}",
        overrides={"grid.cell": [cell]},
        overwrite=True,
        quiet=True,
    )
    rows.append((cell, one.history["error"][-1], one.info["seconds"]))
table = np.array(rows, dtype=[("cell", float), ("error", float), ("seconds", float)])

# %% Frames and history as NumPy arrays; with pandas installed, as its tables too.
history = run.history
frame = run.frame(-1)
lowest = frame["id"][frame["position"][:, 0].argmin()]
track = run.follow(lowest)
if first_rank:
    print(table, f"at t = {frame.time}: stress from {frame['stress'][:, 0].min():.4g}", sep="\n")
    try:
        print(frame.to_pandas("position", "stress").head(), history.to_pandas().tail(), sep="\n")
    except pgimp.PgimpError as no_pandas:
        print(no_pandas)

# %% Plot: one rank is enough.
if first_rank:
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
    left.loglog(table["seconds"], table["error"], "o-")
    left.set(xlabel="time of all steps [s]", ylabel="error of the stress")
    right.plot(track["time"], track["stress"][:, 0])
    right.set(xlabel="time", ylabel=f"stress of particle {lowest}")
    figure.savefig("notebook.out/notebook.png")

# %% A material of one's own (fluid.py, beside this file), and a simulation driven step by step.
import fluid  # noqa: E402, F401

column = {
    "format": 1,
    "dimensions": 2,
    "grid": {"size": [6.0, 4.0], "cell": [0.25, 0.25]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
    "time": {"end": 1.0, "step": {"courant": 0.3}},
    "materials": {"water": {"model": "fluid", "bulk": 2.0e3, "shear": 0.1, "density": 1.0}},
    "bodies": {"dam": {"material": "water", "region": {"box": {"min": [0, 0], "max": [2, 2]}}}},
    "gravity": [0.0, -9.81],
    "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "slip"},
}
sim = pgimp.Simulation(column)
while not sim.finished:
    sim.advance(sim.time + 0.25)
    front = pgimp.world().allgather(sim.particles["position"][:, 0].max(initial=0.0))
    if first_rank:
        print(f"t = {sim.time:.3f} after {sim.steps} steps: the water is at x = {max(front):.2f}")
