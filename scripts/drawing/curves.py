"""Cases against exact curves: a cavity, a tunnel, ground that is shaken, flows without ends."""

import numpy as np
from common import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    ROOT,
    boxes,
    frame_at,
    instants,
    plt,
    run,
    save,
    speed,
)
from studies.quiet import shaken


def cavity(redraw):
    """The pressure on the wall over its radius, and stresses over the radius, against exact."""
    results = run("cavity", redraw, ranks=1)
    history, G, b = results.history, 50.0, 30.0
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6))
    a = 1.0 + history["displacement.push-x"]
    pressure = history["constraint.push-x"] / (2.0 * np.pi * a * 0.25)
    axes[0].plot(a, pressure, color=BLUE, lw=1.0, label="pgimp")
    wide = np.linspace(1.02, 2.0, 200)
    square = G * (wide**2 - 1.0)  # of the radius out to which the clay yields
    exact = 1.0 + np.log(square / wide**2) - square / b**2
    axes[0].plot(wide, exact, "k--", lw=1.0, label="exact")
    axes[0].axhline(1.0 + np.log(G), color=GREY, lw=1.0, label="limit, clay without end")
    axes[0].set(xlabel="radius of the cavity", ylabel="pressure over c", ylim=(0.0, 5.2))
    axes[0].legend(loc="lower right")
    frame = results.frame(-1)
    clay = frame["body"] == 0
    r, stress = frame["position"][clay, 0], frame["stress"][clay]
    axes[1].plot(r, stress[:, 0], ".", ms=3, color=BLUE, label="radial")
    axes[1].plot(r, stress[:, 2], ".", ms=3, color=ORANGE, label="hoop")
    fine, edge = np.linspace(2.0, b, 400), square[-1]
    yields = fine**2 < edge
    radial = edge / b**2 - np.where(yields, 1.0 + np.log(edge / fine**2), edge / fine**2)
    hoop = np.where(yields, radial + 2.0, edge / b**2 + edge / fine**2)
    axes[1].plot(fine, radial, "k--", lw=1.0)
    axes[1].plot(fine, hoop, "k--", lw=1.0)
    axes[1].axvline(np.sqrt(edge), color=GREY, lw=1.0)
    axes[1].set(xlabel="radius", ylabel="stress over c, at the end", xlim=(2.0, b))
    axes[1].legend()
    save(figure, "cavity")


