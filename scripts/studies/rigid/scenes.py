"""Rigid bodies that meet each other, far from a block that cases need; cells have sides of 1."""

from math import acosh, atan2, cos, degrees, hypot, pi, radians, sin, sqrt

import numpy as np
from studies.patches.hard import depth, planes, rotation
from studies.patches.impacts import SOLID, YOUNG, exact
from studies.patches.pressed import turned
from studies.scenes import ball, box, case_of, core


def free(region, velocity=(0.0, 0.0), **more):
    """A rigid body that moves freely."""
    return {"rigid": {"density": 1.0} | more, "region": region, "velocity": [*velocity]}


def still(region):
    """A rigid body at rest."""
    return {"rigid": {}, "region": region}


FLOOR = still(box([1.5, 1.0], [12.5, 3.0]))


def watched(size, bodies, end, entry, g=1.0, dt=0.01, **parts):
    """Greatest depth in cells, the solver at its end, and columns of the history by name."""
    D = len(size)
    bodies = {"far": exact(box([0.05] * D, [1.05] * D))} | bodies
    case = case_of(size, 1.0, {"solid": SOLID}, bodies, end, contact=[entry],
                   gravity=[0.0] * (D - 1) + [-g], **parts)  # fmt: skip
    case["time"]["step"] = dt
    sim = core(case)
    deep, lines = 0.0, [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        deep = max(deep, depth(sim))
        lines.append(sim.diagnostics())
    return deep, sim, {name: np.array([line[name] for line in lines]) for name in lines[0]}


def bounces(e, fall=3.0):
    """Heights of bounces over that of the fall, and the greatest energy, over the first, less 1."""
    bodies = {"box": free(box([4.3, 3.0 + fall], [7.3, 6.0 + fall])), "floor": FLOOR}
    entry = {"bodies": ["box", "floor"], "restitution": e}
    _, _, line = watched([14.0, 14.0], bodies, 16.0, entry, dt=0.005)
    y = line["rigid.box.displacement-y"] + fall
    tops = [y[k] / fall for k in range(1, len(y) - 1) if y[k - 1] < y[k] >= y[k + 1]]
    # Velocities are half a step behind positions.
    energy = line["rigid.box.kinetic-energy"] + 9.0 * (y - 0.5 * np.diff(y, prepend=y[0]))
    return [top for top in tops if top > 0.1][:3], energy.max() / (9.0 * fall) - 1.0


def cradle(first, e=1.0, R=3.0):
    """Velocities of five balls after the first ones have hit the others, and energy left."""
    bodies = {f"b{k}": free(ball([5.4 + 2.0 * R * k - (k < first), 4.6], R),
                            [float(k < first), 0.0]) for k in range(5)}  # fmt: skip
    names = [*bodies]
    entry = {"bodies": names, "restitution": e}
    _, _, line = watched([38.0, 10.0], bodies, 3.0, entry, 0.0, 0.02)
    kinetic = sum(line[f"rigid.{name}.kinetic-energy"] for name in names)
    speeds = [line[f"rigid.{name}.velocity-x"][-1] for name in names]
    return speeds, kinetic[-1] / kinetic[0]


def oblique(R, e=0.8):
    """Greatest errors of the velocity of a ball that another one hits, and of its rim's."""
    off = [0.0, 0.0]
    for friction in (0.1, 0.6):
        n = np.array([cos(0.7), sin(0.7)])
        one = np.array([R + 1.5, R + 1.4])
        bodies = {"a": free(ball(one, R), [1.0, 0.0]),
                  "b": free(ball(one + 2.0 * R * n + [0.41, 0.0], R))}  # fmt: skip
        entry = {"bodies": ["a", "b"], "restitution": e, "friction": friction}
        size = np.ceil([4.0 * R + 4.0, 4.0 * R + 2.0])
        _, _, line = watched(size, bodies, 1.0, entry, 0.0)
        mass, t = pi * R * R, np.array([-n[1], n[0]])
        push = 0.5 * mass * (1.0 + e) * n[0]
        drag = np.clip(mass * t[0] / 6.0, -friction * push, friction * push)
        found = [line[f"rigid.b.velocity-{x}"][-1] for x in "xy"]
        off[0] = max(off[0], np.abs(found - (push * n + drag * t) / mass).max())
        spin = line["rigid.b.angular-velocity-z"][-1] + 2.0 * drag / (mass * R)
        off[1] = max(off[1], abs(spin) * R)
    return off


def stack(friction, count=5, high=2.0):
    """Greatest way of a box in a stack in 10 s, and kinetic energy in the second half."""
    bodies = {
        f"b{k}": free(box([4.3 + 0.17 * (k % 3), 3.0 + high * k],
                          [8.3 + 0.17 * (k % 3), 3.0 + high * (k + 1)])) for k in range(count)
    }  # fmt: skip
    names = [*bodies]
    entry = {"bodies": [*names, "floor"], "friction": friction}
    size = [14.0, 6.0 + high * count]
    _, _, line = watched(size, bodies | {"floor": FLOOR}, 10.0, entry)
    ways = [np.abs(line[f"rigid.{name}.displacement-{x}"]).max() for name in names for x in "xy"]
    kinetic = sum(line[f"rigid.{name}.kinetic-energy"] for name in names)
    return max(ways), kinetic[len(kinetic) // 2 :].max()


def incline(friction, angle=25.0, end=5.0):
    """Way of a box down an incline, and the exact one."""
    corner = np.array([12.0, 8.0])
    _, (along, normal) = turned(corner, [1.0, 1.0], -angle)
    bodies = {
        "box": free(turned(corner - 5.0 * along + normal, [3.0, 2.0], -angle)[0]),
        "floor": still(turned(corner - 1.5 * normal, [24.0, 3.0], -angle)[0]),
    }
    entry = {"bodies": ["box", "floor"], "friction": friction}
    _, _, line = watched([26.0, 20.0], bodies, end, entry)
    way = np.array([line[f"rigid.box.displacement-{x}"][-1] for x in "xy"]) @ along
    pull = sin(radians(angle)) - friction * cos(radians(angle))
    return way, 0.5 * max(0.0, pull) * end**2


def rocking(wide, slender=3.0, tilt=4.0):
    """Quarter period and next greatest angle of a rocking block, over Housner's."""
    b, h = 0.5 * wide, 0.5 * slender * wide
    R, alpha, theta = hypot(b, h), atan2(b, h), radians(tilt)
    pivot = np.array([3.0 + wide, 3.0])
    _, axes = turned(pivot, [1.0, 1.0], -tilt)
    middle = pivot + np.array([-b, h]) @ axes
    size = [wide + 6.0, 2.0 * h + 6.0]
    bodies = {"block": free(turned(middle, [wide, 2.0 * h], -tilt)[0]),
              "floor": still(box([1.5, 1.0], [size[0] - 0.5, 3.0]))}  # fmt: skip
    entry = {"bodies": ["block", "floor"], "friction": 1.0}
    p = sqrt(0.75 / R)
    quarter = acosh(1.0 / (1.0 - theta / alpha)) / p
    end = np.ceil(3.0 * quarter / 0.005) * 0.005
    _, _, line = watched(size, bodies, end, entry, dt=0.005)
    angle = line["rigid.block.angle-z"] - theta
    crosses = int(np.argmax(angle > 0.0))
    left = 1.0 - 1.5 * sin(alpha) ** 2
    expected = alpha * (1.0 - sqrt(1.0 - left**2 * (1.0 - (1.0 - theta / alpha) ** 2)))
    return line["time"][crosses] / quarter, angle.max() / expected


def peg(clearance, friction, force=2.0, tilt=2.0):
    """Greatest depth of a peg pushed askew at a hole, and energy that the books do not explain."""
    x, wide, high = 8.0, 4.0, 7.0
    bodies = {
        "peg": free(turned(np.array([x, 8.6 + 0.5 * high]), [wide, high], tilt)[0],
                    force=[0.3 * force, -force]),
        "left": still(box([1.5, 1.0], [x - 0.5 * wide - clearance, 8.0])),
        "right": still(box([x + 0.5 * wide + clearance, 1.0], [14.5, 8.0])),
    }  # fmt: skip
    entry = {"bodies": ["peg", "left", "right"], "friction": friction}
    deep, _, line = watched([16.0, 20.0], bodies, 12.0, entry, 0.0)
    way = [line[f"rigid.peg.displacement-{x}"] for x in "xy"]
    work = force * (0.3 * way[0] - way[1])
    name = "contact.peg+left+right"
    lost = line[f"{name}.friction-heat"] + line[f"{name}.impact-loss"]
    off = np.abs(line["rigid.peg.kinetic-energy"] + lost - work).max()
    return deep, off / work.max()


def pressed(force=20.0, wide=10.0, high=5.0, end=10.0):
    """Force and way of a rigid block that a force presses on an elastic one, over the exact."""
    bodies = {
        "base": exact(box([3.0, 0.0], [3.0 + wide, high])),
        "punch": free(box([3.0, high], [3.0 + wide, high + 2.0]), fixed=["x", "rotation"],
                      force={"table": [[0.0, [0.0, 0.0]], [0.4 * end, [0.0, -force]]]}),
    }  # fmt: skip
    _, _, line = watched([16.0, 12.0], bodies, end, {"bodies": ["punch", "base"]}, 0.0, 0.005,
                         boundaries={"y-min": "slip"})  # fmt: skip
    late = line["time"] > 0.8 * end
    way = force / wide * high * (1.0 - 0.3**2) / YOUNG
    return (line["contact.punch+base-y"][late].mean() / force,
            -line["rigid.punch.displacement-y"][late].mean() / way)  # fmt: skip


def corner(D, end, side=3.0):
    """Depth of a square's, or a cube's, corner on which it stands on a floor."""
    middle = np.array([6.13, 6.31, 2.0][3 - D :])
    axes = np.array([[1.0, 1.0], [-1.0, 1.0]]) / sqrt(2.0)
    if D == 3:
        axes = rotation([1.0, -1.0, 0.0], np.arccos(1.0 / sqrt(3.0)))
        axes = axes if abs(axes.sum(axis=0)[2]) > 1.7 else axes.T
    middle[-1] = 2.0 + 0.5 * side * sqrt(D)
    bodies = {"cube": free(planes(middle, [side] * D, axes), [0.0] * D),
              "floor": still(box([1.5] * (D - 1) + [0.5], [11.0] * (D - 1) + [2.0]))}  # fmt: skip
    entry = {"bodies": ["cube", "floor"], "friction": 0.3}
    _, _, line = watched([12.0] * (D - 1) + [9.0], bodies, end, entry, dt=0.02)
    assert abs(degrees(line["rigid.cube.angle-x" if D == 3 else "rigid.cube.angle-z"][-1])) < 5.0
    return -line[f"rigid.cube.displacement-{'xyz'[D - 1]}"][-1]
