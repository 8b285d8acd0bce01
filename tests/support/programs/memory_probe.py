"""``python memory_probe.py CASE FOLDER``: takes steps, writes a frame and a checkpoint.

Each rank leaves in FOLDER/RANK.json the most memory that it had from the start of the simulation
on, and what was estimated, in bytes.
"""

import json
import sys
from pathlib import Path

from pgimp.case.load import load
from pgimp.mpi.comm import world
from pgimp.running.checkpoints import Checkpoints
from pgimp.running.frames import Frames
from pgimp.solver.decomposition import resort
from pgimp.solver.simulation import Simulation
from pgimp.solver.start import created

comm, case, folder = world(), load(sys.argv[1]), Path(sys.argv[2])
estimates, require = [], created.require
created.require = lambda *args: estimates.append(require(*args))
sim = Simulation(case, comm)
for _ in range(3):
    sim.advance()
resort(sim.rank, sim.balance, sim.reduction, sim.step)
sim.diagnostics()
if comm.rank == 0:
    for name in ("frames", "checkpoints"):
        (folder / name).mkdir()
comm.Barrier()
Frames(folder, case, sim).write(sim)
Checkpoints(folder, case, sim).write(sim, 1, 0)
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
peak = int(status["VmHWM"].split()[0]) * 1024
told = [estimate.size for estimate in estimates]
(folder / f"{comm.rank}.json").write_text(json.dumps({"peak": peak, "estimates": told}))
