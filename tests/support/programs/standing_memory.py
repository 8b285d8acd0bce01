"""``python standing_memory.py CASE FOLDER``: anonymous memory of a run between its steps, and most.

FOLDER/found.json has the number of particles, the bytes of the grid, and the bytes after some steps
(`standing`). Then the most during further steps (`steps`), lines of the history (`lines`), frames,
and checkpoints.
"""

import json
import sys
from pathlib import Path

from pgimp.case.load import load
from pgimp.mpi.comm import Serial
from pgimp.running.checkpoints import Checkpoints
from pgimp.running.frames import Frames
from pgimp.solver.simulation import Simulation


def memory(name):
    status = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return int(status[name].split()[0]) * 1024


def most(do):
    """Most memory during an action, without pages of files."""
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    do()
    return memory("VmHWM") - memory("RssFile")


case, folder = load(sys.argv[1]), Path(sys.argv[2])
sim = Simulation(case, Serial())
for _ in range(20):
    sim.advance()
for name in ("frames", "checkpoints"):
    (folder / name).mkdir(exist_ok=True)
frames, checkpoints = Frames(folder, case, sim), Checkpoints(folder, case, sim)
grid = sim.rank.grid
found = {
    "particles": sim.rank.count,
    "grid": grid.G.nbytes + grid.motion.values.nbytes,
    "standing": memory("RssAnon"),
    "steps": most(sim.advance),
    "lines": most(sim.diagnostics),
    "frames": most(lambda: frames.write(sim)),
    "checkpoints": most(lambda: checkpoints.write(sim, 1, 0)),
}
frames.finish()
(folder / "found.json").write_text(json.dumps(found))
