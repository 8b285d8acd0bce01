"""Types from outside the package: storage of the kernels compiled for them.

A material registered by a user's program is a NamedTuple whose functions are compiled into the
kernels. The name of the cache folder stands for pgimp's sources alone, and Numba's key for the
type's name. An edited material, or another one of its name, would silently act as before. So
kernels for such types go into a folder of their own, named after all compiled content. It has the
types' functions, the functions called, the values read, and the files of all this. Types that
another process could not find again, as in a notebook's cells, are compiled but not kept.
"""

import hashlib
import pickle
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np
from numba.core import types

#: Packages whose content changes only with their versions, which Numba and the folder's name have.
_KNOWN = {*sys.stdlib_module_names, "llvmlite", "numba", "numpy", "pgimp"} - {"__main__"}

#: An object of Numba: a type, as of a kernel's argument, or a part of its compiler. Numba declares
#: no types of its own: by its classes, a tuple's type has neither a length nor items.
NumbaObject = Any


def part_of(kinds: Iterable[NumbaObject]) -> str | None:
    """Name the sub-folder for kernels compiled for Numba's types `kinds`.

    Returns
    -------
    str or None
        Empty for the package's own types; None if another process would not find the types again.
    """
    classes = sorted(outsiders(kinds), key=_name)
    digests = [_digest_once(one) for one in classes]
    if not all(digests):
        return None
    text = " ".join(digests).encode()
    return f"outside-{hashlib.sha256(text).hexdigest()[:16]}" if digests else ""


def outsiders(kinds: NumbaObject) -> set[type]:
    """Return the NamedTuples from outside the package in Numba's types, at any depth."""
    found: set[type] = set()
    for kind in kinds:
        entry = getattr(kind, "instance_class", None)
        if isinstance(kind, types.BaseNamedTuple) and isinstance(entry, type) and is_outside(entry):
            found.add(entry)
        if isinstance(kind, types.BaseTuple):
            found |= outsiders(kind)
    return found


def is_outside(entry: type) -> bool:
    """Whether a class is not part of pgimp."""
    return entry.__module__.partition(".")[0] != "pgimp"


def _name(entry: type) -> str:
    return f"{entry.__module__}.{entry.__qualname__}"


_digests: dict[type, str] = {}


def _digest_once(entry: type) -> str:
    if entry not in _digests:
        _digests[entry] = digest(entry)
    return _digests[entry]


_tagged: set[type] = set()


def tag(entry: type) -> None:
    """Rename a class from outside uniquely.

    When Numba dispatches a call it distinguishes the classes of NamedTuples by their names. Of two
    with one name, as from a notebook's cell run twice, it takes the first. The class is pickled,
    and found again, by its qualified name, which does not change.
    """
    if entry not in _tagged:
        _tagged.add(entry)
        entry.__name__ += f"_{_digest_once(entry)[:16] or len(_tagged)}"


def digests(parameters: Iterable[NamedTuple]) -> dict[str, str]:
    """Return the digests of the types from outside, by name; empty where unknown.

    Parameters
    ----------
    parameters : iterable of NamedTuple
        For example of all materials of a scene.
    """
    kinds = {type(one) for one in parameters if is_outside(type(one))}
    return {_name(kind): _digest_once(kind)[:16] for kind in sorted(kinds, key=_name)}


def unchanged(before: Mapping[str, str]) -> bool:
    """Return whether the types of `digests` are unchanged in this process."""
    for name, known in before.items():
        kind = _found(name)
        if not known or not isinstance(kind, type) or _digest_once(kind)[:16] != known:
            return False
    return True


def _found(name: str) -> object:
    """Return what has a qualified name in this process, None if there is no such thing."""
    parts = name.split(".")
    for cut in range(len(parts) - 1, 0, -1):
        found: object = sys.modules.get(".".join(parts[:cut]))
        if found is not None:
            for part in parts[cut:]:
                found = getattr(found, part, None)
            return found
    return None


