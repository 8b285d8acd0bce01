"""Scenes that are hard for contact: corners, tips, edges, piles, thin plates, impacts, rest."""

from itertools import pairwise
from math import cos, pi, radians, sin

import numpy as np
from studies.patches.impacts import SOLID, C, energy, exact
from studies.patches.pressed import turned
from studies.scenes import ball, box, case_of, core


def depth(sim):
    """Greatest depth of a facet in another body now, in cells."""
    gaps = sim.rank.contact._proximity.candidates["gap"]
    gaps = gaps[np.isfinite(gaps)]
    return float(-gaps.min(initial=0.0)) / min(sim.scene.domain.frame.cell)


def watched(sim, every=1, limit=10**9):
    """Run to the end: greatest depth, energies, momentum and lines at times.

    Energy is over what there was at first, with what weight and rigid bodies have done since.
    """
    first, deepest, lines = sim.diagnostics(), 0.0, []
    while not sim.finished and sim.step < limit:
        sim.advance()
        if sim.step % every == 0:
            deepest = max(deepest, depth(sim))
            lines.append(sim.diagnostics())
    return first, deepest, lines


def greatest(lines):
    """Greatest energy at a step's end, of lines whose speeds are half a step earlier."""
    return max(
        0.5 * (line["kinetic-energy"] + after["kinetic-energy"]) + line["strain-energy"]
        for line, after in pairwise(lines)
    )


def _books(first, lines):
    """Greatest and last energy that books do not explain, over the greatest there is."""

    def whole(line):
        return energy(line) + line["dissipated-energy"]

    most = max(max(energy(line) for line in lines), 1e-300)
    work = [
        line.get("external-work", 0.0)
        + sum(
            value
            for key, value in line.items()
            if key.startswith("rigid.") and key.endswith(".work")
        )
        for line in lines
    ]
    off = [abs(whole(line) - whole(first) - w) / most for line, w in zip(lines, work, strict=True)]
    return max(off)


def rotation(about, angle):
    """Matrix of a rotation about an axis."""
    axis = np.array(about, float) / np.linalg.norm(about)
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + sin(angle) * K + (1.0 - cos(angle)) * K @ K


def planes(middle, sides, axes):
    """Region of a box with rows of a matrix as axes."""
    return {"intersection": [
        {"half-space": {"point": (middle + 0.5 * way * side * axis).tolist(),
                        "normal": (way * axis).tolist()}}
        for axis, side in zip(axes, sides, strict=True) for way in (-1.0, 1.0)
    ]}  # fmt: skip


def cube_on_its_corner(side=5.0, load=2e-3):
    """A cube stands on its corner on a rigid floor, held upright by its symmetry."""
    axes = rotation([1.0, -1.0, 0.0], np.arccos(1.0 / np.sqrt(3.0)))
    axes = np.eye(3) @ axes
    high = side * np.sqrt(3.0)
    middle = np.array([8.13, 8.31, 3.0 + 0.5 * high + 1e-3])
    if abs(axes.sum(axis=0)[2]) < 1.7:
        axes = np.eye(3) @ axes.T
    g = load * SOLID["young"] / side
    bodies = {
        "cube": exact(planes(middle, [side] * 3, axes)),
        "floor": {"rigid": {}, "region": box([0.0, 0.0, 0.5], [16.0, 16.0, 3.0])},
    }
    end = 60.0 * side / C
    sim = core(case_of([16.0, 16.0, 16.0], 1.0, {"solid": SOLID}, bodies, end,
                       gravity={"table": [[0.0, [0.0] * 3], [0.3 * end, [0.0, 0.0, -g]]]},
                       damping={"mass": 0.5 * C / side},
                       contact=[{"bodies": ["cube", "floor"], "friction": 0.3}]))  # fmt: skip
    _, deepest, lines = watched(sim, 5)
    force = np.mean([line["contact.cube+floor-z"] for line in lines[-5:]])
    side_force = np.mean([abs(line["contact.cube+floor-x"]) for line in lines[-5:]])
    weight = g * side**3
    return {"force over weight": abs(force) / weight, "sideways": side_force / weight,
            "depth": deepest, "kinetic over strain": lines[-1]["kinetic-energy"]
            / lines[-1]["strain-energy"]}  # fmt: skip


