"""Instructions of the step's kernels, counted by valgrind: a figure that noise cannot move.

Numba under valgrind would take minutes to start, so a step is recorded first: which kernels it
called, and with what. They are compiled for one kind of CPU (`CPU`) and linked to a small program
that does those calls and nothing else, and that program runs under valgrind, once with each number
of calls. The differences are the kernels' own instructions, exact and the same on any machine with
the same versions of Numba, LLVM and libm.
"""

import json
import os
import pickle
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

import numba
import numpy as np
from blocks import block, create
from numba.core.dispatcher import Dispatcher
from report import number, origin, write

from pgimp.solver import particle_groups, transfers, vertices
from pgimp.solver.contact import base

#: What calls the kernels of a step.
CALLERS = (transfers, particle_groups, vertices, base)
#: What kernels are compiled for, whatever the machine: AVX2; valgrind does not know AVX-512.
CPU = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": ""}
#: Scenes by name: cells of a block of gimp particles at random places, 2 a cell and direction.
SCENES = {"2D": (16, 16), "3D": (8, 8, 8)}
#: The kernels that do the work, which the test watches.
HOT = ("particles_to_grid", "grid_to_particles")
#: Steps before the recorded one.
BEFORE = 3


def record(name):
    """Kernel calls of one step of a scene: (module, function, arguments as they were), and work.

    The name of a scene with ``-own`` behind it: particles have a stiffness of their own.
    """
    case = block(SCENES[name.removesuffix("-own")])
    if name.endswith("-own"):
        solid = case["materials"]["solid"]
        young = {"layers": [[0.0, solid["young"]]], "over": "x"}
        case["materials"] = {"solid": solid | {"young": young}}
    sim = create(case, random=True)
    for _ in range(BEFORE):
        sim.advance()
    calls = []
    kernels = [
        (caller, n, each) for caller in CALLERS for n, each in vars(caller).items()
        if isinstance(each, Dispatcher)
    ]  # fmt: skip

    def recorder(kernel):
        def call(*arguments):
            calls.append((kernel.__module__, kernel.__name__, pickle.dumps(arguments)))
            return kernel(*arguments)

        return call

    for caller, n, kernel in kernels:
        setattr(caller, n, recorder(kernel))
    try:
        sim.advance()
    finally:
        for caller, n, kernel in kernels:
            setattr(caller, n, kernel)
    return calls, sim.count


def compiled(module, function, arguments):
    """Assembly of a kernel for such arguments, and the function's name."""
    kernel = getattr(import_module(module), function)
    kernel.compile(tuple(numba.typeof(each) for each in arguments))
    (result,) = kernel.overloads.values()
    return result.library.get_asm_str(), result.fndesc.llvm_func_name


class Arguments:
    """Arguments of kernels in C, flat as Numba passes them; arrays go into one file."""

    def __init__(self):
        self.data = bytearray()

    def flat(self, value):
        """Pairs of C type and C text of a value."""
        if isinstance(value, np.ndarray):
            self.data += bytes(-len(self.data) % 64)
            place = len(self.data)
            self.data += value.tobytes() + bytes(64)
            numbers = [value.size, value.itemsize]
            after = [*value.shape, *value.strides]
            return [
                *[("void *", "0")] * 2, *(("int64_t", str(n)) for n in numbers),
                ("void *", f"data + {place}"), *(("int64_t", str(n)) for n in after),
            ]  # fmt: skip
        if isinstance(value, tuple):
            return [pair for each in value for pair in self.flat(each)]
        if isinstance(value, bool):
            return [("int8_t", str(int(value)))]
        if isinstance(value, int | np.integer):
            return [("int64_t", str(int(value)))]
        return [("double", float(value).hex().replace("inf", "__builtin_inf()"))]


#: A move between registers, of whose two encodings valgrind 3.19 does not know the shorter one.
_MOVE = re.compile(r"\b(vmovq\s+%xmm\d+, %xmm\d+)")
PROGRAM = """\
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
%(declarations)s
static char result[4096];
static void *error;
int main(int words, char **word) {
    char *data = aligned_alloc(64, %(size)d);
    FILE *file = fopen(word[1], "rb");
    int todo = atoi(word[2]), failed = 0;
    if (!file || fread(data, 1, %(size)d, file) != %(size)d) return 2;
%(calls)s
    return failed;
}
"""


