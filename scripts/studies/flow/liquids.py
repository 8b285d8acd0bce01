"""Measures liquids over long times, and writes their table; see scripts/flows."""

import numpy as np
from studies.flow import problems
from studies.harness import Kept, Table, options_of, origin, out, put
from studies.scenes import box, case_of, filled, looked

#: Depth of still and of sloshing water, in cells; sound at ten times sqrt(g depth).
DEPTH = 8.0
#: sqrt(depth/g).
UNIT = DEPTH**0.5
#: Exponent of Tait's law.
POWER = 7.0


def tank(size, depth, method, dimensions=2, bulk=800.0):
    """A tank of cells of 1, filled to a depth; gravity 1."""
    top = [*size[:-1], depth]
    sides = {f"{axis}-{end}": "slip" for axis in "xyz"[:dimensions] for end in ("min", "max")}
    sides.pop(f"{'xyz'[dimensions - 1]}-max")
    return case_of(
        size, 1.0, {"water": {"model": "newtonian", "bulk": bulk, "density": 1.0}},
        {"water": {"material": "water"} | filled([0.0] * dimensions, top)}, 1.0e6, method=method,
        gravity=[0.0] * (dimensions - 1) + [-1.0], boundaries=sides,
    )  # fmt: skip


def run(case, end, look, every):
    """Run to `end`; what `look` sees at times `every` apart, and particle-steps per CPU second."""
    return looked(case, np.arange(every, end + 0.5 * every, every), look)[:2]


def compressed(depth, bulk):
    """Height of the centre of water at rest over half its depth before it bore its weight.

    Tait's J at the pressure of the mass above, integrated over the mass.
    """
    s = (np.arange(4000) + 0.5) / 4000.0  # part of the mass that is below
    J = (1.0 + POWER * (1.0 - s) * depth / bulk) ** (-1.0 / POWER)
    return float(2.0 * (np.cumsum(J) / 4000.0 - 0.5 * J / 4000.0).mean())


def still(method, dimensions):
    """Water at rest after 100 sqrt(depth/g): error of its centre, noise of its pressure, speed."""
    size = [8.0, 16.0] if dimensions == 2 else [4.0, 4.0, 12.0]
    up = dimensions - 1

    def look(sim):
        particles = sim.particles
        y, p = particles["position"][:, up], -particles["stress"][:, :3].mean(axis=1)
        off = p - np.polyval(np.polyfit(y - y.mean(), p, 4), y - y.mean())  # the swing is smooth
        return y.mean(), np.sqrt(np.mean(off**2)) / DEPTH

    # Gravity acts at once: the water swings by a period of 0.4, whose mean counts.
    seen, speed = run(tank(size, DEPTH, method, dimensions), 100.0 * UNIT, look, 0.05 * UNIT)
    last = np.array(seen[-400:])
    level = float(last[:, 0].mean() / (0.5 * DEPTH) / compressed(DEPTH, 800.0) - 1.0)
    return level, float(last[:, 1].mean()), None, speed


def slosh(method, dimensions):
    """Water that sloshes for 20 periods: error of its centre, noise, of its frequency; speed.

    It is started by a gravity that leans for half a period; crests are a cell high. Of water that
    is as stiff as this the frequency is 0.3 % lower than that of Airy's waves, which counts.
    """
    depth, bulk, up = 2.0 * DEPTH, 200.0 * DEPTH, dimensions - 1
    size = [2.0 * depth, *[2.0] * (dimensions - 2), 2.0 * depth]
    case = tank(size, depth, method, dimensions, bulk)
    k = np.pi / size[0]
    period = 2.0 * np.pi / np.sqrt(k * np.tanh(k * depth))
    none = [0.0] * (dimensions - 2)
    leaning, upright = [0.03, *none, -1.0], [0.0, *none, -1.0]
    at = 0.5 * period
    case["gravity"] = {"table": [[0.0, leaning], [at, leaning], [1.001 * at, upright]]}

    def look(sim):
        x = sim.particles["position"]
        return sim.time, x[:, 0].mean() - 0.5 * size[0], x[:, up].mean()

    seen, speed = run(case, 21.0 * period, look, period / 64.0)
    time, way, height = np.array(seen[64:]).T
    turns = np.flatnonzero(way[:-1] * way[1:] < 0.0)
    part = way[turns] / (way[turns] - way[turns + 1])
    through = time[turns] + part * (time[turns + 1] - time[turns])
    found = 2.0 * (through[-1] - through[0]) / (len(through) - 1)
    level = float(height[-128:].mean() / (0.5 * depth) / compressed(depth, bulk) - 1.0)
    return level, None, float(period / found - 1.0), speed


