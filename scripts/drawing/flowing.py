"""Cases of soils, fluids, gases: Sod's tube, channel, sand, banks, footing, dam break, jet."""

import numpy as np
from common import BLUE, GREY, ORANGE, RED, frame_at, instants, particles, plt, run, save, speed


def sod(redraw):
    """Pressure, velocity and density at the end, and the exact plateaus."""
    results = run("sod", redraw, ranks=1)
    frame, t = results.frame(-1), 0.2
    x = frame["position"][:, 0]
    head, tail = -np.sqrt(1.4) * t, (0.927453 - np.sqrt(1.4 * 0.303130 / 0.426319)) * t
    contact, shock = 0.927453 * t, 1.752156 * t
    ends = np.array([-0.5, head, tail, contact, contact, shock, shock, 0.5])
    exact = {
        "pressure": (1.0, 1.0, 0.303130, 0.303130, 0.303130, 0.303130, 0.1, 0.1),
        "velocity": (0.0, 0.0, 0.927453, 0.927453, 0.927453, 0.927453, 0.0, 0.0),
        "density": (1.0, 1.0, 0.426319, 0.426319, 0.265574, 0.265574, 0.125, 0.125),
    }
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.2))
    inside = np.linspace(head, tail, 40)
    u = 2.0 / 2.4 * (np.sqrt(1.4) + inside / t)
    c = np.sqrt(1.4) - 0.2 * u
    fan = {"velocity": u, "density": (c / np.sqrt(1.4)) ** 5, "pressure": (c / np.sqrt(1.4)) ** 7}
    for axis, (name, values) in zip(axes, exact.items(), strict=True):
        own = frame[name][:, 0] if name == "velocity" else frame[name]
        axis.plot(x, own, ".", ms=2.5, color=BLUE, label="pgimp")
        axis.plot(ends[2:], values[2:], "k--", lw=0.9, label="exact")
        axis.plot(ends[:2], values[:2], "k--", lw=0.9)
        axis.plot(inside, fan[name], "k--", lw=0.9)
        axis.set(xlabel="x", title=name, xlim=(-0.5, 0.5))
    axes[0].legend()
    save(figure, "sod")


def channel(redraw):
    """Profiles of Bingham's and Newton's fluid across the channel, and the column."""
    law = "{model: newtonian, bulk: 5.0e4, density: 1000.0, shear-viscosity: 24.76136, "
    changed = [f"materials.mud={law}tension: true}}", "time.end=0.1"]
    mud, water = run("channel", redraw), run("channel", redraw, "channel-newtonian", changed)
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.0), width_ratios=(1.0, 2.2))
    shown = particles(axes[0], mud.frame(-1), lambda frame: frame["velocity"][:, 1], (0.0, 0.2))
    axes[0].set(xlim=(-0.08, 0.08), ylim=(1.45, 1.15), xlabel="x [m]", ylabel="y, downwards [m]")
    figure.colorbar(shown, ax=axes[0], label="velocity of the mud [m/s]", shrink=0.9)
    across = np.linspace(-0.05, 0.05, 201)
    far = np.maximum(np.abs(across), 0.02)
    exact = 9810.0 / (2.0 * 24.76136) * (0.03**2 - (far - 0.02) ** 2)
    t, parabola = water.frame(-1).time, 9810.0 / (2.0 * 24.76136) * (0.05**2 - across**2)
    for k in range(30):
        q = 2 * k + 1
        size = 16.0 * 9810.0 * 0.05**2 / (24.76136 * np.pi**3 * q**3) * (-1) ** k
        parabola -= size * np.cos(0.5 * q * np.pi * across / 0.05) * np.exp(-q * q * t / 0.040919)
    for results, colour, name, curve in (
        (mud, BLUE, "Bingham", exact), (water, RED, "Newton", parabola)
    ):  # fmt: skip
        frame = results.frame(-1)
        x, v = frame["position"], frame["velocity"][:, 1]
        middle = np.abs(x[:, 1] - x[:, 1].mean()) < 0.05
        axes[1].plot(x[middle, 0], v[middle], ".", ms=4, color=colour, label=name)
        axes[1].plot(across, curve, "k--", lw=1.0)
    axes[1].set(xlabel="x [m]", ylabel="velocity at half the height [m/s]")
    axes[1].legend()
    save(figure, "channel")


