"""Exceptions that compiled functions of one's own raise: which function, file and line."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterable
from itertools import takewhile
from pathlib import Path

from pgimp.errors import is_library, is_outside
from pgimp.physics.functions.registry import FUNCTIONS, Function


def raised_by(error: BaseException, known: Function | None = None) -> str:
    """Describe an exception by the function of one's own that has raised it.

    Parameters
    ----------
    error : BaseException
        As a kernel has raised it: its last frame is that of the compiled function.
    known : Function, optional
        The function, if it is known.

    Returns
    -------
    str
        Empty if the exception is of no such function.
    """
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return ""
    at = frames[-1]
    at = traceback.FrameSummary(_loaded(at.filename), at.lineno, at.name)
    found = known or next((one for one in FUNCTIONS.values() if _has(one, at)), None)
    if found is None and (not is_outside(at.filename) or is_library(at.filename)):
        return ""
    what = " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")
    if found is None:  # a material's, or a helper
        return f"the function '{at.name}' ({at.filename}:{at.lineno}) raises {what}"
    file = found.function.__code__.co_filename
    place = f" in line {at.lineno}" if at.filename == file else ""
    return f"{found} raises {what}{place}"


def _loaded(filename: str) -> str:
    """Path of the loaded module whose file this is a copy of: the one whose end agrees most.

    Kernels from disk know the path that their functions had when they were compiled.
    """
    files = {file for one in (*sys.modules.values(),) if (file := getattr(one, "__file__", None))}
    if filename in files:
        return filename
    end = Path(filename).parts[::-1]
    agree = {
        file: sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], _pairs(end, file)))
        for file in sorted(files)
        if not is_library(file)
    }
    best = max(agree, key=lambda file: agree[file], default=filename)
    return best if agree.get(best) else filename


def _pairs(end: tuple[str, ...], file: str) -> Iterable[tuple[str, str]]:
    """Parts of two paths side by side, from their ends on."""
    return zip(end, Path(file).parts[::-1], strict=False)


def _has(function: Function, at: traceback.FrameSummary) -> bool:
    code = function.function.__code__
    return (code.co_filename, code.co_name) == (at.filename, at.name)
