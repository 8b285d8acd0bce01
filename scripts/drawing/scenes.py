"""The other cases: disks, incline, upsetting, pile, Hopkinson bar, bar."""

import numpy as np
from common import BLUE, GREY, RED, frame_at, instants, plt, run, save

from pgimp.utilities.plot.camera import camera
from pgimp.utilities.plot.rigid import draw_lines, lines


def energies(axis, results, unit):
    history = results.history
    for name, colour in (("kinetic", BLUE), ("strain", RED)):
        axis.plot(history["time"], history[f"{name}-energy"], color=colour, label=name)
    axis.set_xlabel("time [s]")
    axis.set_ylabel(f"energy [{unit}]")


def push(results, body):
    """Times, and the force along the diagonal that a history shows to act on a body in 2D."""
    history = results.history
    momentum = (history[f"body.{body}.momentum-x"] + history[f"body.{body}.momentum-y"]) / 2**0.5
    time = history["time"]
    return 0.5 * (time[1:] + time[:-1]), -np.diff(momentum) / np.diff(time)


def disks(redraw):
    """Three instants coloured by the von Mises stress, the energies, and the force."""
    results = run("disks", redraw)
    bonded = run("disks", redraw, "disks-bonded", [
        "contact=[]", "output.every=null", "bodies.left.formulation=updated-lagrangian",
        "bodies.right.formulation=updated-lagrangian",
    ])  # fmt: skip
    times = (1.5, 2.1, 3.6)
    top = np.percentile(frame_at(results, times[1])["von-mises"], 98.5)
    figure = plt.figure(figsize=(9, 5.6))
    above, below = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    axes = above.subplots(1, 3, subplot_kw={"aspect": "equal"})
    instants(
        axes, results, times, "von-mises", (0.0, top), {"label": "von Mises stress [Pa]"},
        "t = {:.2f} s", xlim=(-0.05, 1.05), ylim=(-0.05, 1.05), xlabel="x [m]", xticks=(0, 0.5, 1),
        yticks=(0, 0.5, 1),
    )  # fmt: skip
    axes[0].set_ylabel("y [m]")
    left, right = below.subplots(1, 2)
    energies(left, results, "J/m")
    total = results.history["kinetic-energy"] + results.history["strain-energy"]
    left.plot(results.history["time"], total, "k--", lw=1.0, label="sum")
    left.legend(loc="center left", ncol=1)
    right.axvline((0.6 * 2**0.5 - 0.4) / (0.2 * 2**0.5), color=GREY, lw=0.8)
    right.plot(*push(results, "left"), color=BLUE, label="with contact")
    right.plot(*push(bonded, "left"), color=RED, ls="--", lw=1.2, label="bonded")
    right.set(xlabel="time [s]", ylabel="force between the disks [N/m]", xlim=(1.3, 3.2))
    right.legend(loc="upper right", title="line: exact instant of touch", title_fontsize=8)
    save(figure, "disks")


def incline(redraw):
    """Three instants on the slope, coloured by velocity; velocity and friction against exact."""
    results = run("incline", redraw)
    angle, friction = np.radians(24.0), 0.3
    figure = plt.figure(figsize=(9, 4.4))
    grid = figure.add_gridspec(2, 2, height_ratios=(1.1, 1.0))
    axis = figure.add_subplot(grid[0, :], aspect="equal")
    for time in (0.0, 0.7, 1.0):
        frame = frame_at(results, time)
        along, across = frame["position"][:, :2].T
        place = np.stack([along * np.cos(angle) + across * np.sin(angle),
                          across * np.cos(angle) - along * np.sin(angle)], axis=1)  # fmt: skip
        shown = axis.scatter(*place.T, c=frame["velocity"][:, 0], s=4, vmin=0.0, vmax=1.4)
        axis.text(place[:, 0].mean() + 0.1, place[:, 1].mean() + 0.2, f"{frame.time:.1f} s")
    axis.plot([0.0, 1.7 * np.cos(angle)], [0.0, -1.7 * np.sin(angle)], "k-", lw=1.0)
    axis.set(xlabel="x [m]", ylabel="height [m]")
    figure.colorbar(shown, ax=axis, label="velocity [m/s]", shrink=0.9)
    history, weight = results.history, 9.81 * 120.0
    left, right = (figure.add_subplot(grid[1, column]) for column in (0, 1))
    left.plot(history["time"], history["momentum-x"] / history["mass"], color=BLUE, label="pgimp")
    gained = 9.81 * (np.sin(angle) - friction * np.cos(angle))
    left.plot([0.0, 1.0], [0.0, gained], "k--", lw=1.0, label="rigid block")
    left.set(xlabel="time [s]", ylabel="velocity [m/s]")
    left.legend()
    for name, colour, sign in (("y-min-y", BLUE, 1.0), ("y-min-x", RED, -1.0 / friction)):
        label = "across" if sign > 0.0 else "along the slope, over 0.3"
        right.plot(history["time"], sign * history[f"reaction.{name}"], color=colour, label=label)
    right.axhline(weight * np.cos(angle), color="k", ls="--", lw=1.0)
    right.set(xlabel="time [s]", ylabel="force of the slope [N/m]")
    right.legend(fontsize=9)
    save(figure, "incline")