def sand_column(redraw):
    """Four instants coloured by speed."""
    figure, axes = plt.subplots(4, 1, figsize=(9, 8.2), sharex=True)
    instants(
        axes, run("sand-column", redraw), (0.0, 0.2, 0.4, 1.0), speed, (0.0, 2.5),
        {"label": "speed [m/s]", "shrink": 0.8}, "t = {:.2f} s", "left", xlim=(-1.8, 1.8),
        ylim=(0.0, 0.85), ylabel="y [m]", aspect="equal",
    )  # fmt: skip
    axes[-1].set_xlabel("x [m]")
    save(figure, "sand-column")


def _sheared(axis, frame, limits, title):
    """Where a bank is sheared, and its first surface."""
    shown = particles(axis, frame, "plastic-shear", limits)
    axis.plot([0.0, 4.0, 4.0, 9.0], [3.0, 3.0, 1.0, 1.0], "--", color=GREY, lw=1.0)
    axis.set(xlim=(0.0, 9.0), ylim=(0.0, 3.3), ylabel="y [m]", aspect="equal")
    axis.set_title(f"{title}, t = {frame.time:.1f} s", fontsize=10, loc="left")
    return shown


def slope(redraw):
    """The bank that slides, and that of stiffer clay: where it is sheared."""
    weak = run("slope", redraw)
    strong = run("slope", redraw, "slope-strong", ["materials.clay.cohesion=13.0e3"])
    figure, axes = plt.subplots(2, 1, figsize=(9, 6.6), sharex=True)
    for axis, results, name in ((axes[0], weak, "7"), (axes[1], strong, "13")):
        shown = _sheared(axis, results.frame(-1), (0.0, 1.0), f"c = {name} kPa")
    axes[1].set_xlabel("x [m]")
    figure.colorbar(shown, ax=axes, label="plastic shear", shrink=0.8, extend="max")
    save(figure, "slope")


def excavation(redraw):
    """The cut that stands and the cut that slides: where they are sheared; the way of the edge."""
    results = run("excavation", redraw)
    figure = plt.figure(figsize=(9, 8.4))
    grid = figure.add_gridspec(3, 1, height_ratios=(1.0, 1.0, 0.8))
    axes = [figure.add_subplot(grid[k]) for k in (0, 1)]
    for axis, time, state in zip(
        axes, (1.5, 2.5), ("dug out, c = 13 kPa", "weak, c = 7 kPa"), strict=True
    ):
        shown = _sheared(axis, frame_at(results, time), (0.0, 0.3), state)
    figure.colorbar(shown, ax=axes, label="plastic shear", shrink=0.8, extend="max")
    axis = figure.add_subplot(grid[2])
    edge = results.probes["edge"]
    axis.plot(edge["time"], edge["displacement-x"], color=BLUE, label="edge, towards the pit")
    axis.plot(edge["time"], -edge["displacement-y"], color=ORANGE, label="edge, downwards")
    for begin in (0.6, 0.9, 1.5):
        axis.axvline(begin, color=GREY, ls="--", lw=1.0)
    axis.set(xlabel="time [s]", ylabel="displacement [m]", xlim=(0.0, 2.5))
    axis.legend(frameon=False)
    save(figure, "excavation")


def safety(redraw):
    """The slope that stands with less strength, and slides with still less: where it is sheared."""
    results = run("safety", redraw)
    figure, axes = plt.subplots(2, 1, figsize=(9, 5.6), sharex=True)
    stands = [frame for frame in results if frame.time < 0.1][-1]
    for axis, frame, most, state in (
        (axes[0], stands, 0.002, "strength over 1.35, at rest"),
        (axes[1], results.frame(-1), 1.0, "strength over 1.5, t = 3 s"),
    ):
        shown = particles(axis, frame, "plastic-shear", (0.0, most))
        axis.plot([0.0, 12.5, 32.5], [10.0, 10.0, 0.0], "--", color=GREY, lw=1.0)
        axis.set(xlim=(0.0, 37.5), ylim=(0.0, 10.5), ylabel="y [m]", aspect="equal")
        axis.set_title(state, fontsize=10, loc="left")
        figure.colorbar(shown, ax=axis, label="plastic shear", shrink=0.9, extend="max")
    axes[1].set_xlabel("x [m]")
    save(figure, "safety")