def build(folder):
    """Write and link the program in the folder, which has the recorded calls."""
    flat, declarations, lines, sources = Arguments(), [], [], ["calls.c"]
    calls = pickle.loads((folder / "calls.pickle").read_bytes())
    for place, (module, function, pickled) in enumerate(calls):
        arguments = pickle.loads(pickled)
        text, symbol = compiled(module, function, arguments)
        sources.append(f"{place}.s")
        (folder / sources[-1]).write_text(_MOVE.sub(r"{load} \1", text))
        pairs = flat.flat(arguments)
        types = ", ".join(kind for kind, _ in pairs)
        declarations.append(f'int call{place}(void *, void **, {types}) __asm__("{symbol}");')
        values = ", ".join(value for _, value in pairs)
        lines.append(f"    if (todo > {place}) failed |= call{place}(result, &error, {values});")
    flat.data += bytes(-len(flat.data) % 64)
    (folder / "data").write_bytes(flat.data)
    text = PROGRAM % {
        "declarations": "\n".join(declarations), "calls": "\n".join(lines), "size": len(flat.data),
    }  # fmt: skip
    (folder / "calls.c").write_text(text)
    # What a kernel has for Python is never reached, and stays unresolved.
    options = ["-O1", "-no-pie", "-Wl,-z,now", "-Wl,--unresolved-symbols=ignore-all"]
    subprocess.run(["gcc", *options, "-o", "calls", *sources, "-lm"], cwd=folder, check=True)


def count(folder, calls):
    """Instructions of the program with `calls` calls."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    command += ["./calls", "data", str(calls)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found:
        raise SystemExit(f"benchmark: valgrind failed: {done.stderr[-2000:]}")
    return int(found[1])


def measure(name):
    """Instructions for a particle-step of each kernel of a scene's step, {kernel: number}."""
    with TemporaryDirectory() as made:
        folder = Path(made)
        calls, particles = record(name)
        (folder / "calls.pickle").write_bytes(pickle.dumps(calls))
        # In a cache folder of its own: only fresh compilation gives assembly.
        env = os.environ | CPU | {"PGIMP_CACHE_DIR": str(folder / "cache")}
        subprocess.run([sys.executable, __file__, "build", made], env=env, check=True)
        counts = [count(folder, number) for number in range(len(calls) + 1)]
    found: dict[str, float] = {}
    for (_, kernel, _), less, more in zip(calls, counts, counts[1:], strict=False):
        found[kernel] = found.get(kernel, 0.0) + (more - less) / particles
    return found


def main(folder, quick):
    """Count, write instructions.md and instructions.csv, and print the lines for the test."""
    rows, lines = [], []
    for name in ["2D"] if quick else SCENES:
        found = measure(name)
        rows.append({"scene": name, **found, "all": sum(found.values())})
        hot = {kernel: round(found[kernel], 1) for kernel in HOT}
        lines.append(f'    "{name}": {hot},'.replace("'", '"'))
    kernels = [key for key in rows[0] if key != "scene"]
    columns = {"scene": lambda row: f"{row['scene']}, gimp, neo-hookean, random"}
    columns |= {name: lambda row, name=name: number(row[name], 1) for name in kernels}
    note = (
        "Instructions for a particle-step, of each kernel in a step of a small block (with what "
        f"its planes cost), compiled for {CPU['NUMBA_CPU_NAME']}. For "
        "tests/scripts/test_instructions.py:"
        "\n\n```python\nCOUNTS = {\n" + "\n".join(lines) + f"\n}}\n```\n\n{origin()}"
    )
    write(folder, "instructions", "Instructions", columns, rows, note)
    return rows


if __name__ == "__main__":  # in processes of their own: to compile, and for the test
    if sys.argv[1] == "build":
        build(Path(sys.argv[2]))
    else:
        print(json.dumps(measure(sys.argv[2])))
