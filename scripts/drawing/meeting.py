"""Cases of bodies that meet: Hertz's impact and his line contact, a corner, grains in a drum."""

import h5py
import numpy as np
from common import BLUE, GREEN, GREY, ORANGE, RED, boxes, frame_at, instants, plt, run, save, speed

from pgimp.utilities.plot.camera import camera
from pgimp.utilities.plot.rigid import draw_lines, lines


def ball_impact(pace=0.2, young=1.0e6, poisson=0.3, radius=0.1, density=1000.0):
    """Hertz's impact of a ball on a rigid wall: times, forces, greatest approach and E'."""
    plane, mass = young / (1.0 - poisson**2), 4.0 / 3.0 * np.pi * radius**3 * density
    depth = (15.0 * mass * pace**2 / (16.0 * plane * np.sqrt(radius))) ** 0.4
    part = np.sin(np.linspace(0.0, 0.5 * np.pi, 2001))  # approach over the greatest
    middle = 0.5 * (part[1:] + part[:-1])
    steps = np.diff(part) * depth / pace / np.sqrt(1.0 - middle**2.5)
    time = np.concatenate([[0.0], np.cumsum(steps)])
    force = 4.0 / 3.0 * plane * np.sqrt(radius) * (part * depth) ** 1.5
    whole = np.concatenate([time, 2.0 * time[-1] - time[::-1]])
    return whole, np.concatenate([force, force[::-1]]), depth, plane


def wall_pressure(results, number, cell):
    """Distances from the axis of the wall's vertices on a quarter, their forces and pressures."""
    with h5py.File(results.path / f"frames/grid-{number:06d}.h5") as file:
        place, force = file["position"][:], -file["force"][:, 2]
    wall = place[:, 2] < 0.5 * cell  # those beyond it are its own
    column, which = np.unique(np.rint(place[wall, :2] / cell), axis=0, return_inverse=True)
    force = np.bincount(which.ravel(), force[wall])
    area = cell**2 * np.prod(np.where(column == 0.0, 0.5, 1.0), axis=1)
    inside = (column >= 0.0).all(axis=1)
    return cell * np.hypot(*column.T)[inside], force[inside], (force / area)[inside]


def hertz(redraw):
    """The ball as it is pressed most; force over time and pressure on the wall against Hertz's."""
    results = run("hertz", redraw)
    radius, start, cell = 0.1, 0.005 / 0.2, 0.005
    time, force, depth, plane = ball_impact()
    circle, middle = np.sqrt(radius * depth), 2.0 / np.pi * plane * np.sqrt(depth / radius)
    figure, (left, between, right) = plt.subplots(1, 3, figsize=(9, 3.2))
    number = int(np.searchsorted(results.times, 0.0463 - 1e-9))
    frame = results.frame(number)
    shown = frame["position"][:, 1] < 0.5 * cell
    place, stress = frame["position"][shown][:, [0, 2, 1]], frame["von-mises"][shown] / 1e3
    for side in (1.0, -1.0):
        ball = boxes(left, place * [side, 1.0, 0.0], frame["radius"][shown], stress, (0.0, 60.0))
    left.set(xlim=(-0.105, 0.105), ylim=(0.0, 0.205), xlabel="x [m]", ylabel="z [m]")
    left.set(aspect="equal")
    figure.colorbar(ball, ax=left, label="von Mises stress [kPa]", extend="max", location="top")
    history = results.history
    between.plot(1e3 * history["time"], 4.0 * history["reaction.z-min-z"], color=BLUE)
    between.plot(1e3 * (start + time), force, "k--", lw=1.0, label="Hertz")
    between.set(xlabel="time [ms]", ylabel="force on the ball [N]", xlim=(20, 72))
    between.legend(loc="upper right", fontsize=8)
    places, forces, pressures = wall_pressure(results, number, cell)
    right.plot(1e3 * places, pressures / 1e3, "o", color=BLUE, ms=3)
    ways = np.linspace(0.0, circle, 200)
    right.plot(1e3 * ways, middle * np.sqrt(1.0 - (ways / circle) ** 2) / 1e3, "k--", lw=1.0)
    right.set(xlabel="distance from the axis [mm]", ylabel="pressure on the wall [kPa]")
    right.set(xlim=(0, 30), ylim=(0, 135))
    found = np.sqrt(2.5 * (forces * places**2).sum() / forces.sum())
    print(f"pictures: force over Hertz {4.0 * history['reaction.z-min-z'].max() / force.max():.4f}")
    print(f"pictures: radius {found / circle:.3f}, middle {pressures[places == 0.0] / middle}")
    save(figure, "hertz")