def digest(entry: type) -> str:
    """Digest of all compiled content of a class's functions.

    Parameters
    ----------
    entry : type
        A NamedTuple of parameters.

    Returns
    -------
    str
        Empty if another process would not find the class again, or if values that it reads cannot
        be compared.
    """
    found: object = sys.modules.get(entry.__module__)
    for part in entry.__qualname__.split("."):
        found = getattr(found, part, None)
    if found is not entry or entry.__module__ == "__main__":
        return ""
    hasher = _Hasher()
    hasher.take(_name(entry))
    try:
        hasher.take(entry)
    except (pickle.PicklingError, TypeError, AttributeError, OSError):
        return ""
    return hasher.hash.hexdigest()


class _Hasher:
    """Digests objects and their references, each once, in a fixed order."""

    def __init__(self) -> None:
        self.hash = hashlib.sha256()
        self._seen: dict[int, object] = {}  # which keeps them: an id may be used again
        self._files: set[str] = set()

    def take(self, value: object, names: tuple[str, ...] = ()) -> None:
        """Digest a value; of a module, the attributes `names`."""
        function = getattr(value, "py_func", value)  # the function that Numba compiles
        if isinstance(value, ModuleType):
            self._module(value, names)
        elif isinstance(value, None | bool | int | float | complex | str | bytes):
            self._note(repr(value))
        elif isinstance(value, np.ndarray):
            self._note(f"{value.dtype.str}{value.shape}")
            self.hash.update(value.tobytes())
        elif isinstance(value, tuple | list):
            self._note(f"{type(value).__name__}{len(value)}")
            for item in value:
                self.take(item)
        elif id(value) in self._seen or _known(function):
            self._note(getattr(function, "__qualname__", ""))
        elif isinstance(function, FunctionType):
            self._seen[id(value)] = value
            self._function(function)
        elif isinstance(value, type):
            self._seen[id(value)] = value
            self._class(value)
        else:
            self.hash.update(pickle.dumps(value, 4))

    def _note(self, text: str) -> None:
        self.hash.update(f"{text}\0".encode())

    def _module(self, module: ModuleType, names: tuple[str, ...]) -> None:
        self._note(module.__name__)
        if _known(module):
            return
        self._file(module.__name__)
        for name in names:
            if hasattr(module, name):
                self._note(name)
                self.take(getattr(module, name), names)

    def _class(self, entry: type) -> None:
        self._file(entry.__module__)
        for base in entry.__mro__:
            if not _known(base):
                for name, value in vars(base).items():
                    if not name.startswith("_"):
                        self._note(name)
                        self._member(getattr(value, "__func__", value))

    def _member(self, value: object) -> None:
        """Digest an attribute of a class, except descriptions of fields."""
        if isinstance(value, FunctionType | type | tuple | bool) or hasattr(value, "py_func"):
            self.take(value)

    def _function(self, function: FunctionType) -> None:
        self._file(function.__module__)
        self._note(function.__qualname__)
        self.take(function.__defaults__)
        for cell in function.__closure__ or ():
            self.take(cell.cell_contents)
        for code in _codes(function.__code__):
            self.hash.update(code.co_code)
            self._note(repr((code.co_names, code.co_varnames, code.co_freevars)))
            self._note(repr([_constant(one) for one in code.co_consts]))
            for name in code.co_names:
                if name in function.__globals__:
                    self._note(name)
                    self.take(function.__globals__[name], code.co_names)

    def _file(self, module: str) -> None:
        """Digest a module's file, once: for content that Numba finds by itself, as overloads."""
        path = getattr(sys.modules.get(module), "__file__", None)
        if path and path not in self._files:
            self._files.add(path)
            self.hash.update(Path(path).read_bytes())


def _known(value: object) -> bool:
    name = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
    return (name or "").partition(".")[0] in _KNOWN


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Go through a function's code and the code of its inner functions."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _constant(value: object) -> str:
    """Write a constant identically in every process."""
    if isinstance(value, CodeType):
        return value.co_name
    return repr(sorted(map(repr, value))) if isinstance(value, frozenset) else repr(value)
