"""Cases of what rolls: a cylinder on a plate, a ball on a slope."""

import numpy as np
from common import BLUE, GREY, RED, boxes, frame_at, instants, plt, run, save


def spin(frame, body, up=1):
    """Angular velocity of a body across x and `up`, by its particles' angular momentum."""
    own = frame["body"] == frame.bodies.index(body)
    mass, x, v = frame["mass"][own], frame["position"][own], frame["velocity"][own]
    x = x - np.average(x, axis=0, weights=mass)
    v = v - np.average(v, axis=0, weights=mass)
    moment = mass @ (x[:, 0] * v[:, up] - x[:, up] * v[:, 0])
    return moment / (mass @ (x[:, 0] ** 2 + x[:, up] ** 2))


def rolling(redraw):
    """Three instants coloured by the velocity along the plate; velocity and spin against exact."""
    results = run("rolling", redraw)
    figure = plt.figure(figsize=(9, 5.2))
    grid = figure.add_gridspec(2, 3, height_ratios=(1.0, 1.25))
    axes = [figure.add_subplot(grid[0, column], aspect="equal") for column in range(3)]

    def around(axis, frame):
        middle = frame["position"][frame["body"] == frame.bodies.index("cylinder"), 0].mean()
        axis.set(xlim=(middle - 0.35, middle + 0.35), title=f"t = {frame.time:.2f} s")

    bar = {"label": "velocity along x [m/s]", "extend": "neither"}
    instants(axes, results, (0.0, 0.1, 0.8), lambda frame: frame["velocity"][:, 0], (0.0, 2.0), bar,
             each=around, ylim=(0.0, 0.55), xlabel="x [m]")  # fmt: skip
    axes[0].set_ylabel("y [m]")
    axis = figure.add_subplot(grid[1, :])
    history = results.history
    speed = history["body.cylinder.momentum-x"] / history["body.cylinder.mass"]
    axis.plot(history["time"], speed, color=BLUE, label="velocity of the centre")
    turned = [(frame.time, -0.2 * spin(frame, "cylinder")) for frame in results]
    axis.plot(*np.transpose(turned), color=RED, label="spin times radius")
    slide = 1.5 / (3.0 * 0.3 * 9.81)
    axis.plot([0.0, slide, 0.8], [1.5, 1.0, 1.0], "k--", lw=1.0, label="rigid bodies")
    axis.plot([0.0, slide], [0.0, 1.0], "k--", lw=1.0)
    axis.set(xlabel="time [s]", ylabel="velocity [m/s]", ylim=(-0.1, 1.6))
    axis.legend(loc="lower right")
    save(figure, "rolling")


def rolling_ball(redraw):
    """The section of the ball at three instants; its velocity and that of its surface."""
    results = run("rolling-ball", redraw)
    rate, radius, ramp, cell = 5.0 / 7.0 * 3.3552, 0.1, 0.1, 0.01
    figure = plt.figure(figsize=(9, 5.0))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.1))
    axes = above.subplots(1, 3, subplot_kw={"aspect": "equal"})
    for axis, time in zip(axes, (0.0, 0.2, 0.35), strict=True):
        frame = frame_at(results, time)
        own = frame["position"][:, 1] < 0.5 * cell
        own &= frame["body"] == frame.bodies.index("ball")
        place = frame["position"][own][:, [0, 2, 1]]
        speed = np.linalg.norm(frame["velocity"][own], axis=1)
        shown = boxes(axis, place, frame["radius"][own], speed, (0.0, 1.4))
        axis.axhspan(-0.04, 0.0, color=GREY, alpha=0.5)
        axis.set(xlim=(0.0, 0.38), ylim=(-0.03, 0.23), xlabel="x [m]", yticks=(0, 0.1, 0.2))
        axis.set_title(f"t = {frame.time:.2f} s", fontsize=10)
    axes[0].set_ylabel("z [m]")
    above.colorbar(shown, ax=axes, label="speed [m/s]", shrink=0.85, extend="max")
    left, right = below.subplots(1, 2)
    history = results.history
    time, velocity = history["time"], history["body.ball.momentum-x"] / history["body.ball.mass"]
    frames = [(frame.time, -spin(frame, "ball", 2)) for frame in results]
    times, turns = np.transpose(frames)
    exact = rate * np.where(time < ramp, 0.5 * time**2 / ramp, time - 0.5 * ramp)
    left.plot(time, velocity, color=BLUE, label="velocity of the centre")
    left.plot(times, radius * turns, color=RED, label="radius times spin")
    left.plot(time, exact, "k--", lw=1.0, label="rigid ball")
    left.set(xlabel="time [s]", ylabel="velocity [m/s]")
    left.legend()
    weight = history["body.ball.mass"][0] * 9.2184
    right.plot(time, -history["rigid.slope.force-z"] / weight, color=BLUE, label="across the slope")
    right.plot(time, history["rigid.slope.force-x"] / weight, color=RED, label="friction")
    along = 2.0 / 7.0 * 3.3552 / 9.2184
    for end in (1.0, along):
        right.plot([0.0, ramp, 0.35], [0.0, end, end], "k--", lw=1.0)
    right.set(xlabel="time [s]", ylabel="force over the weight across")
    right.legend(loc=(0.5, 0.16))
    for name, when, values in (("velocity", time, velocity), ("spin", times, radius * turns)):
        late = when > 0.15
        print(f"pictures: {name} grows at {np.polyfit(when[late], values[late], 1)[0] / rate:.3f}")
    save(figure, "rolling-ball")
