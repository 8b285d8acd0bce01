"""The first case as its users see it: through ``pgimp plot`` and cases/in_paraview.py."""

import os
import shutil
import subprocess
import sys

from common import PICTURES, ROOT, run, shrink

STRESS = ["--field", "von-mises"]


def block3d(redraw):
    """Four instants of the block, and its history."""
    directory = run("block3d", redraw).path
    instants = [*STRESS, "--time", "0,0.32,0.46,0.6", "--range", "0,6e4"]
    for name, options in (("block3d", instants), ("block3d-history", [])):
        path = PICTURES / f"{name}.png"
        words = [sys.executable, "-m", "pgimp", "plot", directory, *options, "-o", path]
        subprocess.run(words, check=True)
        shrink(path)


def block3d_initial(redraw):
    """The same instants on cells of half the size."""
    changes = ["grid.cell=[0.04,0.04,0.04]", "time.end=0.62"]
    directory = run("block3d", redraw, "block3d-initial", changes).path
    path = PICTURES / "block3d-initial.png"
    words = [sys.executable, "-m", "pgimp", "plot", directory, *STRESS]
    words += ["--time", "0,0.32,0.46,0.6", "--range", "0,6e4", "-o", path]
    subprocess.run(words, check=True)
    shrink(path)


def block3d_paraview(redraw):
    """The block in ParaView, when it is compressed most."""
    directory = run("block3d", redraw).path
    path = PICTURES / "block3d-paraview.png"
    words = ["pvpython", ROOT / "cases/in_paraview.py", directory, *STRESS, "--frame", "16"]
    words += ["--range", "0", "6e4", "--scale", "1.2", "--size", "800x500", "-o", path]
    if not shutil.which("pvpython"):
        sys.exit("pictures: block3d-paraview needs ParaView: scripts/setup --test installs it")
    if not os.environ.get("DISPLAY"):
        words = ["xvfb-run", "-a", *words]
    # The variables of this environment are not for ParaView's own Python.
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL_ENV"))}
    subprocess.run(words, check=True, env=clean)
    shrink(path)