def dam(method, dimensions, cell):
    """The dam break after 10 s: error of its centre against that at rest; speed.

    Waves raise the centre: their potential energy, as much as their kinetic energy, is taken off.
    """
    changes = {"grid.cell": [cell, cell], "grid.size": [3.24, 2.4], "time.end": 10.0}
    changes |= {f"method.{key}": value for key, value in method.items()} | {"start.stress": None}
    centres = []

    def look(sim):
        if sim.time > 9.0:
            line = sim.diagnostics()
            waves = line["kinetic-energy"] / (line["mass"] * problems.G)
            centres.append(line["body.dam.centre-y"] - waves)

    _, speed = problems.done("dam-break", look, **changes)
    return float(np.mean(centres) / (0.5 * 0.72 / 3.24) - 1.0), None, None, speed


def floating(method, dimensions, wide=4.0):
    """A block of half the density of water that floats: error of its draught; speed.

    Exact: water and what of the block is in it fill the tank up to the level. It falls by a quarter
    of its width, and is looked at from 45 to 60 sqrt(depth/g).
    """
    across, depth, bulk = 4.0 * wide, 2.0 * wide, 600.0 * wide
    case = tank([across, across], depth, method, 2, bulk)
    begin = depth - 0.25 * wide
    block = box([1.5 * wide, begin], [2.5 * wide, begin + wide])
    case["bodies"]["water"]["region"] = {"difference": [box([0.0, 0.0], [across, depth]), block]}
    case["bodies"]["block"] = {"rigid": {"density": 0.5}, "region": block}
    case["contact"] = [{"bodies": ["water", "block"]}]
    case["method"]["pic-damping"] = 0.1
    water, unit = across * depth - 0.25 * wide * wide, depth**0.5

    def look(sim):
        return sim.diagnostics()["rigid.block.displacement-y"]

    seen, speed = run(case, 60.0 * unit, look, 0.5 * unit)
    bottom = begin + float(np.mean(seen[-30:]))
    draught = 0.5 * wide
    level = (water + draught * wide) / across
    level *= compressed(level, bulk)
    return float((level - bottom) / draught - 1.0), None, None, speed


_ALL = (
    {}, {"affine": True}, {"affine": True, "volumetric": "b-bar"}, {"shape": "finite-gimp"},
    {"shape": "cpdi"}, {"shape": "bspline-quadratic"},
)  # fmt: skip
#: Walls that reflect, the default, and such that do not.
_GHOSTS = tuple(method | {"wall": "ghost"} for method in _ALL[:4])
_WALLS, _STILL = (*_ALL[:2], *_GHOSTS[:3]), ({}, *_GHOSTS, *_ALL[4:])
#: What is measured: its words, with which methods, in how many dimensions, and further arguments.
ROWS = (
    ("still, 8 cells deep, 100 sqrt(D/g)", still, _STILL, (2, 3), ()),
    ("sloshing, 16 cells deep, crests of a cell, 20 periods", slosh, _WALLS, (2,), ()),
    ("dam break to 10 s, cells of 0.04 m", dam, _WALLS[:4], (2,), (0.04,)),
    ("the same, cells of 0.02 m", dam, (_WALLS[0], *_WALLS[2:4]), (2,), (0.02,)),
    ("a block floats (its draught), 4 cells wide", floating, (_WALLS[0], *_WALLS[2:4]), (2,), ()),
    ("the same, 8 cells wide", floating, (_WALLS[0], _WALLS[2]), (2,), (8.0,)),
)


def words_of(method):
    shape = method.get("shape", "gimp")
    said = {"affine": "affine", "volumetric": "b-bar", "wall": "wall: ghost"}
    return ", ".join([shape, *(words for key, words in said.items() if key in method)])


def table(kept, only):
    """The table; what `kept` has is not measured again."""
    found = Table(
        "water", "D", "method", "level", "pressure noise", "frequency", "million particle-steps/s"
    )
    for words, function, methods, every, rest in ROWS:
        if only and function.__name__ not in only:
            continue
        for dimensions in every:
            for method in methods:
                key = " ".join(map(str, (function.__name__, dimensions, words_of(method), *rest)))
                level, noise, frequency, speed = kept.of(key, function, method, dimensions, *rest)
                found.add(
                    words, dimensions, words_of(method), f"{100.0 * level:+.2f} %",
                    "" if noise is None else f"{100.0 * noise:.2f} %",
                    "" if frequency is None else f"{100.0 * frequency:+.2f} %",
                    f"{speed / 1e6:.1f}",
                )  # fmt: skip
    return found


def main():
    """Measure, and write flows.out/liquids.md and docs/soils-and-fluids.md."""
    only = {"nargs": "*", "help": "still, slosh, dam, floating: then no page"}
    options = options_of("flows liquids", only=only, new="measure all of it again")
    kept = Kept(out("flows") / "liquids.json", options.new)
    text = table(kept, options.only).text(f"By `scripts/flows liquids`: {origin()}.")
    put({"liquids": text}, out("flows") / "liquids.md", not options.only)
