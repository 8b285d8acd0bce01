"""Cases of ground: a cavity that is expanded, a tunnel, a layer that is shaken."""

import numpy as np
from common import BLUE, GREY, ORANGE, RED, boxes, plt, run, save


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
