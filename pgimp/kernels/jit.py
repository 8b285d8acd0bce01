"""How pgimp uses Numba: reproducible code generation, one cache folder per version of the sources.

This is the only module that imports Numba first, because two settings must stand before:

- ``NUMBA_LOOP_VECTORIZE=0``: in a loop that LLVM vectorises, contraction to fused multiply-adds
  differs between the vector body and the scalar remainder, so that a particle's bits would depend
  on its place in the array. Kernels use explicit vectors instead (`pgimp.kernels.simd`).
- ``NUMBA_DISABLE_INTEL_SVML=1``: the vector maths library rounds differently from libm.

Neither is part of Numba's cache key, and editing a function does not invalidate the cached kernels
that call it; both are therefore put into the name of the cache folder. Kernels for a user's own
materials are in folders within it, see `pgimp.kernels.outside`.
"""

import hashlib
import os
import pickle
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

_SETTINGS = {"NUMBA_LOOP_VECTORIZE": "0", "NUMBA_DISABLE_INTEL_SVML": "1"}


#: Where all that Numba compiles is written, within the package; a test holds everyone to it.
COMPILED = ("kernels", "shapes", "materials", "boundaries", "exact", "solver/particles.py")


def _sources_digest() -> str:
    """Digest of the sources that Numba compiles and of the settings above."""
    digest = hashlib.sha256(repr(sorted(_SETTINGS.items())).encode())
    root = Path(__file__).resolve().parents[1]
    for name in COMPILED:
        for path in sorted((root / name).rglob("*.py")) or [root / name]:
            digest.update(str(path.relative_to(root)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _usable(folder: Path) -> bool:
    """Whether files can be created in the folder, which is made if missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def wanted_folder() -> Path:
    """Folder where the compiled kernels belong.

    Returns
    -------
    Path
        ``$PGIMP_CACHE_DIR``, else ``$XDG_CACHE_HOME/pgimp`` (default ``~/.cache/pgimp``), with a
        sub-folder for this version of the sources.
    """
    base = os.environ.get("PGIMP_CACHE_DIR")
    if base is None:
        home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
        base = os.path.join(home, "pgimp")
    return Path(base) / f"kernels-{_sources_digest()}"


def cache_folder() -> Path:
    """Folder of the compiled kernels: that wanted, or a temporary one where it cannot be written.

    Returns
    -------
    Path
        The folder, which is there.
    """
    folder = wanted_folder()
    if _usable(folder):
        return folder
    return _private(Path(tempfile.gettempdir()) / f"pgimp-{os.getuid()}") / folder.name


def _private(folder: Path) -> Path:
    """The folder if nobody else can write to it, or a new one: Numba executes what it finds."""
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        about = folder.lstat()
        own = stat.S_ISDIR(about.st_mode) and about.st_uid == os.getuid()
        if own and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            return folder
    return Path(tempfile.mkdtemp(prefix="pgimp-"))


_FOLDER = cache_folder()
os.environ.update(_SETTINGS)
os.environ["NUMBA_CACHE_DIR"] = str(_FOLDER)
if "numba" in sys.modules:  # imported by the user's program before: set what it has read already
    sys.modules["numba"].config.reload_config()

import numba  # noqa: E402
from numba.extending import overload  # noqa: E402

from pgimp.kernels.outside import KernelCache  # noqa: E402

#: Options of every kernel and of everything it inlines. Contraction only: full fastmath would let
#: LLVM reorder sums and delete the checks for NaN.
_OPTIONS: dict[str, Any] = {
    "fastmath": {"contract"},
    "error_model": "numpy",
    "boundscheck": False,
}


#: The same, for functions that are always inlined into a kernel.
INLINE_OPTIONS: Any = {**_OPTIONS, "forceinline": True}


def kernel(function: Callable) -> Callable:
    """Compile a function on first call, with pgimp's options, and cache it on disk."""
    compiled = numba.njit(**_OPTIONS)(function)
    compiled._cache = KernelCache(function)  # instead of Numba's own, as by cache=True
    return compiled


def specialise(stub: Callable) -> Callable[[Callable], Callable]:
    """Choose the implementation of `stub` by the types of its arguments, at compile time.

    The decorated function gets the arguments' Numba types and returns a Python function of the
    same signature. Unlike closures and functions passed as arguments, kernels that call `stub`
    are found again in the disk cache.
    """
    return overload(stub, jit_options=cast(Any, INLINE_OPTIONS), strict=False)


def exact(stub: Callable) -> Callable[[Callable], Callable]:
    """As `specialise`, without contraction: the same bits wherever the function is inlined.

    Whether LLVM contracts a product and a sum depends on what else uses the product, so that the
    same expression may round differently in two kernels.
    """
    options: Any = {**INLINE_OPTIONS, "fastmath": False}
    return overload(stub, jit_options=options, strict=False)


#: What reading a damaged cache, or one that is being discarded, may raise.
_DAMAGE = (
    EOFError, pickle.UnpicklingError, AttributeError, ImportError, ValueError, KeyError,
    FileNotFoundError,
)  # fmt: skip
_ATTEMPTS = 3


def discard_damaged(call: Callable[[], Any]) -> Any:
    """Run a first call of kernels; when cached files turn out damaged, discard them and compile.

    A job that is killed, or a disk that fills up, while Numba writes leaves such files behind.
    Another node that shares the folder may discard it at the same moment.
    """
    for _ in range(_ATTEMPTS):
        try:
            return call()
        except _DAMAGE:
            shutil.rmtree(_FOLDER, ignore_errors=True)
            _FOLDER.mkdir(parents=True, exist_ok=True)
    return call()
