"""Measures soils, fluids and gases and writes the table of their page; see scripts/flows."""

from typing import Literal, NamedTuple

import numpy as np
from studies.flow.rows import ROWS
from studies.harness import TABLES, Kept, Table, options_of, origin, out, put, standing, table
from studies.scenes import by_turns, case_of, filled

import pgimp
from pgimp.physics.materials import Material

_SOIL = {"young": 1.0e3, "poisson": 0.3, "cohesion": 1.0, "friction-angle": 30.0}


class NothingParameters(NamedTuple):
    """A material that computes nothing: what a step costs without any."""

    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        return sigma

    @staticmethod
    def energy(material, F, J, sigma):
        return 0.0 * J

    @staticmethod
    def speed(material, F, J):
        return 30.0 + 0.0 * J


@pgimp.register_material
class Nothing(Material):
    """Its entry."""

    model: Literal["nothing"]

    def parameters(self):
        return NothingParameters(self.density)


#: Materials whose cost is measured; the others' is over that of the first.
LAWS = {
    "neo-hookean": {"young": 1.0e3, "poisson": 0.3},
    "neo-hookean with volumetric: b-bar": {"young": 1.0e3, "poisson": 0.3},
    "none: a stress that stays zero": {"model": "nothing"},
    "newtonian": {"bulk": 1.0e3, "shear-viscosity": 0.03},
    "newtonian without viscosity": {"bulk": 1.0e3},
    "bingham": {"bulk": 1.0e3, "shear-viscosity": 0.3, "yield-stress": 1.0},
    "ideal-gas": {"gamma": 1.4, "energy": 100.0}, "drucker-prager": _SOIL, "mohr-coulomb": _SOIL,
    "cam-clay": {
        "m": 1.2, "lambda": 0.2, "kappa": 0.04, "void-ratio": 1.0, "shear": 500.0,
        "preconsolidation": 10.0,
    },
    "mu-i": {
        "young": 1.0e3, "poisson": 0.3, "mu-s": 0.38, "mu-2": 0.64, "i0": 0.28, "grain": 0.01,
        "grain-density": 2.0,
    },
}  # fmt: skip


def _block(law, name, cells):
    """A block in 3D that flies through the cells."""
    entry = {"model": name.split()[0], "density": 1.0} | law
    body = {"material": "law", "velocity": [3.0, 1.0, 0.5]}
    body |= filled([4.0] * 3, [4.0 + cells] * 3)
    return pgimp.Simulation(case_of(
        [cells + 8.0] * 3, 1.0, {"law": entry}, {"block": body}, 10.0, time={"step": 1.0e-3},
        method={"volumetric": "b-bar"} if "mean" in name else {},
    ))  # fmt: skip


def _costs(cells, rounds):
    """Particle-steps/s of each material in 3D, and over neo-Hookean: medians of turns."""
    sims = [_block(law, name, cells) for name, law in LAWS.items()]
    spent = by_turns(sims, rounds, 4)[1:]
    speeds = len(sims[0].particles["id"]) / np.median(spent, axis=0) / 1e6
    parts = np.median(spent[:, :1] / spent, axis=0)
    return list(zip(LAWS, speeds.tolist(), parts.tolist(), strict=True))


def _cells_of(value, reference):
    text = f"{value:.4g}"
    if reference:
        text += f" ({100.0 * (value / reference - 1.0):+.2g} %)"
    return text


def _problems(kept, quick, only=""):
    """The table of problems; what `kept` has is not measured again.

    Rows whose function is not `only`, if that is given, are those of the table that there is.
    """
    known, there, head = kept.setdefault("problems", {}), standing("soils-and-fluids"), ""
    shown = Table("problem", "reference", "measured (error), two cell sizes",
                  "million particle-steps/s")  # fmt: skip
    for words, reference, (function, *rest), place, cells in ROWS:
        head = head if words.startswith("the same") else words
        if only and only != function.__name__:
            if (head, words) in there:
                shown.keep(words, *there[head, words])
            continue
        found = []
        for cell in cells[: 1 if quick else 2]:
            key = " ".join(map(str, (function.__name__, *rest, cell)))
            if key not in known:
                known[key] = function(cell, *rest)
                kept.save()
            found.append(known[key])
        values = ", ".join(_cells_of(each[0][place], reference) for each in found)
        speeds = ", ".join(f"{each[1] / 1e6:.1f}" for each in found if each[1])
        shown.add(words, "" if reference is None else f"{reference:g}", values, speeds)
    return shown


def _costs_table(rows, cells):
    head = f"What the materials cost: a block of {8 * cells**3:,} particles, 3D, gimp, one core."
    rows = [(name, f"{speed:.1f}", f"{part:.2f}") for name, speed, part in rows]
    return f"{head}\n\n{table(('material', 'million particle-steps/s', 'over neo-hookean'), rows)}"


def main():
    """Measure, and write flows.out/flows.md and docs/soils-and-fluids.md."""
    options = options_of(
        "flows", quick="coarse cells alone; writes no page",
        words={"nargs": "*", "metavar": "WHAT", "help": "problems, costs; both by default"},
        only={"choices": sorted({row[2][0].__name__ for row in ROWS})},
    )  # fmt: skip
    if options.only:
        _replace(options.only)
        return
    kept = Kept(out("flows") / ("quick.json" if options.quick else "flows.json"))
    words = options.words or ["problems", "costs"]
    kept |= {word: {} for word in words} | {"origin": origin()}
    text = _problems(kept, options.quick).text()
    cells = 8 if options.quick else 16
    if "costs" in words:
        kept.add("costs", _costs(cells, 3 if options.quick else 9))
    if kept.get("costs"):
        text += "\n" + _costs_table(kept["costs"], cells)
    note = f"By `scripts/flows`: {kept['origin']}. Speeds are per second of CPU time of one rank."
    put({"soils-and-fluids": f"{text}\n{note}\n"}, out("flows") / "flows.md", not options.quick)


def _replace(only):
    """Measure the problems of one function anew, and leave the rest of the table."""
    _, rest = (TABLES / "soils-and-fluids.md").read_text("utf-8").split("\n\n", 1)
    found = _problems(Kept(out("flows") / "only.json", new=True), False, only)
    put({"soils-and-fluids": f"{found.text()}\n{rest}"}, out("flows") / "flows.md")