def hertz(approach, young=1.0e6, poisson=0.3, radius=0.3):
    """Force between two rigid planes that approach each other across a cylinder, per thickness."""
    force = np.geomspace(1.0, 1.0e6, 2000)
    plane = young / (1.0 - poisson**2)
    half_width = np.sqrt(4.0 * force * radius / (np.pi * plane))
    both = 2.0 * force / (np.pi * plane) * (2.0 * np.log(4.0 * radius / half_width) - 1.0)
    return np.interp(approach, both, force, left=0.0)


def upsetting(redraw):
    """Three instants between die and punch; force against Hertz's, way against the punch's."""
    results = run("upsetting", redraw)
    figure = plt.figure(figsize=(9, 5.4))
    grid = figure.add_gridspec(2, 6, height_ratios=(1.0, 1.15))
    axes = [figure.add_subplot(grid[0, k : k + 2], aspect="equal") for k in (0, 2, 4)]

    def tools(axis, frame):
        start = frame["position"] - frame["displacement"]
        middle = np.abs(start[:, 0] - 0.45) < 0.0126  # two columns of particles
        axis.scatter(*frame["position"][middle, :2].T, s=1.0, color="w", zorder=3)
        draw_lines(axis, lines(frame, camera(None, 2, None)), True)
        # Once more, as what is drawn changes them.
        axis.set(xlim=(0.0, 1.1), ylim=(0.0, 0.8), title=f"t = {frame.time:.2f} s")

    instants(
        axes, results, (0.0, 0.35, 0.85), lambda frame: frame["von-mises"] / 1e3, (0.0, 250.0),
        {"label": "von Mises stress [kPa]"}, each=tools, xlabel="x [m]", yticks=(0, 0.4, 0.8),
    )  # fmt: skip
    axes[0].set_ylabel("y [m]")
    history = results.history
    left, right = figure.add_subplot(grid[1, :3]), figure.add_subplot(grid[1, 3:])
    approach = -history["rigid.punch.displacement-y"]
    force = 0.5 * (history["rigid.punch.force-y"] - history["rigid.die.force-y"])
    left.plot(1e3 * approach, force / 1e3, color=BLUE, label="mean of die and punch")
    ways = np.linspace(0.0, 0.09, 200)
    left.plot(1e3 * ways, hertz(ways) / 1e3, "k--", lw=1.0, label="Hertz")
    left.set(xlabel="approach of the punch [mm]", ylabel="force [kN/m]", xlim=(-5, 95))
    left.legend()
    way = history["body.bar.centre-x"] - 0.45
    right.plot(history["time"], way, color=BLUE, label="way of the centre")
    half = 0.5 * history["rigid.punch.displacement-x"]
    right.plot(history["time"], half, "k--", lw=1.0, label="half of the punch's way")
    right.set(xlabel="time [s]", ylabel="way along x [m]", ylim=(-0.01, 0.21))
    right.legend(loc="upper left")
    save(figure, "upsetting")


def pile(redraw):
    """Velocity of the hammer and the force on it, against exact; stress along the pile."""
    results = run("pile", redraw)
    history, decay = results.history, np.sqrt(30.0e9 * 2400.0) / 15600.0
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.0), layout="constrained")
    time = history["time"]
    exact = 5.0 * np.exp(-decay * time)
    back = 40.0 / np.sqrt(30.0e9 / 2400.0)
    force = 15600.0 * decay * exact / 1e6
    for axis, value, line, label in (
        (axes[0], -history["rigid.hammer.velocity-x"], exact, "velocity of the hammer [m/s]"),
        (axes[1], history["rigid.hammer.force-x"] / 1e6, force, "force on it [MPa]"),
    ):
        axis.plot(1e3 * time, value, color=BLUE, label="pgimp")
        axis.plot(1e3 * time[time < back], line[time < back], "k--", lw=1.0, label="exact")
        axis.set(xlabel="time [ms]", ylabel=label)
    axes[0].legend()
    for instant, colour, label in (
        (0.002, BLUE, (-35.0, 11.5)), (0.005, RED, (-35.0, 1.2)), (0.010, "0.5", (22.0, 16.3)),
    ):  # fmt: skip
        frame = frame_at(results, instant)
        stress = frame["stress"][:, 0] / 1e6
        axes[2].plot(stress, frame["position"][:, 0], color=colour, lw=1.2)
        axes[2].text(*label, f"{1e3 * frame.time:.0f} ms", color=colour)
    axes[2].set(xlabel="stress in the pile [MPa]", ylabel="height [m]")
    save(figure, "pile")


