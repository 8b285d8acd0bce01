"""Cases of flows without ends: between plates, down an incline, vortices."""

import numpy as np
from common import BLUE, GREEN, GREY, ORANGE, RED, ROOT, frame_at, instants, plt, run, save, speed


def poiseuille(redraw):
    """Profiles at four instants, and how far they are off."""
    results = run("poiseuille", redraw, ranks=1)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6))
    g, nu, high = 9.81, 24.76136e-3, 0.1
    across = np.linspace(0.0, high, 201)

    def exact(y, t):
        v = g * y * (high - y) / (2.0 * nu)
        for n in range(1, 60, 2):
            size = 4.0 * g * high**2 / (nu * (np.pi * n) ** 3)
            v = v - size * np.sin(n * np.pi * y / high) * np.exp(-nu * (n * np.pi / high) ** 2 * t)
        return v

    for time, colour in ((0.025, BLUE), (0.05, GREEN), (0.1, ORANGE), (0.25, RED)):
        frame = frame_at(results, time)
        y, v = frame["position"][:, 1], frame["velocity"][:, 0]
        axes[0].plot(1e3 * y, v, ".", ms=4, color=colour, label=f"t = {time:g} s")
        axes[0].plot(1e3 * across, exact(across, frame.time), "k--", lw=0.9)
        off = 1e3 * (v - exact(y, frame.time))
        order = np.argsort(y)
        axes[1].plot(1e3 * y[order], off[order], ".-", ms=4, lw=0.8, color=colour)
    axes[0].set(xlabel="y [mm]", ylabel="velocity [m/s]")
    axes[0].legend(loc="lower center", ncols=2)
    axes[1].set(xlabel="y [mm]", ylabel="difference from the exact one [mm/s]")
    save(figure, "poiseuille")


def bagnold(redraw):
    """Profiles of velocity and pressure, against those of the steady flow."""
    results = run("bagnold", redraw, ranks=1)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), width_ratios=(1.5, 1.0))
    slope, high = np.radians(24.0), 0.04
    weight, t = 9.81 * np.cos(slope), np.tan(slope)
    number = 0.279 * (t - 0.38) / (0.64 - t)
    top = 2.0 / 3.0 * number / 0.002 * np.sqrt(0.6 * weight) * high**1.5
    y = np.linspace(0.0, high, 200)
    for time, colour in ((0.0, GREY), (0.5, GREEN), (1.0, ORANGE), (4.0, BLUE)):
        frame = frame_at(results, time)
        place = 1e3 * frame["position"][:, 1]
        axes[0].plot(frame["velocity"][:, 0], place, ".", ms=4, color=colour, label=f"{time:g} s")
    axes[0].plot(top * (1.0 - (1.0 - y / high) ** 1.5), 1e3 * y, "k--", lw=1.0, label="Bagnold")
    axes[0].set(xlabel="velocity [m/s]", ylabel="height [mm]", xlim=(0.0, 0.65), ylim=(0.0, 42.0))
    axes[0].legend()
    axes[1].plot(frame["pressure"], place, ".", ms=4, color=BLUE)
    axes[1].plot(1500.0 * weight * (high - y), 1e3 * y, "k--", lw=1.0)
    axes[1].set(xlabel="pressure [Pa]", xlim=(0.0, None), ylim=(0.0, 42.0))
    save(figure, "bagnold")


def own_taylor_green(redraw):
    """Three instants coloured by speed, and the kinetic energy."""
    words = ["--import", ROOT / "cases/vortices.py"]
    results = run("own/taylor-green", redraw, "own-taylor-green", words=words)
    figure = plt.figure(figsize=(9, 6.0))
    grid = figure.add_gridspec(2, 3, height_ratios=(1.0, 0.8))
    axes = [figure.add_subplot(grid[0, k], aspect="equal") for k in range(3)]
    instants(
        axes, results, (0.0, 0.2, 0.5), speed, (0.0, 1.0), {"label": "speed"}, "t = {:.1f}",
        "left", xlim=(0.0, 1.0), ylim=(0.0, 1.0),
    )  # fmt: skip
    axis, history = figure.add_subplot(grid[1, :]), results.history
    time, energy = history["time"], history["kinetic-energy"]
    axis.plot(time, energy, color=BLUE, label="pgimp")
    axis.plot(time, 0.25 * np.exp(-16.0 * np.pi**2 * 0.02 * time), "k--", lw=1.0, label="exact")
    axis.set(xlabel="time", ylabel="kinetic energy", xlim=(0.0, 0.5), ylim=(0.0, 0.26))
    axis.legend()
    save(figure, "own-taylor-green")
