"""Running cases and saving pictures: what all drawings share."""

import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from PIL import Image

import pgimp
from pgimp.utilities.plot import style
from pgimp.utilities.plot.camera import camera
from pgimp.utilities.plot.selection import Block
from pgimp.utilities.plot.visible import draw

ROOT = Path(__file__).resolve().parents[2]
#: Where all find what studies share.
sys.path.append(str(ROOT / "scripts"))
RUNS = ROOT / "pictures.out"
PICTURES = ROOT / "cases" / "pictures"
LARGE = 140_000  # bytes
BLUE, RED, GREEN, ORANGE, GREY = style.BLUE, style.RED, style.GREEN, style.ORANGE, style.GREY
plt.rcParams.update(style.STYLE)


def run(case, redraw, name=None, overrides=(), ranks=2, words=()):
    """Run cases/CASE.yaml, unless it is only to be drawn again; `words` are further options."""
    directory = RUNS / f"{name or case}.out"
    if not (redraw and directory.exists()):
        words = [ROOT / "scripts/run", ROOT / f"cases/{case}.yaml", "-n", str(ranks), *words]
        words += ["-o", directory, "--overwrite"]
        for override in overrides:
            words += ["--set", override]
        subprocess.run(words, check=True)
    return pgimp.open(directory)


def frame_at(results, time):
    """Return the first frame at or after a time."""
    return results.frame(int(np.searchsorted(results.times, time - 1e-9)))


def boxes(axis, position, radius, values, limits, colours=style.MAP, dimension=2):
    """Draw particles as boxes of their size, in 3D from a corner, coloured between two limits."""
    eye = camera(None, dimension, None)
    shown = ScalarMappable(Normalize(*limits), colours)
    none, edges = np.empty(len(radius)), np.empty((len(radius), 0, 0))
    drawn = Block(none, position, radius, values, none, edges)
    draw(axis, eye, drawn, shown.to_rgba(values), dimension < 3)
    axis.grid(False)
    return shown


def particles(axis, frame, values, limits, rows=slice(None), colours=style.MAP, dimension=2):
    """Draw particles of a frame, coloured by a field or by what a function finds of the frame."""
    found = frame[values] if isinstance(values, str) else values(frame)
    place, radius = frame["position"][rows], frame["radius"][rows]
    return boxes(axis, place, radius, found[rows], limits, colours, dimension)


def instants(axes, results, times, values, limits, bar, title="t = {:g} s", loc="center",
             each=None, dimension=2, **look):  # fmt: skip
    """Draw frames at some times with one bar; `each` adds to an axis, with its frame."""
    for axis, time in zip(axes, times, strict=True):
        frame = frame_at(results, time)
        shown = particles(axis, frame, values, limits, dimension=dimension)
        axis.set(**look)
        axis.set_title(title.format(frame.time), fontsize=10, loc=loc)
        if each:
            each(axis, frame)
    axes[0].figure.colorbar(shown, ax=list(axes), **{"shrink": 0.85, "extend": "max"} | bar)


def speed(frame):
    """Speeds of particles in the plane."""
    return np.hypot(*frame["velocity"][:, :2].T)


def save(figure, name):
    PICTURES.mkdir(exist_ok=True)
    path = PICTURES / f"{name}.png"
    figure.savefig(path)
    plt.close(figure)
    shrink(path)


def shrink(path):
    """Make a PNG smaller: without the alpha channel by a fifth, a large one by a palette."""
    image = Image.open(path).convert("RGB")
    image.save(path, optimize=True)
    if path.stat().st_size > LARGE:
        palette = image.quantize(256, Image.Quantize.MAXCOVERAGE, 3)
        # Without dithering scales of colours have steps.
        image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(
            path, optimize=True
        )
    print(f"pictures: {path.relative_to(ROOT)}, {path.stat().st_size // 1024} kB")