def hopkinson(redraw):
    """Stress at the gauges of both bars; at the specimen from three gauges, against exact."""
    probes = run("hopkinson", redraw).probes
    c, Z, Zs = (200e9 / 7800.0) ** 0.5, (200e9 * 7800.0) ** 0.5, (3e9 * 1200.0) ** 0.5
    way, r, pulse = 0.02 / (3e9 / 1200.0) ** 0.5, (Z - Zs) / (Z + Zs), -5e-6 * Z
    gauge = {name: (p["time"], p["stress-xx"] / 1e6) for name, p in probes.items()}
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for name, colour in (("front", BLUE), ("back", RED)):
        left.plot(1e6 * gauge[name][0], gauge[name][1], color=colour, lw=1.2, label=name)
    left.set(xlabel="time [us]", ylabel="stress at the gauges [MPa]")
    left.legend()
    t = np.linspace(0.0, 2e-4, 500)
    there = 1.1 / c + t

    def at(name, late):
        return np.interp(there + late / c, *gauge[name])

    ends = at("front", -0.55) + at("front", 0.55)
    for value, colour, label in (
        (ends, BLUE, "incident and reflected"), (at("middle", 0.0), "0.4", "specimen"),
        (at("back", 0.3), RED, "transmitted"),
    ):  # fmt: skip
        right.plot(1e6 * t, value, color=colour, lw=1.2, label=label)
    exact = pulse * (1.0 - r ** np.floor(t / way + 0.5))
    right.plot(1e6 * t, exact, "k--", lw=0.8, label="exact, specimen")
    right.set(xlabel="time since the pulse is there [us]", ylabel="stress of the specimen [MPa]")
    right.legend(fontsize=8)
    save(figure, "hopkinson")


def bar_displacement(place, time, gravity=9.81, speed=20.0, length=1.0):
    """Exact displacement of the bar's material points: sagged state less two waves of its form."""

    def sag(x):  # odd about the ceiling, even about the tip
        x = np.mod(x, 4.0 * length)
        half = np.mod(x, 2.0 * length)
        return np.where(x < 2.0 * length, 1.0, -1.0) * (length * half - 0.5 * half**2)

    waves = 0.5 * (sag(place + speed * time) + sag(place - speed * time))
    return gravity / speed**2 * (sag(place) - waves)


def bar_vibration(redraw):
    """Displacement of the lowest particle against the exact one, and the energies."""
    results = run("bar-vibration", redraw)
    last = results.follow(len(results.frame(0)) - 1)
    place = last["position"][0, 0]
    moved = last["displacement"][:, 0]
    fine = np.linspace(0.0, last["time"][-1], 1001)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2))
    left.plot(fine, 1e3 * bar_displacement(place, fine), "k-", lw=1.0, label="exact, 5 Hz")
    left.plot(last["time"], 1e3 * moved, "o", color=BLUE, ms=3, label="pgimp")
    left.set(xlabel="time [s]", ylabel="displacement of the tip [mm]", ylim=(-1, 31))
    left.legend(ncol=2, loc="upper center")
    energies(right, results, "J per m$^2$ of section")
    history = results.history
    right.plot(history["time"], history["external-work"], "k--", lw=1, label="work of gravity")
    right.set(ylim=(-2, 205))
    right.legend(ncol=3, loc="upper center", fontsize=9, columnspacing=1.0)
    print(f"pictures: greatest error {np.abs(moved - bar_displacement(place, last['time'])).max()}")
    save(figure, "bar-vibration")


def graded(redraw):
    """Stiffness of the ground over the depth; settlement and stress against the exact ones."""
    frame = run("graded", redraw, ranks=1).frame(-1)
    young, rise, high, weight = 20.0e6, 4.0e6, 20.0, 9.81 * 2000.0
    u = frame["displacement"][:, 0]
    depth = high - (frame["position"][:, 0] - u)
    far = np.linspace(0.0, high, 200)
    E = young + rise * far
    exact = weight / rise * (high - far - young / rise * np.log((young + rise * high) / E))
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.4), sharey=True)
    axes[0].plot(1e-6 * frame["parameter-young"], depth, ".", ms=4, color=BLUE)
    axes[0].set(xlabel="Young's modulus [MPa]", ylabel="depth [m]", xlim=(0.0, 110.0))
    axes[1].plot(-1e3 * u, depth, ".", ms=4, color=BLUE, label="pgimp")
    axes[1].plot(1e3 * exact, far, "k--", lw=1.0, label="exact")
    axes[1].set(xlabel="settlement [mm]")
    axes[1].legend(loc="lower right")
    axes[2].plot(-1e-3 * frame["stress"][:, 0], depth, ".", ms=4, color=BLUE)
    axes[2].plot(1e-3 * weight * far, far, "k--", lw=1.0)
    axes[2].set(xlabel="pressure [kPa]", ylim=(high, 0.0))
    save(figure, "graded")
