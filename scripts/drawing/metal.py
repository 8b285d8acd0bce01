"""The cases of metals: plates that meet, a bar thrown at a wall, a tube under pressure."""

import numpy as np
from common import BLUE, GREY, RED, frame_at, particles, plt, run, save


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
        place = np.array([-20.0, *-ways.repeat(2)[::-1], *ways.repeat(2), 20.0])
        stress = np.repeat([0, 700, 1053.5, 700, 0], 2)
        axes[0].plot(place, stress, "k--", lw=0.8, label="exact" if time > 2e-6 else None)
        speed = np.repeat([25, 25 - 15.2265, 0, 15.2265 - 25, -25], 2)
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
    axes = [figure.add_subplot(grid[0, column], aspect="equal") for column in range(4)]
    for axis, time in zip(axes, (0.0, 2e-5, 4e-5, 8e-5), strict=True):
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
        axis.set_yticks((0, 10, 20, 30), [""] * 4 if time else ("0", "10", "20", "30"))
    figure.colorbar(shown, ax=axes, label="plastic strain", extend="max", shrink=0.8)
    axis = figure.add_subplot(grid[0, 4:])
    history = results.history
    for name, colour in (("kinetic-energy", BLUE), ("plastic-work", RED), ("strain-energy", "0.5")):
        axis.plot(1e6 * history["time"], 4.0 * history[name], color=colour, label=name)
    axis.set(xlabel="time [µs]", ylabel="energy of the whole bar [J]")
    axis.legend()
    save(figure, "taylor-bar")


def thick_tube(redraw):
    """Where the tube has yielded at two instants, and Hill's front; pressure over displacement."""
    results = run("thick-tube", redraw)
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.2), width_ratios=(1.0, 1.0, 1.3))
    start = np.hypot(*results.frame(0)["position"].T)
    outer = (start > 1.9) & (results.frame(0)["body"] == 0)
    deep = (start < 0.8) & (results.frame(0)["position"][:, 1] > 0.6)

    def moved(frame):  # of the outer surface, which goes with 1/r
        return np.mean((np.hypot(*frame["position"][outer].T) - start[outer]) * start[outer]) / 2.0

    k, stiff, turn = 1.0 / np.sqrt(3.0), 500.0 / (1.0 - 0.3**2), np.linspace(0.0, 0.5 * np.pi, 40)
    for axis, time in zip(axes[:2], (1.3, 2.5), strict=True):
        frame = frame_at(results, time)
        tube = frame["body"] == 0
        particles(axis, frame, lambda frame: np.zeros(len(frame)), (-2.0, 1.0), ~tube, "Greys")
        shown = particles(axis, frame, "plastic-strain", (0.0, 0.006), tube)
        front = min(2.0, np.sqrt(moved(frame) * stiff / k))
        axis.plot(front * np.cos(turn), front * np.sin(turn), "--", color="w", lw=1.5)
        axis.set(xlim=(0, 2.1), ylim=(0, 2.1), aspect="equal", title=f"t = {time}")
    figure.colorbar(shown, ax=axes[:2], label="plastic strain", shrink=0.8, extend="max")
    frames = [results.frame(n) for n in range(len(results))]
    way = [1e3 * moved(frame) for frame in frames]
    axes[2].plot(way, [frame["pressure"][deep].mean() for frame in frames], ".", color=BLUE,
                 label="pgimp")  # fmt: skip
    c = np.linspace(1.0, 2.0, 50)
    exact = k * (2.0 * np.log(c) + 1.0 - c**2 / 4.0)
    axes[2].plot(1e3 * k * c**2 / stiff, exact, "k--", lw=1.0, label="Hill")
    axes[2].plot([0.0, 1e3 * k / stiff], [0.0, exact[0]], "k--", lw=1.0)
    axes[2].axhline(exact[-1], color=GREY, ls=":", lw=1.0)
    axes[2].set(xlabel="outer displacement over a / 1000", ylabel="pressure over Y", ylim=(0, 0.9))
    axes[2].legend(loc="lower right")
    save(figure, "thick-tube")
