"""Tables of measurements, as Markdown and as CSV with all digits, and on what was measured."""

import os
import platform
import subprocess
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path
from statistics import median

import llvmlite.binding
from workers.clock import VARIABLE

from pgimp.io.rundir.runinfo import cpu

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "scripts"))  # where the tables of studies are, too

from studies import harness  # noqa: E402


def machine():
    """Model of the CPU and number of cores."""
    features = llvmlite.binding.get_host_cpu_features()
    wide = next((name for name in ("avx512f", "avx2", "avx") if features.get(name)), "no AVX")
    return f"{cpu() or platform.machine()} ({os.cpu_count()} cores, {wide})"


def mpi():
    """Name and version of the MPI library that mpirun belongs to."""
    try:
        done = subprocess.run(["mpirun", "--version"], capture_output=True, text=True)
    except OSError:
        return "no MPI"
    return done.stdout.partition("\n")[0].replace("mpirun (", "").replace(")", "")


def commit(root=ROOT):
    """The commit that a checkout has, with a plus if files differ from it."""
    words = ["git", "-C", str(root), "describe", "--always", "--dirty=+", "--abbrev=9"]
    try:
        done = subprocess.run(words, capture_output=True, text=True)
    except OSError:
        return ""
    return f" ({done.stdout.strip()})" if done.returncode == 0 else ""


def origin(**others):
    """Machine, versions and date of a measurement; `others` are versions by name."""
    versions = [f"pgimp {version('pgimp')}{commit()}"]
    versions += [f"{name} {version(name)}" for name in ("numpy", "numba")]
    llvm = ".".join(map(str, llvmlite.binding.llvm_version_info))
    versions += [f"LLVM {llvm}", mpi(), f"Python {platform.python_version()}"]
    versions += [f"{name} {number}" for name, number in others.items()]
    shared = ", CPU time instead of wall time" if os.environ.get(VARIABLE) else ""
    return f"{machine()}, {', '.join(versions)}, {date.today()}{shared}"


def spread(values, digits=1):
    """Median of some measurements, with the least and the greatest."""
    return f"{median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def number(value, digits=1):
    return "" if value is None else f"{value:.{digits}f}"


def count(value):
    return "" if value is None else f"{value:,.0f}"


def error(value):
    return "" if value is None else f"{value:.0e}"


#: Columns of the errors against the exact motion.
ERRORS = {
    "error of velocity": lambda row: error(row["velocity"]),
    "error of stress": lambda row: error(row["stress"]),
}


def table(titles, rows):
    return harness.table(titles, rows).rstrip("\n")


def markdown(columns, rows):
    """A table: `columns` maps its titles to functions that word a row's cell."""
    return table(columns, ([word(row) for word in columns.values()] for row in rows))


def write(folder, name, title, columns, rows, note):
    """Write NAME.md and NAME.csv; returns the table with its title and note.

    `columns` are those of `markdown`, `rows` dicts with the same keys; lists become a column for
    each of their values. The note says what the table shows, and on what it was measured.
    """
    flat = []
    for row in rows:
        line = {}
        for key, value in row.items():
            if isinstance(value, list | tuple):
                line |= {f"{key} {i + 1}": each for i, each in enumerate(value)}
            else:
                line[key] = value
        flat.append(line)
    harness.write_csv(flat, folder / f"{name}.csv")
    text = f"## {title}\n\n{markdown(columns, rows)}\n\n{note}\n"
    (folder / f"{name}.md").write_text(text, encoding="utf-8")
    print(text, flush=True)
    return text
