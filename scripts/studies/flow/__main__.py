"""Measures soils, fluids and gases and writes the table of their page; see scripts/flows."""

import argparse
import json
import os
import subprocess
import sys
from datetime import date
from importlib.metadata import version
from time import process_time
from typing import Literal, NamedTuple

import numpy as np
from studies.flow import problems
from studies.flow.rows import ROWS

import pgimp
from pgimp.io.rundir.runinfo import cpu
from pgimp.physics.materials import Material

PAGES = problems.ROOT / "scripts" / "pages"
OUT = problems.OUT

_SOIL = {"young": 1.0e3, "poisson": 0.3, "cohesion": 1.0, "friction-angle": 30.0}


class NothingParameters(NamedTuple):
    """A material that computes nothing: what a step costs without any."""

    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        """As before: zero."""
        return sigma

    @staticmethod
    def energy(material, F, J, sigma):
        """None."""
        return 0.0 * J

    @staticmethod
    def speed(material, F, J):
        """That of the others, about."""
        return 30.0 + 0.0 * J


@pgimp.register_material
class Nothing(Material):
    """Its entry."""

    model: Literal["nothing"]

    def parameters(self):
        """See `NothingParameters`."""
        return NothingParameters(self.density)


#: Materials whose cost is measured; the others' is over that of the first.
LAWS = {
    "neo-hookean": {"young": 1.0e3, "poisson": 0.3},
    "neo-hookean with volumetric: mean": {"young": 1.0e3, "poisson": 0.3},
    "none: a stress that stays zero": {"model": "nothing"},
    "newtonian": {"bulk": 1.0e3, "shear-viscosity": 0.03},
    "newtonian without viscosity": {"bulk": 1.0e3},
    "bingham": {"bulk": 1.0e3, "shear-viscosity": 0.3, "yield-stress": 1.0},
    "ideal-gas": {"gamma": 1.4, "energy": 100.0},
    "drucker-prager": _SOIL,
    "mohr-coulomb": _SOIL,
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
    method = {"volumetric": "mean"} if "mean" in name else {}
    body = {"box": {"min": [4.0] * 3, "max": [4.0 + cells] * 3}}
    return pgimp.Simulation({
        "format": 1,
        "dimensions": 3,
        "grid": {"size": [cells + 8.0] * 3, "cell": [1.0] * 3},
        "method": {"shape": "gimp", "particles_per_cell": [2] * 3} | method,
        "time": {"end": 10.0, "step": 1.0e-3},
        "materials": {"law": entry},
        "bodies": {"block": {"material": "law", "region": body, "velocity": [3.0, 1.0, 0.5]}},
    })  # fmt: skip


def _costs(cells, rounds):
    """Particle-steps/s of each material in 3D, and over neo-Hookean: medians of turns."""
    sims = {name: _block(law, name, cells) for name, law in LAWS.items()}
    spent = {name: [] for name in LAWS}
    for _ in range(rounds):
        for name, sim in sims.items():
            began = process_time()
            sim.step(4)
            spent[name].append(process_time() - began)
    first = np.array(spent["neo-hookean"][1:])
    rows = []
    for name, times in spent.items():
        own = np.array(times[1:])
        speed = 4.0 * len(sims[name].particles["id"]) / np.median(own)
        rows.append((name, speed / 1e6, float(np.median(first / own))))
    return rows


def _cells_of(value, reference):
    text = f"{value:.4g}"
    if reference:
        text += f" ({100.0 * (value / reference - 1.0):+.2g} %)"
    return text


def _standing(lines):
    """Lines of a table by their words, and those of the row that they are like."""
    found, head = {}, ""
    for line in lines:
        words = line.split(" | ")[0].removeprefix("| ")
        head = head if words.startswith("the same") else words
        found[head, words] = line
    return found


def _problems(kept, quick, only="", standing=()):
    """Lines of the table of problems; what `kept` has is not measured again.

    Rows whose function is not `only`, if that is given, are taken from the lines `standing`.
    """
    standing, head = _standing(standing), ""
    lines = ["| problem | reference | measured (error), two cell sizes | million "
             "particle-steps/s |", "|---|---|---|---|"]  # fmt: skip
    for words, reference, (function, *rest), place, cells in ROWS:
        head = head if words.startswith("the same") else words
        if only and only != function.__name__:
            if (head, words) in standing:
                lines.append(standing[head, words])
            continue
        found = []
        for cell in cells[: 1 if quick else 2]:
            key = " ".join(map(str, (function.__name__, *rest, cell)))
            if key not in kept:
                kept[key] = function(cell, *rest)
            found.append(kept[key])
        values = ", ".join(_cells_of(each[0][place], reference) for each in found)
        speeds = ", ".join(f"{each[1] / 1e6:.1f}" for each in found if each[1])
        shown = "" if reference is None else f"{reference:g}"
        lines.append(f"| {words} | {shown} | {values} | {speeds} |")
        print(lines[-1], flush=True)
        yield lines


def _costs_table(rows, cells):
    lines = [f"What the materials cost: a block of {8 * cells**3:,} particles, 3D, gimp, one core.",
             "", "| material | million particle-steps/s | over neo-hookean |", "|---|---|---|"]
    return lines + [f"| {name} | {speed:.1f} | {part:.2f} |" for name, speed, part in rows]


def main():
    """Measure, and write flows.out/flows.md and docs/soils-and-fluids.md."""
    parser = argparse.ArgumentParser(prog="scripts/flows")
    parser.add_argument("words", nargs="*", metavar="WHAT", help="problems, costs; both by default")
    parser.add_argument("--quick", action="store_true", help="coarse cells alone; writes no page")
    parser.add_argument("--only", choices=sorted({row[2][0].__name__ for row in ROWS}))
    options = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    if options.only:
        _replace(options.only)
        return
    store = OUT / ("quick.json" if options.quick else "flows.json")
    kept = json.loads(store.read_text()) if store.exists() else {}
    words = options.words or ["problems", "costs"]
    for word in words:
        kept[word] = {} if word == "problems" else []
    versions = ", ".join(f"{name} {version(name)}" for name in ("pgimp", "numba", "numpy"))
    kept["origin"] = f"{cpu()} ({os.cpu_count()} cores), {versions}, {date.today()}"
    lines = []
    for lines in _problems(kept.setdefault("problems", {}), options.quick):
        store.write_text(json.dumps(kept, indent=1))
    cells = 8 if options.quick else 16
    if "costs" in words:
        kept["costs"] = _costs(cells, 3 if options.quick else 9)
        store.write_text(json.dumps(kept, indent=1))
    if kept.get("costs"):
        lines += ["", *_costs_table(kept["costs"], cells)]
    lines += ["", f"By `scripts/flows`: {kept['origin']}. Speeds are per second of CPU time of one "
              "rank."]  # fmt: skip
    _write("\n".join(lines) + "\n", options.quick)


def _replace(only):
    """Measure the problems of one function anew, and leave the rest of the table."""
    table, rest = (PAGES / "tables" / "soils-and-fluids.md").read_text("utf-8").split("\n\n", 1)
    *_, lines = _problems({}, False, only, table.splitlines())
    _write("\n".join(lines) + "\n\n" + rest, False)


def _write(text, quick):
    (OUT / "flows.md").write_text(text, encoding="utf-8")
    if not quick:
        (PAGES / "tables" / "soils-and-fluids.md").write_text(text, encoding="utf-8")
        subprocess.run([sys.executable, PAGES], check=True)
