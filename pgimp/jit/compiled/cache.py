"""The disk cache of compiled kernels, in place of Numba's: a sealed file for each of them.

Numba's own cache keeps an index of all types that a function was compiled for. Two processes that
compile at once overwrite it for each other, and any file found is loaded. Here each kernel has its
own file, named after its key and read only if its checksum holds (see
`pgimp.jit.compiled.sealed`). A file that does not fit in any way is compiled again and replaced.
"""

import io
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from hashlib import sha256
from inspect import getfile
from pathlib import Path

import numba
from numba.core.caching import NullCache
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from pgimp.jit.compiled import sealed
from pgimp.jit.compiled.stored import rebuilt, reduced
from pgimp.jit.outside import NumbaObject, part_of

#: Reasons why files could not be used, and why none could be written in folders, by their paths.
Problems = tuple[dict[str, str], dict[str, str]]

#: Makes an object from what the disk has of it.
Rebuild = Callable[[NumbaObject], NumbaObject]

_damaged: dict[str, str] = {}
_failures: dict[str, str] = {}
_listeners: list[Callable[[], None]] = []


class Store:
    """Objects stored in a folder, each in its own file.

    Parameters
    ----------
    folder : Path
        Made when the first file is written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def _path(self, name: str, key: object) -> Path:
        """Path of an object; the file's content distinguishes keys with equal names."""
        return self.folder / f"{name}-{sha256(repr(key).encode()).hexdigest()[:24]}.nbc"

    def load(self, name: str, key: object, rebuild: Rebuild = lambda kept: kept) -> NumbaObject:
        """Return the stored object, or None; unusable files are noted for `messages`.

        Parameters
        ----------
        name : str
            Beginning of the file's name.
        key : object
            The key under which it was saved.
        rebuild : callable
            Makes the object from the stored data.
        """
        path = self._path(name, key)
        try:
            file = io.BytesIO(sealed.read(path))
            return rebuild(pickle.load(file)) if pickle.load(file) == key else None
        except FileNotFoundError:
            return None
        except sealed.UntrustedError as error:
            _damaged[str(path)] = str(error)
        except Exception as error:  # whole but unusable; it is compiled again
            _damaged[str(path)] = f"{type(error).__name__}: {error}"
        return None

    def save(self, name: str, key: object, value: object) -> None:
        """Store an object; failures are noted for `messages`."""
        try:
            sealed.write(self._path(name, key), dumps(key) + dumps(value))
        except OSError as error:
            _failures[str(self.folder)] = error.strerror or str(error)


class KernelCache(NullCache):
    """The cache of one kernel.

    Parameters
    ----------
    function : function
        The kernel's Python function.
    folder : Path
        The kernels' folder.
    """

    def __init__(self, function: Callable, folder: Path) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        self._folder = folder
        self._function = function

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def load_overload(self, sig: NumbaObject, target_context: NumbaObject) -> NumbaObject:
        """Return the code compiled for a signature, or None; it will then be compiled."""
        rtsys.initialize(target_context)  # for the kernels' calls; the rest of Numba only compiles
        found = None
        if store := self._store(sig):
            key = self._key(sig, target_context.codegen())
            found = store.load(self._name, key, partial(rebuilt, target_context))
        if found is None:
            for tell in tuple(_listeners):
                tell()
        return found

    def save_overload(self, sig: NumbaObject, cres: NumbaObject) -> None:
        """Store the code compiled for a signature, if another process could use it."""
        if cres.library.has_dynamic_globals or not all(one.can_cache for one in cres.lifted):
            return
        if store := self._store(sig):
            store.save(self._name, self._key(sig, cres.codegen), reduced(cres))

    def _store(self, sig: NumbaObject) -> Store | None:
        """Storage of kernels for these types, if they can be stored."""
        part = part_of(sig.args if hasattr(sig, "args") else sig)
        return None if part is None or not _source(self._function) else Store(self._folder / part)

    def _key(self, sig: NumbaObject, codegen: NumbaObject) -> tuple[object, ...]:
        version = (numba.__version__, sys.implementation.cache_tag)
        return sig, self._name, codegen.magic_tuple(), version, _source(self._function)


@cache
def _source(function: Callable) -> str:
    """Return the source of a function; empty if it is in no file, or made in another function."""
    if function.__module__.partition(".")[0] == "pgimp":
        return "pgimp"  # represented by the name of the folder
    code = function.__code__
    if function.__closure__:
        return ""
    try:
        path, places = Path(getfile(function)), [*code.co_positions()]  # it may have namesakes
        return f"{path} {sha256(path.read_bytes() + repr(places).encode()).hexdigest()}"
    except (OSError, TypeError):
        return ""


@contextmanager
def announced(tell: Callable[[str], object]) -> Iterator[None]:
    """Notify the user, once and with `tell`, before the first kernel that is compiled."""

    def once() -> None:
        _listeners.remove(once)
        tell("compiling for this kind of scene, once; this takes ten seconds to a minute")

    _listeners.append(once)
    try:
        yield
    finally:
        if once in _listeners:
            _listeners.remove(once)


def problems() -> Problems:
    """Return files that could not be used or written since the last call: path, why."""
    found = dict(_damaged), dict(_failures)
    _damaged.clear()
    _failures.clear()
    return found


def messages(found: Iterable[Problems] | None = None) -> list[str]:
    """Return messages about the cache, a line each.

    Parameters
    ----------
    found : iterable of (dict, dict), optional
        From `problems`, of several processes; of this one by default.
    """
    damaged: dict[str, str] = {}
    failures: dict[str, str] = {}
    for unused, unkept in [problems()] if found is None else found:
        damaged |= unused
        failures |= unkept
    lines = []
    if damaged:
        path, why = next(iter(damaged.items()))
        more = f", and {len(damaged) - 1} more" if len(damaged) > 1 else ""
        lines.append(f"compiled kernels were not used but compiled again: {path}{more}: {why}")
    return lines + [
        f"compiled kernels could not be kept in {path}: {why}" for path, why in failures.items()
    ]
