"""What a run costs until its first step: with no compiled kernels, with some, with all of them.

Each round has a folder of compiled kernels of its own. A block on a floor is run in it for one
step, then the same with one thing changed at a time, and itself again. Whatever a change compiles
stays for the others. A second checkout is measured by turns, with an environment of its own.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from report import ROOT, commit, number, origin, write
from workers.processes import environment

CASE = """\
format: 1
dimensions: 3
grid: {size: [2.0, 1.2, 1.6], cell: [0.2, 0.2, 0.2]}
method: {shape: gimp, particles-per-cell: [2, 2, 2]}
time: {end: 1.0e-4, step: {courant: 0.3}}
materials:
  rubber: {model: neo-hookean, young: 3.0e5, poisson: 0.3, density: 1000.0}
bodies:
  block: {material: rubber, region: {box: {min: [0.4, 0.2, 0.4], max: [1.6, 1.0, 1.2]}}}
gravity: [0.0, 0.0, -9.81]
boundaries: {z-min: unilateral}
output: {fields: [velocity, stress, pressure, von-mises]}
"""
COLD, WARM = "a block on a floor, nothing compiled", "the block again, all compiled"
#: What is run in a folder of kernels, one after the other.
ROWS = {
    COLD: [],
    "then: another law, `hooke`": ["materials.rubber.model=hooke"],
    "then: `affine`": ["method.affine=true"],
    "then: `finite-gimp`": ["method.shape=finite-gimp"],
    "then: a traction on a region": [
        "tractions={lid: {body: block, pressure: 100.0, "
        "region: {box: {min: [0.3, 0.1, 1.1], max: [1.7, 1.1, 1.3]}}}}"
    ],
    "then: the initial configuration": ["bodies.block.formulation=total-lagrangian"],
    WARM: [],
}


def run(root, folder, words):
    """What the system counts of a checkout's Python, in a folder where kernels are kept.

    A checkout without an environment is run with this one.
    """
    python = root / ".venv" / "bin" / "python"
    env = environment({"PGIMP_CACHE_DIR": str(folder / "kernels"), "PYTHONPATH": str(root),
                       "PYTHONDONTWRITEBYTECODE": ""})  # fmt: skip
    program = str(python) if python.exists() else sys.executable
    process = subprocess.Popen([program, *words], cwd=folder, env=env)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"benchmark: a process of {root} ended with status {status}")
    return used


def measure(root, folder, changes):
    """CPU seconds of a run of one step, with all that it starts, and its peak memory in MB."""
    (folder / "case.yaml").write_text(CASE, encoding="utf-8")
    words = ["-m", "pgimp", "case.yaml", "-o", "run.out", "--overwrite", "--quiet"]
    words += [word for change in changes for word in ("--set", change)]
    used = run(root, folder, words)
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3


def main(folder, quick, beside=None):
    """Measure all rows, by turns with a second checkout `beside`, and write compile.md and .csv."""
    rounds, rows = (1, {COLD: [], WARM: []}) if quick else (3, ROWS)
    roots = [ROOT] + ([Path(beside).resolve()] if beside else [])
    found = {(name, root): [] for name in rows for root in roots}
    for root in roots:  # their bytecode
        run(root, Path("."), ["-c", "import pgimp.commands.check, pgimp.running.resume"])
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as place:
            for name, changes in rows.items():
                for k, root in enumerate(roots):
                    own = Path(place) / str(k)
                    own.mkdir(exist_ok=True)
                    found[name, root].append(measure(root, own, changes))
    columns = {"": lambda row: row["scene"]}
    for k, root in enumerate(roots):
        title = f", {commit(root).strip(' ()')}" if beside else ""
        columns[f"CPU seconds{title}"] = lambda row, k=k: number(row[f"seconds {k}"])
        columns[f"MB{title}"] = lambda row, k=k: number(row[f"memory {k}"], 0)
    table = [
        {"scene": name}
        | {f"seconds {k}": median(one for one, _ in found[name, root])
           for k, root in enumerate(roots)}
        | {f"memory {k}": max(one for _, one in found[name, root]) for k, root in enumerate(roots)}
        for name in rows
    ]  # fmt: skip
    note = (
        "CPU seconds, with those of the system, and peak memory of `pgimp CASE.yaml` on one rank "
        f"until its first step, and its end there; median of {rounds}. Measured on {origin()}."
    )
    write(folder, "compile", "Compiling", columns, table, note)
