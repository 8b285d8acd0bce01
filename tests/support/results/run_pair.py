"""Two runs with the same content."""

import shutil

from particle_source import Lines, make_case, make_sim

from pgimp.io.results.history import History
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.mpi.comm import Serial
from pgimp.running.frames import Frames

#: Particles.
COUNT = 31


def run_pair(folder):
    """Two run directories of three frames and three lines with the same content."""
    directory = RunDirectory(folder / "one", Serial())
    directory.prepare({}, {"state": "done", "began": "now", "steps": 2})
    sim, _ = make_sim(Serial(), COUNT, 3)
    frames = Frames(folder / "one", make_case(), sim)
    lines, history = Lines(), History(folder / "one" / "history.csv")
    for step in range(3):
        sim.step = lines.step = step
        sim.time = lines.time = 0.1 * step
        frames.write(sim)
        history.write(lines)
    frames.finish()
    history.close()
    directory.release()
    shutil.copytree(folder / "one", folder / "two")
    return folder / "one", folder / "two"