def line_pressure(results, cell):
    """Distances from the plane of symmetry, forces and pressures between the cylinders at last."""
    number = len(results.times) - 1
    with h5py.File(results.path / f"frames/grid-{number:06d}.h5") as file:
        place, force = file["position"][:], np.abs(file["contact"][:, 1])
    column, which = np.unique(np.rint(place[:, 0] / cell), return_inverse=True)
    force = np.bincount(which, force)
    inside = column >= 0.0
    pressure = force / (cell * np.where(column == 0.0, 0.5, 1.0))
    return cell * column[inside], force[inside], pressure[inside]


def hertz_line(redraw):
    """Both cylinders, where they touch, and the pressure between them against Hertz's."""
    results = run("hertz-line", redraw)
    radius, plane, cell = 0.1, 1.0e6 / (1.0 - 0.3**2), 2.4e-3
    history = results.history
    force = 2.0 * np.abs(history["contact.low+high-y"][history["time"] > 0.065]).mean()
    wide = np.sqrt(4.0 * force * radius / (np.pi * plane))
    top = 0.5 * plane * wide / radius
    figure, (left, between, right) = plt.subplots(1, 3, figsize=(9, 3.4), width_ratios=(1, 1, 1.4))
    frame = results.frame(-1)
    place, stress = frame["position"], frame["von-mises"] / 1e3
    for axis, most in ((left, 0.108), (between, 2.0 * wide)):
        near = (np.abs(place[:, :2] - [0.0, 0.0983]) < most + 2.0 * cell).all(axis=1)
        for side in (1.0, -1.0):
            both = place[near] * [side, 1.0, 0.0]
            shown = boxes(axis, both, frame["radius"][near], stress[near], (0.0, 35.0))
        axis.set(xlim=(-most, most), ylim=(0.0983 - most, 0.0983 + most), aspect="equal")
        axis.set(xlabel="x [m]")
    left.set_ylabel("y [m]")
    figure.colorbar(shown, ax=(left, between), label="von Mises stress [kPa]", location="top")
    x, forces, pressures = line_pressure(results, cell)
    ways = np.linspace(-wide, wide, 400)
    for side in (1.0, -1.0):
        right.plot(side * 1e3 * x, pressures / 1e3, "o", color=BLUE, ms=3)
    right.plot(1e3 * ways, top / 1e3 * np.sqrt(1.0 - (ways / wide) ** 2), "k--", lw=1.0)
    right.set(xlabel="x [mm]", ylabel="pressure between them [kPa]", xlim=(-20, 20), ylim=(0, 65))
    found = 2.0 * np.sqrt((forces * x**2).sum() / forces.sum())
    print(f"pictures: {force:.0f} N/m, half-width over Hertz's {found / wide:.3f}")
    print(f"pictures: pressure {pressures[0] / top:.3f}, {pressures.max() / top:.3f} of Hertz's")
    save(figure, "hertz-line")


