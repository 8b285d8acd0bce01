"""Bodies that meet and part, exact to their surface: restitution in any frame, at any offset."""

from math import sqrt

import numpy as np
from studies.scenes import ball, box, case_of, core

#: Cells have sides of 1; speeds are in wave speeds C.
POISSON, YOUNG = 0.3, 1000.0
C = sqrt(YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
SOLID = {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": 1.0}


def exact(region, velocity=None, **more):
    """Entry of a body that is exact to its surface."""
    entry = {"material": "solid", "region": region, "formulation": "total-lagrangian"}
    return entry | ({"velocity": velocity} if velocity is not None else {}) | more


def energy(line):
    return line["kinetic-energy"] + line["strain-energy"]


def parted(sim, names, quiet, each=None):
    """Advance until bodies have been apart for a time; lines before and after, and time in touch.

    The third of what is returned also has the greatest energy at a step's end, over the first.
    `each` is called after every step.
    """
    first = before = sim.diagnostics()
    most = 0.0
    column = f"contact.{'+'.join(names)}.normal-impulse"
    met = last = None
    pushed = 0.0
    while not sim.finished:
        sim.advance()
        if each:
            each(sim)
        line = sim.diagnostics()
        most = max(most, energy(before) + 0.5 * (line["kinetic-energy"] - before["kinetic-energy"]))
        before = line
        if line[column] != pushed:
            pushed, last = line[column], line["time"]
            met = last if met is None else met
        elif met is not None and line["time"] - last > quiet:
            break
    return first, line, (met, last, most)


def rebound(sim, names, masses, way, quiet, each=None):
    """Relative speed after over before, change of momenta and energy over what they are."""
    first, last, (_, _, most) = parted(sim, names, quiet, each)
    D = sim.scene.dimension

    def velocity(line, body):
        return np.array([line[f"body.{body}.momentum-{x}"] for x in "xyz"[:D]]) / masses[body]

    before, after = (velocity(line, names[0]) - velocity(line, names[1]) for line in (first, last))
    speed = before @ way
    scale = masses[names[0]] * abs(speed)
    momentum = max(abs(last[f"momentum-{x}"] - first[f"momentum-{x}"]) for x in "xyz"[:D]) / scale
    own = 0.25 * scale * abs(speed)  # what the speed of approach has
    lost = (energy(first) - energy(last)) / own
    turn = 0.0
    if D == 2:
        turn = abs(last["angular-momentum-z"] - first["angular-momentum-z"]) / scale
    return {"restitution": -(after @ way) / speed, "momentum": momentum, "lost": lost,
            "spin": turn, "most": most / energy(first)}  # fmt: skip


def bars(cells, V=(0.0, 0.0), offset=(0.37, 0.21), high=4.0, poisson=0.0, mass="lumped"):
    """Bars of so many cells, strips on which nothing acts sideways, meet at .02 of c."""
    v, gap, low = 0.01, 0.5, 2.0
    y = np.array([0.23, 0.71])
    c = sqrt(YOUNG)
    a = box([low + offset[0], low + y[0]], [low + offset[0] + cells, low + y[0] + high])
    x = low + offset[0] + cells + gap
    b = box([x, low + y[0]], [x + cells, low + y[0] + high])
    end = (gap / (2.0 * v) + 4.0 * cells) / c
    way = np.array(V) * c * end
    size = [2.0 * cells + gap + 6.0 + abs(way[0]), high + 5.0 + abs(way[1])]
    solid = SOLID | {"poisson": poisson}
    bodies = {
        "a": exact(a, [c * (V[0] + v), c * V[1]]), "b": exact(b, [c * (V[0] - v), c * V[1]])
    }  # fmt: skip
    case = case_of(np.ceil(size), 1.0, {"solid": solid}, bodies, end,
                   contact=[{"bodies": ["a", "b"]}])  # fmt: skip
    case["method"] |= {"mass": mass}
    masses = dict.fromkeys(("a", "b"), cells * high)
    return rebound(core(case), ("a", "b"), masses, np.array([1.0, 0.0]), 0.5 * cells / c)


def disks(R, V=(0.0, 0.0), offset=(0.0, 0.0, 0.37, 0.21), v=0.01, friction=0.0):
    """Disks of a radius in cells meet at 2 v along x; the second is farther by the offset."""
    gap = 0.5
    one = np.array([R + 3.0 + offset[0], R + 3.0 + offset[1]])
    # The line of centres is along x: the bodies lie differently in their cells.
    other = one + np.array([2.0 * R + gap, 0.0])
    way = np.array([1.0, 0.0])
    end = (gap / (2.0 * v) + 14.0 * R) / C
    moved = np.array(V) * C * end
    size = [4.0 * R + gap + 8.0 + abs(moved[0]), 2.0 * R + 8.0 + abs(moved[1])]
    bodies = {
        "a": exact(ball(one, R), [C * (V[0] + v), C * V[1]]),
        "b": exact(ball(other, R), [C * (V[0] - v), C * V[1]]),
    }
    sim = core(case_of(np.ceil(size), 1.0, {"solid": SOLID}, bodies, end,
                       contact=[{"bodies": ["a", "b"], "friction": friction}]))  # fmt: skip
    mass = np.pi * R * R
    return rebound(sim, ("a", "b"), {"a": mass, "b": mass}, way, 2.0 * R / C)
