"""The cases of metals: plates that meet, and a bar thrown at a wall."""

import numpy as np
from common import BLUE, RED, frame_at, plt, run, save


def plate_impact(redraw):
    """Stress and velocity along the plates at two instants, against the exact waves."""
    results = run("plate-impact", redraw)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
    for time, colour in ((1.3e-6, BLUE), (2.6e-6, RED)):
        frame = frame_at(results, time)
        x = 1e3 * frame["position"][:, 0]
        order = np.argsort(x)
        label = f"t = {1e6 * time:.1f} µs"
        axes[0].plot(x[order], -frame["stress"][order, 0] / 1e6, color=colour, label=label)
        axes[1].plot(x[order], frame["velocity"][order, 0], color=colour, label=label)
        ways = 1e3 * time * np.array([4607.76, 5856.36])
        place = np.array([-20.0, -ways[1], -ways[1], -ways[0], -ways[0], ways[0], ways[0], ways[1],
                          ways[1], 20.0])  # fmt: skip
        stress = np.array([0, 0, 700, 700, 1053.5, 1053.5, 700, 700, 0, 0])
        axes[0].plot(place, stress, "k--", lw=0.8, label="exact" if time > 2e-6 else None)
        jump = 15.2265
        speed = np.array([25, 25, 25 - jump, 25 - jump, 0, 0, jump - 25, jump - 25, -25, -25])
        axes[1].plot(place, speed, "k--", lw=0.8)
    axes[0].set(xlabel="x [mm]", ylabel="axial pressure [MPa]")
    axes[1].set(xlabel="x [mm]", ylabel="velocity [m/s]")
    axes[0].legend()
    save(figure, "plate-impact")


def taylor_bar(redraw):
    """The section y = 0 at four instants, coloured by the plastic strain; where energy goes."""
    results = run("taylor-bar", redraw)
    figure = plt.figure(figsize=(9, 4.4))
    grid = figure.add_gridspec(1, 6)
    axes = []
    for column, time in enumerate((0.0, 2e-5, 4e-5, 8e-5)):
        axis = figure.add_subplot(grid[0, column], aspect="equal")
        frame = frame_at(results, time)
        position, start = frame["position"], results.frame(0)
        cut = start["position"][:, 2] < 2.0 * start["radius"]  # the layer beside the section
        x, y = 1e3 * position[cut, 0], 1e3 * position[cut, 1]
        strain = frame["plastic-strain"][cut]
        for side in (1.0, -1.0):
            shown = axis.scatter(side * y, x, c=strain, s=7.0, marker="s", vmin=0.0, vmax=2.0,
                                 linewidths=0)  # fmt: skip
        axis.axhline(0.0, color="k", lw=1.0)
        axis.set(xlim=(-8, 8), ylim=(-1, 34), xlabel="[mm]", title=f"{1e6 * time:.0f} µs")
        axis.set_yticks((0, 10, 20, 30), ("0", "10", "20", "30") if not column else [""] * 4)
        axes.append(axis)
    figure.colorbar(shown, ax=axes, label="plastic strain", extend="max", shrink=0.8)
    axis = figure.add_subplot(grid[0, 4:])
    history = results.history
    for name, colour in (("kinetic-energy", BLUE), ("plastic-work", RED), ("strain-energy", "0.5")):
        axis.plot(1e6 * history["time"], 4.0 * history[name], color=colour, label=name)
    axis.set(xlabel="time [µs]", ylabel="energy of the whole bar [J]")
    axis.legend()
    save(figure, "taylor-bar")
