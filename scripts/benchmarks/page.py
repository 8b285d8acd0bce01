"""The tables of docs/performance.md, made from the CSV files of what was measured."""

import csv
import subprocess
import sys
from textwrap import fill

from report import ROOT, error, markdown, number

#: What scripts/pages writes pages from.
PAGES = ROOT / "scripts" / "pages"


def read(folder, name):
    """Rows of a CSV file, with numbers where there are some; none without the file."""
    path = folder / f"{name}.csv"
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def _value(text):
    try:
        return float(text)
    except ValueError:
        return text or None


def _origin(folder, name):
    """What a part was measured on, from the end of its note."""
    text = (folder / f"{name}.md").read_text(encoding="utf-8").strip()
    return text.rpartition(". ")[2]


def peers(folder):
    """Table of pgimp and its peers: a line for each scene."""
    rows = read(folder, "peers")
    found = {(r["dimension"], r["cores"], r["code"], r["kind"]): r for r in rows}
    codes = {
        "pgimp": ("pgimp", "random"), "pgimp, lattice": ("pgimp", "lattice"),
        "Taichi, GIMP": ("Taichi", "gimp"), "Taichi, MLS-MPM": ("Taichi", "mls-mpm"),
    }  # fmt: skip

    def cell(scene, code):
        row = found.get((*scene, *codes[code]))
        return "" if row is None else f"{number(row['speed'])} ({error(row['velocity'])})"

    columns = {
        "": lambda scene: f"{scene[0]:.0f}D, {scene[1]:.0f} core" + "s" * (scene[1] > 1),
        **{code: lambda scene, code=code: cell(scene, code) for code in codes},
    }
    scenes = list(dict.fromkeys(key[:2] for key in found if key[2] == "pgimp"))
    return markdown(columns, scenes) if rows else ""


def shapes(folder):
    """Table of the shapes: speeds at random positions and on a lattice, by dimension."""
    rows = [r for r in read(folder, "kernels") if r["material"] in ("neo-hookean", "linear-1d")]
    found = {
        (r["shape"], r["dimension"], r["positions"]): r
        for r in rows
        if r["particles per cell"] == 2 ** r["dimension"]
    }

    def cell(shape, D):
        pair = [found.get((shape, D, positions)) for positions in ("random", "lattice")]
        if None in pair:
            return ""
        worst = max(row["velocity"] for row in pair)
        return f"{number(pair[0]['speed'])}, {number(pair[1]['speed'])} ({error(worst)})"

    dimensions = list(dict.fromkeys(key[1] for key in found))
    columns = {"shape": lambda shape: shape} | {
        f"{D:.0f}D": lambda shape, D=D: cell(shape, D) for D in dimensions
    }
    return markdown(columns, list(dict.fromkeys(key[0] for key in found))) if found else ""


_SCALING = {
    "apart": "two runs of one rank beside each other, the most that the machine allows",
    "strong": "two ranks on the same block",
    "weak": "two ranks on one of twice the size",
}


def _wrapped(text):
    """The text in lines of 100 letters, tables as they are."""
    parts = (part if part[:1] in "|-" else fill(part, 100) for part in text.split("\n\n"))
    return "\n\n".join(parts)


def write(folder, into_docs):
    """Write page.md, and docs/performance.md with it if asked to."""
    texts = []
    if table := peers(folder):
        texts.append(
            "Million particle-steps/s of whole steps of a neo-Hookean block in free fall, float64, "
            "with the error of the velocity against the exact one; pgimp with contiguous GIMP, at "
            f"random positions unless said otherwise.\n\n{table}\n\n"
            f"Measured on {_origin(folder, 'peers')}."
        )
    if table := shapes(folder):
        texts.append(
            "The shapes on one core, at random positions and on a lattice, two particles a cell "
            f"and direction.\n\n{table}\n\nMeasured on {_origin(folder, 'kernels')}."
        )
    if rows := [row for row in read(folder, "features") if row["scene"].startswith("gimp, ")]:
        columns = {
            "a 3D block, gimp": lambda row: row["scene"].removeprefix("gimp, "),
            "million particle-steps/s": lambda row: number(row["speed"]),
            "over the plain one": lambda row: number(row["share"], 2),
            "error of velocity": lambda row: error(row["velocity"]),
        }
        texts.append(
            "What a scene uses is what it pays for: the block with features one by one, on one "
            f"core.\n\n{markdown(columns, rows)}\n\nMeasured on {_origin(folder, 'features')}."
        )
    facts = [
        f"{row['scene'].partition(',')[0]}, {_SCALING[row['kind']]}: "
        f"{number(row['gain'], 2)} times one rank"
        for row in read(folder, "scaling")
        if row["kind"] in _SCALING
    ]
    facts += [
        f"eight times the domain in every direction, {row['dimension']:.0f}D: "
        f"{number(row['time'], 3)} times the time, {number(row['memory ratio'], 3)} the memory"
        for row in read(folder, "domain")
        if row["time"] != 1.0
    ]
    if facts:
        texts.append("\n".join(f"- {fact}" for fact in facts))
    text = "\n\n".join(map(_wrapped, texts)) + "\n"
    (folder / "page.md").write_text(text, encoding="utf-8")
    if into_docs:
        if texts:
            (PAGES / "tables" / "benchmark.md").write_text(text, encoding="utf-8")
        if (compiling := folder / "compile.md").exists():
            _, _, table = compiling.read_text(encoding="utf-8").partition("\n\n")
            (PAGES / "tables" / "compile.md").write_text(
                f"{_wrapped(table.strip())}\n", encoding="utf-8"
            )
        subprocess.run([sys.executable, str(PAGES)], check=True)