def tunnel(redraw):
    """The hoop's stress around the tunnel, and along both axes, against Kirsch's."""
    results = run("tunnel", redraw)
    frame, a = results.frame(-1), 2.0
    x, stress = frame["position"][:, :2] - frame["displacement"][:, :2], frame["stress"] / 1e6
    r, angle = np.hypot(*x.T), np.arctan2(x[:, 1], x[:, 0])
    c, s = np.cos(angle), np.sin(angle)
    hoop = stress[:, 0] * s * s + stress[:, 1] * c * c - 2.0 * stress[:, 3] * s * c
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), width_ratios=(1.0, 1.2))
    place, radius = frame["position"], frame["radius"]
    shown = boxes(axes[0], place, radius, -hoop, (0.5, 2.5))
    axes[0].set(xlim=(0.0, 8.0), ylim=(0.0, 8.0), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    label = "compression along the hoop [MPa]"
    figure.colorbar(shown, ax=axes[0], label=label, extend="both", shrink=0.9)
    far = np.linspace(a, 12.0, 200)
    for name, colour, side, near in (
        ("springline", BLUE, 1.0, angle < 0.1), ("crown", RED, -1.0, angle > 0.5 * np.pi - 0.1)
    ):  # fmt: skip
        axes[1].plot(r[near], -hoop[near], ".", ms=4, color=colour, label=name)
        k = (a / far) ** 2
        axes[1].plot(far, 0.75 * (1.0 + k) + 0.25 * side * (1.0 + 3.0 * k * k), "k--", lw=1.0)
    axes[1].set(xlabel="distance from the middle [m]", ylabel=label, xlim=(1.8, 12), ylim=(0, 3.8))
    axes[1].legend()
    save(figure, "tunnel")


def shaking(redraw):
    """Velocities of base and surface, and amplification over frequency, against exact."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
    high, speed, damping = 20.0, 200.0, 1.2566370614359172
    found = {}
    for frequency in (1.0, 2.0, 2.5, 3.0, 4.0):
        key = f"boundaries.y-min.velocity.0.sine.frequency={frequency}"
        probe = run("shaking", redraw, f"shaking-{frequency:g}", [key], ranks=1).probes["surface"]
        w, time = 2.0 * np.pi * frequency, probe["time"]
        late = time > 11.0
        swing = np.stack([np.sin(w * time[late]), np.cos(w * time[late])], axis=1)
        size = np.linalg.lstsq(swing, probe["velocity-x"][late], rcond=None)[0]
        found[frequency] = np.hypot(*size) / 0.01
        if frequency == 2.0:
            axes[0].plot(time, 1e3 * probe["velocity-x"], color=BLUE, lw=1.0, label="surface")
            base = 10.0 * np.sin(w * time)
            axes[0].plot(time, base, color=GREY, lw=1.0, label="base")
    axes[0].set(xlabel="time [s]", ylabel="velocity [mm/s]", xlim=(0.0, 6.0))
    axes[0].legend(loc="lower right")
    axes[1].plot(found.keys(), found.values(), "o", ms=5, color=BLUE, label="pgimp")
    f = np.linspace(0.2, 5.0, 400)
    w = 2.0 * np.pi * f
    exact = 1.0 / np.abs(np.cos(np.sqrt(w * w - 1j * w * damping) * high / speed))
    axes[1].plot(f, exact, "k--", lw=1.0, label="exact")
    axes[1].set(xlabel="frequency [Hz]", ylabel="surface over base", xlim=(0, 5), ylim=(0, 18))
    axes[1].legend()
    save(figure, "shaking")


def shaken_slope(redraw):
    """The ground as the slope moves most, and velocities along the surface against elements'."""
    shown = run("shaken-slope", redraw, overrides=["output.every=0.03125"], ranks=1)
    w, solution = 2.0 * np.pi * shaken.FREQUENCY, shaken.Elements()
    figure = plt.figure(figsize=(9, 5.2))
    grid = figure.add_gridspec(2, 1, height_ratios=(0.6, 1.0))
    above, below = (figure.add_subplot(grid[k]) for k in range(2))
    late = [number for number, time in enumerate(shown.times) if time > 5.0 + 1e-9]
    frames = [shown.frame(number) for number in late]
    place = shown.frame(0)["position"][:, :2]
    high = np.interp(place[:, 0], [shaken.TOE, shaken.CREST], [shaken.LOW, shaken.HIGH])
    top = np.flatnonzero(place[:, 1] > high - 0.5)
    top = top[np.argsort(place[top, 0])]
    times = np.array([frame.time for frame in frames])
    waves = np.stack([np.sin(w * times), np.cos(w * times)], axis=1)
    x = np.linspace(0.0, shaken.LENGTH, 481)
    exact = np.abs([solution.at(at) for at in x])
    for k, (name, colour) in enumerate((("along x", BLUE), ("along y", ORANGE))):
        moved = np.stack([frame["velocity"][top, k] for frame in frames]) / shaken.SIZE
        found = np.hypot(*np.linalg.lstsq(waves, moved, rcond=None)[0])
        below.plot(place[top, 0], found, ".", ms=4, color=colour, label=name)
        below.plot(x, exact[:, k], "k--", lw=1.0, label="elements" if k else None)
    for ends, height in (((0.0, 80.0), shaken.LOW), ((90.0, 240.0), shaken.HIGH)):
        below.plot(ends, [abs(shaken.level(height))] * 2, color=GREY, lw=1.0)
    below.set(xlabel="x [m]", ylabel="surface over base", xlim=(0.0, 240.0), ylim=(0.0, 3.4))
    below.legend(loc="upper left")
    most = max(frames, key=lambda frame: frame["velocity"][:, 0].max())
    colours = boxes(above, most["position"], most["radius"], 1e3 * most["velocity"][:, 0], (0, 30))
    above.set(xlim=(0.0, 240.0), ylim=(0.0, 24.0), ylabel="y [m]", aspect="equal")
    label = "velocity along x [mm/s]"
    figure.colorbar(colours, ax=above, label=label, location="top", shrink=0.5, aspect=40)
    save(figure, "shaken-slope")


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


def own_spinning_disk(redraw):
    """Stresses and the radial displacement over the radius, against exact ones."""
    words = ["--import", ROOT / "cases/spin.py"]
    results = run("own/spinning-disk", redraw, "own-spinning-disk", words=words, ranks=1)
    frame, a, b, nu = results.frame(-1), 0.25, 0.05, 0.3
    grown = frame["displacement"][:, 0]
    r = frame["position"][:, 0] - grown
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
    fine = np.linspace(b, a, 300)
    pull, ring = 7850.0 * 500.0**2 * (3.0 + nu) / 8.0, (a * b / fine) ** 2
    hoop = pull * (a * a + b * b + ring - (1.0 + 3.0 * nu) / (3.0 + nu) * fine**2)
    radial = pull * (a * a + b * b - ring - fine**2)
    for column, colour, label, exact in ((2, RED, "hoop", hoop), (0, BLUE, "radial", radial)):
        axes[0].plot(
            1e3 * r, frame["stress"][:, column] / 1e6, ".", ms=3, color=colour, label=label
        )
        axes[0].plot(1e3 * fine, exact / 1e6, "k--", lw=1.0)
    axes[0].set(xlabel="radius [mm]", ylabel="stress [MPa]", xlim=(45, 255), ylim=(0, 110))
    axes[0].legend()
    axes[1].plot(1e3 * r, 1e6 * grown, ".", ms=3, color=BLUE, label="pgimp")
    exact = fine / 2.1e11 * (hoop - nu * radial)
    axes[1].plot(1e3 * fine, 1e6 * exact, "k--", lw=1.0, label="exact")
    axes[1].set(xlabel="radius [mm]", ylabel="radial displacement [µm]", xlim=(45, 255))
    axes[1].legend()
    save(figure, "own-spinning-disk")
