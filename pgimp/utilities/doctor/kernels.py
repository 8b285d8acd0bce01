"""Checks of Numba and its cached kernels: write access, and types of CPU."""

from __future__ import annotations

import pickletools
import re
from collections.abc import Iterator
from pathlib import Path

from pgimp.errors import UsageError
from pgimp.jit.compiled import sealed
from pgimp.jit.compiled.folder import preferred_folder
from pgimp.utilities.doctor.finding import Finding
from pgimp.utilities.doctor.probe import ask

PROBE = """
import json
from pgimp.jit.compiled import folder
from pgimp.jit import kernel
import llvmlite.binding, numba
assert numba.njit(lambda x: x + 1)(1) == 2
print(json.dumps({
    "version": numba.__version__,
    "cpu": llvmlite.binding.get_host_cpu_name(),
    "folder": str(kernel.FOLDER.path),
    "preferred": str(folder.preferred_folder()),
    "why_not": kernel.FOLDER.why_not,
    "compiles": not numba.config.DISABLE_JIT,
}))
"""

#: Features of an LLVM target, such as +avx2,-avx512f; in a kernel's key after the CPU's name.
_FEATURES = re.compile(r"[+-][\w.-]+(,[+-][\w.-]+)+")
_MOST_FILES = 200


def examine() -> Iterator[Finding]:
    """Check Numba, the folder of its kernels, and the files in it."""
    try:
        preferred_folder()
    except UsageError as error:
        yield Finding("Numba", "PGIMP_CACHE_DIR is empty", str(error), True)
        return
    tried = ask(PROBE)
    if isinstance(tried, str):
        yield Finding("Numba", tried, "run scripts/setup again, or: pip install numba", True)
        return
    found = f"{tried['version']} for {tried['cpu']}, kernels kept in {tried['folder']}"
    if not tried["compiles"]:
        yield Finding(
            "Numba",
            f"{tried['version']}, but NUMBA_DISABLE_JIT keeps it from compiling",
            "unset NUMBA_DISABLE_JIT: without compiled kernels pgimp is a hundred times slower",
        )
    elif tried["why_not"]:
        yield Finding(
            "Numba",
            found,
            f"they belong into {tried['preferred']}, but {tried['why_not']}, so that they are "
            "compiled again on every fresh machine; export PGIMP_CACHE_DIR=FOLDER, one that only "
            "you can write to, from all nodes",
        )
    else:
        yield Finding("Numba", found)
    yield from types_of_cpu(Path(tried["folder"]))


def types_of_cpu(folder: Path) -> Iterator[Finding]:
    """Report nodes with different CPUs, by their kernels in the same folder."""
    targets = cached_targets(folder)
    if len(targets) > 1:
        cpus = sorted({cpu for cpu, _ in targets})
        sets = "" if len(cpus) == len(targets) else f" with {len(targets)} sets of instructions"
        yield Finding(
            "CPU types",
            f"the kernels kept are for {', '.join(cpus)}{sets}: nodes of several types run pgimp",
            "runs are the same bit for bit, and can be compared or resumed so, on nodes of one "
            "type only; ask for one, as in: pgimp batch CASE.yaml --extra=--constraint=TYPE",
        )


def cached_targets(folder: Path) -> set[tuple[str, str]]:
    """Return the CPUs, name and instructions, of the kernels in a folder."""
    targets = set()
    for path in sorted(folder.rglob("*.nbc"))[:_MOST_FILES]:
        before = ""
        for text in _texts(path):
            if _FEATURES.fullmatch(text):
                targets.add((before, text))
            before = text
    return targets


def _texts(path: Path) -> Iterator[str]:
    """Yield the strings of a kernel's key, the file's first pickle; no object is created."""
    try:
        for _, argument, _ in pickletools.genops(sealed.read(path)):
            if isinstance(argument, str):
                yield argument
    except (OSError, sealed.UntrustedError):  # a run replaces it
        return