def footing(redraw):
    """Where clay flows under a strip, and Prandtl's mechanism; the pressure over the settlement."""
    mean = run("footing", redraw)
    locked = run("footing", redraw, "footing-locked", ["method.volumetric=pointwise"])
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), width_ratios=(1.7, 1.0))
    frame, half, deep = mean.frame(-1), 1.05, 2.0
    shown = particles(axes[0], frame, "plastic-strain", (0.0, 0.02))
    axes[0].plot([0.0, half, half, 0.0], [deep, deep, 2.35, 2.35], color="k", lw=1.5)
    turn = np.linspace(1.25, 1.75, 31) * np.pi  # the fan about the edge
    fan = np.sqrt(2.0) * half * np.stack([np.cos(turn), np.sin(turn)]) + [[half], [deep]]
    x, y = [0.0, *fan[0], 3.0 * half], [deep - half, *fan[1], deep]
    axes[0].plot(x, y, "--", color="w", lw=1.2)
    for way in (fan[:, 0], fan[:, -1]):
        axes[0].plot([half, way[0]], [deep, way[1]], "--", color="w", lw=1.2)
    axes[0].set(xlim=(0.0, 4.0), ylim=(0.0, 2.4), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    figure.colorbar(shown, ax=axes[0], label="plastic strain", shrink=0.8, extend="max")
    for results, colour, name in ((mean, BLUE, "b-bar"), (locked, RED, "pointwise")):
        history = results.history
        pressure = history["rigid.strip.force-y"] / (half * 1.0e4)
        down = -1e3 * history["rigid.strip.displacement-y"]
        axes[1].plot(down, pressure, color=colour, label=f"volumetric: {name}")
    axes[1].axhline(2.0 + np.pi, color="k", ls="--", lw=1.0, label="2 + π")
    axes[1].set(xlabel="settlement [mm]", ylabel="pressure over c", xlim=(0, 18), ylim=(0, 8))
    axes[1].legend()
    save(figure, "footing")


def dam_break(redraw):
    """Four instants coloured by speed; and the front against Ritter's."""
    results = run("dam-break", redraw)
    figure = plt.figure(figsize=(9, 7.6))
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 1.0, 1.0))
    axes = [figure.add_subplot(grid[k // 2, k % 2], aspect="equal") for k in range(4)]
    instants(
        axes, results, (0.2, 0.5, 0.9, 1.6), speed, (0.0, 4.0), {"label": "speed [m/s]"},
        "t = {:.1f} s", "left", xlim=(0.0, 3.22), ylim=(0.0, 1.8),
    )  # fmt: skip
    axis = figure.add_subplot(grid[2, :])
    history, weight = results.history, 1000.0 * 0.72 * 9.81
    time, wall = history["time"], -history["reaction.x-max-x"]
    axis.plot(time, history["reaction.y-min-y"], color=BLUE, label="floor")
    axis.plot(time, wall, color=ORANGE, label="far wall, against the water")
    axis.axhline(weight, color="k", ls="--", lw=1.0)
    axis.set(xlabel="time [s]", ylabel="force [N/m]")
    axis.legend(loc=(0.22, 0.26))
    save(figure, "dam-break")


def jet(redraw):
    """Four instants coloured by speed, and the force on the plate against the jet's momentum."""
    results = run("jet", redraw)
    figure = plt.figure(figsize=(9, 6.4))
    grid = figure.add_gridspec(2, 4, height_ratios=(1.0, 0.9))
    axes = [figure.add_subplot(grid[0, k], aspect="equal") for k in range(4)]
    instants(
        axes, results, (0.1, 0.2, 0.3, 1.0), speed, (0.0, 2.5), {"label": "speed [m/s]"},
        "t = {:.1f} s", "left", xlim=(0.0, 0.4), ylim=(0.0, 0.4),
    )  # fmt: skip
    axis = figure.add_subplot(grid[1, :])
    history = results.history
    time, force = history["time"], history["reaction.y-min-y"]
    axis.plot(time, force, color=GREY, lw=0.8, label="plate")
    late = time > 0.3
    mean = np.cumsum(force[late]) / np.arange(1, late.sum() + 1)
    axis.plot(time[late], mean, color=BLUE, label="its mean since t = 0.3 s")
    axis.axhline(200.0, color="k", ls="--", lw=1.0)
    axis.set(xlabel="time [s]", ylabel="force [N/m]", ylim=(0.0, 400.0))
    axis.legend(loc="lower right")
    save(figure, "jet")


def hopper(redraw):
    """Four instants coloured by speed, and the flux through the outlet against Beverloo's law."""
    results = run("hopper", redraw)
    figure = plt.figure(figsize=(9, 7.2))
    grid = figure.add_gridspec(2, 4, height_ratios=(1.5, 0.9))
    axes = [figure.add_subplot(grid[0, k], aspect="equal") for k in range(4)]
    instants(
        axes, results, (0.2, 0.5, 0.8, 1.1), speed, (0.0, 2.5), {"label": "speed [m/s]"},
        "t = {:.1f} s", "left", xlim=(0.0, 0.12), ylim=(0.0, 0.5),
    )  # fmt: skip
    for axis in axes:
        axis.plot([0.16, 0.03, 0.03, 0.16], [0.08, 0.08, 0.1, 0.23], color="k", lw=1.2)
        axis.axhspan(0.0, 0.03, color=GREY, alpha=0.3, lw=0)
    axis = figure.add_subplot(grid[1, :])
    history, law = results.history, 0.5 * 1500.0 * np.sqrt(9.81) * (0.06 - 1.4e-3) ** 1.5
    axis.axhspan(law, 1.17 * law, color=GREY, alpha=0.3, lw=0, label="C = 1.0 to 1.17")
    axis.axhline(1.03 * law, color="k", ls="--", lw=1.0, label="C = 1.03")
    flux = history["gauge.outlet.mean.mass-flux"]
    axis.plot(history["time"], flux, color=BLUE, label="mean over 0.1 s")
    axis.axvline(0.5, color=GREY, lw=1.0)
    axis.set(xlabel="time [s]", ylabel="flux through the half [kg/(m s)]", ylim=(0.0, 70.0))
    axis.legend(loc="lower right")
    save(figure, "hopper")


def gate(redraw):
    """Four instants coloured by speed; and the way of the gate's end."""
    results = run("gate", redraw)
    figure = plt.figure(figsize=(9, 6.6))
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 1.0, 0.9))
    axes = [figure.add_subplot(grid[k // 2, k % 2], aspect="equal") for k in range(4)]
    for axis, time in zip(axes, (0.03, 0.06, 0.09, 0.14), strict=True):
        frame = frame_at(results, time)
        held = frame["body"] == 1
        particles(axis, frame, lambda frame: np.full(len(frame), 0.6), (0.0, 1.0), held, "Greys")
        shown = particles(axis, frame, speed, (0.0, 1.6), ~held)
        axis.set(xlim=(0.0, 0.3), ylim=(0.0, 0.16))
        axis.set_title(f"t = {frame.time:.2f} s", fontsize=10, loc="left")
    figure.colorbar(shown, ax=axes, label="speed [m/s]", shrink=0.85, extend="max")
    axis, tip = figure.add_subplot(grid[2, :]), results.probes["tip"]
    for way, colour, label in (("x", BLUE, "outwards"), ("y", ORANGE, "upwards")):
        axis.plot(tip["time"], 1e3 * tip[f"displacement-{way}"], color=colour, label=label)
    axis.set(xlabel="time [s]", ylabel="the gate's end [mm]")
    axis.legend()
    save(figure, "gate")


def blast(redraw):
    """Pressure in the water at three instants; the plate's velocity, against Taylor's."""
    results = run("blast", redraw)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
    for time, colour in ((1.5e-4, BLUE), (2.3e-4, ORANGE), (3.0e-4, RED)):
        frame = frame_at(results, time)
        water = frame["body"] == 0
        x = frame["position"][water, 0]
        order = np.argsort(x)
        label = f"t = {1e3 * time:.2f} ms"
        axes[0].plot(x[order], frame["pressure"][water][order] / 1e6, color=colour, label=label)
    axes[0].axvspan(0.3, 0.31, color=GREY, alpha=0.5, lw=0.0)
    axes[0].set(xlabel="x [m]", ylabel="pressure of the water [MPa]")
    axes[0].legend()
    history, mass, theta = results.history, 78.5, 1.0e-4
    speed = history["body.plate.momentum-x"] / mass
    axes[1].plot(1e3 * history["time"], speed, color=BLUE, label="plate")
    q = 1.5e6 * theta / mass
    s = np.clip(history["time"] - 2.0e-4, 0.0, theta * np.log(q) / (q - 1.0))
    exact = 2.0e6 * theta / (mass * (q - 1.0)) * (np.exp(-s / theta) - np.exp(-q * s / theta))
    axes[1].plot(1e3 * history["time"], exact, "k--", lw=1.0, label="exact (Taylor)")
    axes[1].set(xlabel="time [ms]", ylabel="velocity [m/s]", xlim=(0.15, 0.34))
    axes[1].legend()
    save(figure, "blast")