def corner(redraw):
    """The bodies at rest, coloured by pressure; the forces between them against statics."""
    results = run("corner", redraw)
    history, angle = results.history, np.radians(25.0)
    block, roller = (9.81 * history[f"body.{name}.mass"][0] for name in ("inner", "roller"))
    x, y = np.sin(angle), np.cos(angle)
    forces = {
        "reaction.y-min-y": ("floor", (3.0 * block + roller) * y),
        "reaction.x-min-x": ("wall", (3.0 * block + roller) * x),
        "contact.inner+above-y": ("inner and above", block * y),
        "contact.beside+roller-y": ("beside and roller", roller * y),
        "contact.inner+beside-x": ("inner and beside", block * x),
        "contact.above+roller-x": ("above and roller", roller * x),
    }
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), width_ratios=(1.0, 1.4))
    frame = frame_at(results, 1.5)
    shown = boxes(left, frame["position"], frame["radius"], frame["pressure"] / 1e3, (0.0, 12.0))
    left.set(xlim=(0.0, 0.65), ylim=(0.0, 0.65), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    arrow = {"arrowstyle": "->"}
    left.annotate("", (0.56 - 0.1 * x, 0.62 - 0.1 * y), (0.56, 0.62), arrowprops=arrow)
    left.text(0.57, 0.55, "g")
    figure.colorbar(shown, ax=left, label="pressure [kPa]", extend="both", shrink=0.8)
    for (name, (label, exact)), colour in zip(
        forces.items(), (BLUE, RED, GREEN, ORANGE, GREY, "k"), strict=True
    ):
        right.plot(history["time"], np.abs(history[name]), color=colour, label=label)
        right.plot([0.0, 1.0, 1.5], [0.0, exact, exact], color=colour, ls="--", lw=1.0)
        mean = np.abs(history[name][history["time"] > 1.2 - 1e-9]).mean()
        print(f"pictures: {label} {mean:.1f}, exact {exact:.1f}")
    right.set(xlabel="time [s]", ylabel="force [N/m]")
    right.legend(fontsize=8)
    save(figure, "corner")


def grains(results):
    """Times, and by grain and time the centres of the grains of the drum: x and y."""
    names = [name for name in results.history.dtype.names if name.endswith(".centre-x")]
    history = results.history
    return history["time"], *(
        np.array([history[name[:-1] + axis] for name in names]) for axis in "xy"
    )


def surface_angles(results, strips=10, half=0.5):
    """Angle of the heap's surface at each time in degrees: a line through its highest grains."""
    _, x, y = grains(results)
    ends = np.linspace(-half, half, strips + 1)
    angles = []
    for places, heights in zip(x.T, y.T, strict=True):
        strip = np.digitize(places, ends)
        inside = set(strip) - {0, strips + 1}
        highest = [np.where(strip == k, heights, -np.inf).argmax() for k in inside]
        angles.append(np.degrees(np.arctan(-np.polyfit(places[highest], heights[highest], 1)[0])))
    return np.array(angles)


def drum(redraw):
    """Four instants coloured by speed; the surface's angle; torque and that of the weight."""
    results = run("drum", redraw)
    figure = plt.figure(figsize=(9, 5.0))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.3))
    axes = above.subplots(1, 4, subplot_kw={"aspect": "equal"})

    def outline(axis, frame):
        draw_lines(axis, lines(frame, camera(None, 2, None)), True)
        axis.set(xlim=(-0.69, 0.69), ylim=(-0.69, 0.69), xticks=(), yticks=())

    instants(axes, results, (0.0, 0.7, 1.4, 2.0), speed, (0.0, 2.0), {"label": "speed [m/s]"},
             "t = {:.1f} s", each=outline)  # fmt: skip
    history = results.history
    left, right = below.subplots(1, 2)
    left.plot(history["time"], surface_angles(results), color=BLUE, label="surface of the heap")
    left.plot([0.0, 0.9], np.degrees([0.0, 1.2 * 0.9]), "k--", lw=1.0, label="turned with the drum")
    left.set(xlabel="time [s]", ylabel="angle [degrees]", ylim=(-5, 65))
    left.legend(loc="lower right")
    time, x, _ = grains(results)
    mass = np.array([history[f"body.g{k + 1:03d}.mass"][0] for k in range(len(x))])
    right.plot(time, history["rigid.drum.torque-z"], color=BLUE, label="on the drum")
    right.plot(time, -9.81 * mass @ x, "k--", lw=1.0, label="of the weight")
    right.set(xlabel="time [s]", ylabel="torque [N m/m]")
    right.legend(loc="lower right")
    print(f"pictures: greatest angle {surface_angles(results).max():.1f} degrees")
    save(figure, "drum")


def brake_pad(redraw):
    """The pad coloured by stress on its rail, and pressure, slip and wear along its face."""
    results = run("brake-pad", redraw)
    frame = results.frame(-1)
    path = results.path / "frames" / frame.path.name.replace("particles", "surface")
    with h5py.File(path) as file:
        face = (file["body"][:] == 0) & (file["normal"][:, 1] < -0.5)
        cells = file["connectivity"][:][face]
        x = 1e3 * file["position"][:][cells].mean(axis=1)[:, 0]
        shown = {
            "contact pressure [kPa]": 1e-3 * file["contact-pressure"][:][face],
            "slip [mm]": 1e3 * file["slip"][:][face],
            "work of friction [J/m\u00b2]": file["wear-work"][:][face],
        }
    order = np.argsort(x)
    figure = plt.figure(figsize=(9, 5.4))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.1))
    axis = above.subplots(subplot_kw={"aspect": "equal"})
    stress = -1e-3 * frame["stress"][:, 1]
    drawn = boxes(axis, 1e3 * frame["position"], 1e3 * frame["radius"], stress, (0.0, 60.0))
    axis.axhspan(0.0, 4.1, color=GREY, alpha=0.5)
    axis.set(xlim=(4, 56), ylim=(0, 21), xlabel="x [mm]", ylabel="y [mm]")
    axis.annotate("", (22, 2), (34, 2), arrowprops={"arrowstyle": "->"})
    above.colorbar(drawn, ax=axis, label="-stress.yy [kPa]", extend="both", shrink=0.9)
    for each, (name, values) in zip(below.subplots(1, 3), shown.items(), strict=True):
        each.plot(x[order], values[order], color=BLUE, lw=1.2)
        each.set(xlabel="x [mm]", title=name)
        each.title.set_fontsize(10)
        each.set_ylim(bottom=min(0.0, values.min()))
    save(figure, "brake-pad")