def peg(clearance=0.05, speed=0.02, friction=0.2):
    """A peg is pushed through a slot that is a little narrower at its end: 2D."""
    low = np.array([3.17, 12.0])
    wide, high = 4.0, 8.0
    way = [0.0, -speed * C]
    left = box([0.0, 1.0], [low[0] - clearance, 11.0])
    right = box([low[0] + wide + clearance, 1.0], [low[0] + wide + 3.0, 11.0])
    bodies = {
        "peg": exact(box([low[0], low[1] - 3.0], low + np.array([wide, high - 3.0])), way),
        "left": exact(left),
        "right": exact(right),
    }
    held = {name: {"body": name, "region": box([x, 0.0], [x + 1.0, 12.0]), "velocity": [0.0, 0.0]}
            for name, x in (("left", 0.0), ("right", low[0] + wide + 2.0))}  # fmt: skip
    held["peg"] = {"body": "peg", "region": box([0.0, 15.9], [12.0, 20.0]),
                   "velocity": [0.06 * C * speed, -speed * C]}  # fmt: skip
    sim = core(case_of([12.0, 20.0], 1.0, {"solid": SOLID}, bodies, 6.0 / (speed * C),
                       constraints=held,
                       contact=[{"bodies": ["peg", name], "friction": friction}
                                for name in ("left", "right")]))  # fmt: skip
    _, deepest, lines = watched(sim, 3)
    return {
        "depth": deepest,
        "steps": sim.step,
        "energies": [round(energy(line), 6) for line in lines[:: max(1, len(lines) // 5)]],
    }


def pile(count=10, side=(4.0, 3.0), steps=100_000, load=1e-3, floor="unilateral", friction=0.3):
    """A pile of blocks at rest: depth, energy and way of the last half of its steps."""
    D, (wide, high) = 2, side
    bodies, y = {}, 0.0 if floor == "unilateral" else 2.0
    for k in range(count):
        low = np.array([3.0 + 0.17 * (k % 3), y + high * k])
        bodies[f"b{k}"] = exact(box(low, low + np.array([wide, high])))
    g = load * SOLID["young"] / (count * high)
    names = [*bodies]
    contact = [{"bodies": two, "friction": friction} for two in pairwise(names)]
    more = {}
    if floor == "unilateral":
        more["boundaries"] = {"y-min": {"unilateral": {"friction": friction}}}
    else:
        bodies["floor"] = {"rigid": {}, "region": box([0.5, 0.5], [10.0, 2.0])}
        contact.append({"bodies": ["b0", "floor"], "friction": friction})
    tall = count * high
    ramp = 30.0 * tall / C
    sim = core(case_of([11.0, np.ceil(tall + 5.0)], 1.0, {"solid": SOLID}, bodies, 1e9,
                       gravity={"table": [[0.0, [0.0] * D], [ramp, [0.0, -g]]]},
                       contact=contact, **more))  # fmt: skip
    lines, deepest = [], 0.0
    while sim.step < steps:
        for _ in range(200):
            sim.advance()
        deepest = max(deepest, depth(sim))
        lines.append(sim.diagnostics())
    half = len(lines) // 2
    strain = np.mean([line["strain-energy"] for line in lines[half:]])
    top = names[-1]
    way = [lines[-1][f"body.{n}.centre-x"] - lines[half][f"body.{n}.centre-x"] for n in names]
    return {
        "depth": deepest, "ramp": ramp / sim.dt,
        "kinetic over strain, first half of rest, second": [
            np.mean([line["kinetic-energy"] for line in part]) / strain
            for part in (lines[half : 3 * half // 2], lines[3 * half // 2 :])
        ],
        "drift x": max(map(abs, way)),
        "drift y": lines[-1][f"body.{top}.centre-y"] - lines[half][f"body.{top}.centre-y"],
    }  # fmt: skip


def over_the_edge(order=("block", "table"), friction=0.1, soft=False):
    """A block slides over the edge of a table and tips: depth and energy's books."""
    g, v = 2.0, 0.25 * C
    table = box([0.0, 3.0], [10.4, 6.0])
    entries = {
        "block": exact(box([5.13, 6.0], [11.13, 9.0]), [v * 0.5, 0.0]),
        "table": exact(table) if soft else {"rigid": {}, "region": table},
    }
    bodies = {name: entries[name] for name in order}
    more = {}
    if soft:
        more["constraints"] = {"held": {"body": "table", "region": box([0.0, 3.0], [10.0, 4.0]),
                                        "velocity": [0.0, 0.0]}}  # fmt: skip
    sim = core(
        case_of(
            [28.0, 14.0],
            1.0,
            {"solid": SOLID},
            bodies,
            5.0,
            gravity=[0.0, -g],
            contact=[{"bodies": ["block", "table"], "friction": friction}],
            **more,
        )
    )
    first, deepest, lines = watched(sim, 1)
    last = lines[-1]
    return {"depth": deepest, "fell": last["body.block.centre-y"], "x": last["body.block.centre-x"],
            "books": _books(first, lines)}  # fmt: skip


def plates(thick=1.0, V=0.05, cells=20.0):
    """Thin plates meet face to face, askew, and edge on: rebound, energy, depth."""
    found = {}
    for name, angle, at in (("flat", 0.0, 0.5), ("askew", 8.0, 2.3), ("edge on", 90.0, 11.0)):
        middle = np.array([15.13, 14.21])
        one = turned(middle, [cells, thick], 0.0)[0]
        other = turned(middle + np.array([0.37, at + thick]), [cells, thick], angle)[0]
        bodies = {"a": exact(one), "b": exact(other, [0.0, -V * C])}
        end = (at / V + 4.0 * cells) / C
        sim = core(case_of([30.0, 44.0], 1.0, {"solid": SOLID}, bodies, end,
                           contact=[{"bodies": ["a", "b"], "friction": 0.2}]))  # fmt: skip
        first, deepest, lines = watched(sim, 1)
        P = max(abs(lines[-1][f"momentum-{x}"] - first[f"momentum-{x}"]) for x in "xy")
        found[name] = {
            "depth": round(deepest, 4), "energy": round(energy(lines[-1]) / energy(first), 4),
            "most": round(greatest(lines) / energy(first), 6),
            "momentum": P / (cells * thick * V * C),
        }  # fmt: skip
    return found


def wedge(angle=20.0, order=("wedge", "block"), v=0.02, friction=0.0):
    """A sharp wedge pressed into a block: depth, energy, momentum."""
    half, tip = radians(0.5 * angle), np.array([8.13, 8.2])
    high = 7.0
    sides = [
        {"half-space": {"point": tip.tolist(), "normal": [way * cos(half), -sin(half)]}}
        for way in (-1.0, 1.0)
    ]
    top = {"half-space": {"point": (tip + np.array([0.0, high])).tolist(), "normal": [0.0, 1.0]}}
    entries = {
        "wedge": exact({"intersection": [*sides, top]}, [0.0, -v * C]),
        "block": exact(box([3.37, 2.21], [13.37, 8.11])),
    }
    bodies = {name: entries[name] for name in order}
    sim = core(case_of([17.0, 18.0], 1.0, {"solid": SOLID}, bodies, (0.1 / v + 60.0) / C,
                       contact=[{"bodies": [*order], "friction": friction}]))  # fmt: skip
    first, deepest, lines = watched(sim, 1)
    return {
        "depth": round(deepest, 4), "energy": round(energy(lines[-1]) / energy(first), 4),
        "most": round(greatest(lines) / energy(first), 6),
        "wedge": lines[-1]["body.wedge.momentum-y"] / first["body.wedge.momentum-y"],
        "momentum": abs(lines[-1]["momentum-y"] / first["momentum-y"] - 1.0),
    }  # fmt: skip


def bouncing(R=5.0, load=2e-3, bounces=4):
    """A disk falls on a floor again and again: heights it comes back to, and its energy."""
    g = load * C * C / R
    fall = 0.5 * R
    centre = np.array([R + 3.13, 3.0 + R + fall])
    bodies = {
        "disk": exact(ball(centre, R)),
        "floor": {"rigid": {}, "region": box([0.5, 0.5], [2.0 * R + 5.5, 3.0])},
    }
    end = bounces * 2.3 * np.sqrt(2.0 * fall / g)
    sim = core(
        case_of(
            [2.0 * R + 6.0, 2.0 * R + 2.0 * fall + 6.0],
            1.0,
            {"solid": SOLID},
            bodies,
            end,
            gravity=[0.0, -g],
            contact=[{"bodies": ["disk", "floor"]}],
        )
    )
    _, deepest, lines = watched(sim, 1)
    y = np.array([line["body.disk.centre-y"] for line in lines]) - 3.0 - R
    tops = [y[k] / fall for k in range(1, len(y) - 1) if y[k - 1] < y[k] >= y[k + 1] and y[k] > 0.1]
    mass = pi * R * R
    total = np.array([energy(line) for line in lines]) + mass * g * y
    return {
        "depth": deepest,
        "heights": np.round(tops, 3).tolist(),
        "energy": [total.max() / (mass * g * fall), total[-1] / (mass * g * fall)],
    }
