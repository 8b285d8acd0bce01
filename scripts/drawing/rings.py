"""The axisymmetric cases: a tube under pressure, and Taylor's bar as rings."""

import subprocess
import sys

import numpy as np
from common import BLUE, GREY, PICTURES, RED, ROOT, boxes, frame_at, plt, run, save, shrink


def tube(redraw):
    """Stresses and displacement over the radius at the end, against Lame's."""
    results = run("tube", redraw, ranks=1)
    frame = results.frame(-1)
    r = frame["position"][:, 0]
    order = np.argsort(r)
    x, a, b, p = np.linspace(0.5, 1.0, 60), 0.5, 1.0, 6.283185307e7
    part = p * a**2 / (b**2 - a**2)
    young, poisson = 1.661538461538e11, 0.03846153846154
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2))
    for column, sign, colour, label in ((0, -1, BLUE, "radial"), (2, 1, RED, "hoop")):
        axes[0].plot(r[order], frame["stress"][order, column] / 1e6, ".", color=colour, label=label)
        axes[0].plot(x, part * (1 + sign * b**2 / x**2) / 1e6, "k--", lw=0.8)
    moved = part * (1 + poisson) / young * ((1 - 2 * poisson) * x + b**2 / x)
    axes[1].plot(r[order], 1e3 * frame["displacement"][order, 0], ".", color=BLUE)
    axes[1].plot(x, 1e3 * moved, "k--", lw=0.8, label="exact")
    axes[0].set(xlabel="radius [m]", ylabel="stress [MPa]")
    axes[1].set(xlabel="radius [m]", ylabel="displacement [mm]", ylim=(0, None))
    axes[0].legend()
    axes[1].legend()
    save(figure, "tube")


def taylor_axisymmetric(redraw):
    """The section at four instants, to both sides of the axis; where energy goes."""
    results = run("taylor-axisymmetric", redraw)
    figure = plt.figure(figsize=(9, 4.4))
    grid = figure.add_gridspec(1, 6)
    axes = [figure.add_subplot(grid[0, column], aspect="equal") for column in range(4)]
    for axis, time in zip(axes, (0.0, 2e-5, 4e-5, 8e-5), strict=True):
        frame = frame_at(results, time)
        place, radius = 1e3 * frame["position"], 1e3 * frame["radius"]
        for side in (1.0, -1.0):
            mirrored = place * (side, 1.0, 1.0)
            shown = boxes(axis, mirrored, radius, frame["plastic-strain"], (0.0, 2.0))
        axis.axhline(0.0, color="k", lw=1.0)
        axis.axvline(0.0, color=GREY, lw=0.6, ls="-.")
        axis.set(xlim=(-8, 8), ylim=(-1, 34), xlabel="[mm]", title=f"{1e6 * time:.0f} µs")
        axis.set_yticks((0, 10, 20, 30), [""] * 4 if time else ("0", "10", "20", "30"))
    figure.colorbar(shown, ax=axes, label="plastic strain", extend="max", shrink=0.8)
    axis = figure.add_subplot(grid[0, 4:])
    history = results.history
    for name, colour in (("kinetic-energy", BLUE), ("plastic-work", RED), ("strain-energy", "0.5")):
        axis.plot(1e6 * history["time"], history[name], color=colour, label=name)
    axis.set(xlabel="time [µs]", ylabel="energy of the whole bar [J]")
    axis.legend(loc="center right")
    save(figure, "taylor-axisymmetric")


def taylor_contours(redraw):
    """The whole section at three instants as smooth contours, by ``pgimp plot``."""
    fields = ["output.fields=[plastic-strain,deformation]"]
    directory = run("taylor-axisymmetric", redraw, "taylor-contours", fields).path
    path = PICTURES / "taylor-contours.png"
    words = [sys.executable, "-m", "pgimp", "plot", directory, "--field", "plastic-strain"]
    words += ["--time", "0,2e-5,8e-5", "--mirror", "x-min", "--range", "0,2", "--contours"]
    subprocess.run([*words, "--map", "magma", "--width", "7", "-o", path], check=True)
    shrink(path)


def revolved_disk(redraw):
    """Three quarters of the spinning disk, by ``pgimp plot``."""
    words = ["--import", ROOT / "cases/spin.py"]
    directory = run("own/spinning-disk", redraw, "own-spinning-disk", words=words, ranks=1).path
    path = PICTURES / "revolved-disk.png"
    words = [sys.executable, "-m", "pgimp", "plot", directory, "--field", "stress.zz", "--revolve"]
    subprocess.run([*words, "-o", path], check=True)
    shrink(path)


def cone(redraw):
    """The clay round the cone, to both sides of the axis; the cone's factor over its way."""
    results = run("cone", redraw)
    coarse = run("cone", redraw, "cone-coarse", ["grid.cell=[0.5,0.5]", "output.every=26.0"])
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.2), width_ratios=(1.0, 1.6))
    frame = results.frame(-1)
    place, radius, strain = frame["position"], frame["radius"], frame["plastic-strain"]
    near = place[:, 0] < 6.0
    place, radius, strain = place[near], radius[near], strain[near]
    other = place * [-1.0, 1.0, 1.0]
    shown = boxes(axes[0], np.concatenate([other, place]), np.concatenate([radius, radius]),
                  np.concatenate([strain, strain]), (0.0, 2.0))  # fmt: skip
    tip = -10.0 + results.history["rigid.cone.displacement-y"][-1]
    shoulder = tip + np.sqrt(3.0)
    axes[0].fill([0.0, 1.0, 1.0, -1.0, -1.0], [tip, shoulder, 2.0, 2.0, shoulder], color=GREY)
    axes[0].set(xlim=(-6.0, 6.0), ylim=(-25.0, 1.5), xlabel="radius", ylabel="height",
                aspect="equal")  # fmt: skip
    figure.colorbar(shown, ax=axes[0], label="plastic strain", shrink=0.8, extend="max")
    for each, colour, name in ((coarse, RED, "2 cells"), (results, BLUE, "4 cells")):
        history = each.history
        way = -history["rigid.cone.displacement-y"]
        factor = np.convolve(history["rigid.cone.force-y"] / np.pi, np.full(5, 0.2), "same")
        axes[1].plot(way[2:-2], factor[2:-2], color=colour, lw=1.0, label=f"{name} to the radius")
    for value, name in ((9.73, "Teh and Houlsby"), (10.77, "Lu et al.")):
        axes[1].axhline(value, color="k", ls="--", lw=0.8)
        axes[1].text(0.08, value + 0.1, name, fontsize=8)
    axes[1].set(xlabel="way of the cone, in its radii", ylabel="force over c times area",
                xlim=(0.0, 10.3), ylim=(0.0, 12.0))  # fmt: skip
    axes[1].legend(loc="lower right")
    save(figure, "cone")
