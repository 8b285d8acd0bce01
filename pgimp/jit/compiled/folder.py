"""The folder of the compiled kernels: named after their sources, writable by nobody else.

The name is a digest of the sources that Numba compiles and of its settings. Neither is part of
Numba's own key, and editing a function does not invalidate the cached kernels
that call it. Kernels for a user's own materials are in folders within it, see
`pgimp.jit.outside`.
"""

import atexit
import os
import shutil
import stat
import tempfile
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from pgimp.errors import UsageError
from pgimp.jit.compiled.sealed import unsafe

#: Environment variables that must be set before Numba is imported, see `pgimp.jit.kernel`.
SETTINGS = {"NUMBA_LOOP_VECTORIZE": "0", "NUMBA_DISABLE_INTEL_SVML": "1"}

#: Folders and files of all code that Numba compiles, within the package; a test checks it.
COMPILED = ("jit", "geometry", "physics", "kernels")


class Folder(NamedTuple):
    """Folder of the compiled kernels."""

    path: Path  #: The folder.
    why_not: str = ""  #: Why it is not the preferred one; empty if it is.

    @property
    def warning(self) -> str:
        """Message to the user; empty if all is well."""
        if not self.why_not:
            return ""
        return (
            f"{self.why_not}; compiled kernels are kept in a temporary folder instead. "
            "PGIMP_CACHE_DIR names another folder: one that only you can write to, on all nodes"
        )


def _sources_digest() -> str:
    """Digest of the settings and the sources that Numba compiles."""
    digest = sha256(repr(sorted(SETTINGS.items())).encode())
    root = Path(__file__).resolve().parents[2]
    for name in COMPILED:
        for path in sorted((root / name).rglob("*.py")) or [root / name]:
            digest.update(str(path.relative_to(root)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def preferred_folder() -> Path:
    """Folder where the compiled kernels belong.

    Returns
    -------
    Path
        ``$PGIMP_CACHE_DIR``, else ``$XDG_CACHE_HOME/pgimp`` (default ``~/.cache/pgimp``), with a
        sub-folder for this version of the sources; absolute.

    Raises
    ------
    UsageError
        If ``PGIMP_CACHE_DIR`` is set but empty.
    """
    base = os.environ.get("PGIMP_CACHE_DIR")
    if base is None:
        home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
        base = os.path.join(home, "pgimp")
    elif not base.strip():
        raise UsageError(
            "PGIMP_CACHE_DIR, the folder of the compiled kernels, is set but empty: name a folder, "
            "or unset it for ~/.cache/pgimp"
        )
    return Path(base).expanduser().absolute() / f"kernels-{_sources_digest()}"


def cache_folder() -> Folder:
    """Find a folder for the compiled kernels, and make it.

    Returns
    -------
    Folder
        The preferred one; or a temporary one where that cannot be written, or others can write it.
    """
    preferred = preferred_folder()
    why_not = _why_not(preferred)
    if not why_not:
        return Folder(preferred)
    path = _private(Path(tempfile.gettempdir()) / f"pgimp-{os.geteuid()}") / preferred.name
    with suppress(OSError):  # without it kernels are compiled, but not kept
        path.mkdir(mode=0o700, exist_ok=True)
    return Folder(path, why_not)


def _why_not(folder: Path) -> str:
    """Make the folder and its parent, if missing; return why kernels cannot be kept there."""
    base = folder.parent
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        for path in (base, folder):
            path.mkdir(mode=0o700, exist_ok=True)
            if why := unsafe(path.stat(), sticky=path == base):
                return f"{path} cannot be trusted: {why}"
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return f"nothing can be written in {folder} ({error.strerror or error})"


def _private(folder: Path) -> Path:
    """Return the folder if only this user can write it, or a new one that lasts for the process."""
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        about = folder.lstat()
        if stat.S_ISDIR(about.st_mode) and about.st_uid == os.geteuid() and not unsafe(about):
            return folder
    new = Path(tempfile.mkdtemp(prefix="pgimp-"))
    atexit.register(shutil.rmtree, new, ignore_errors=True)
    return new
