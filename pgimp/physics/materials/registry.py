"""Materials by their name in the case: pgimp's own, and registered ones.

A case is data and never names code. The material behind a name in ``model:`` has to be registered.
A program does that (`register_material`), a file on the command line (``--import``), or an
installed package with an entry point in the group ``pgimp.materials``.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from importlib.metadata import entry_points
from pathlib import Path
from typing import TypeVar, get_args

from pgimp.errors import UsageError
from pgimp.physics.materials.base import Material

M = TypeVar("M", bound=type[Material])

#: Group of entry points for packages' materials, or modules that register them.
GROUP = "pgimp.materials"


class Registry(dict[str, type[Material]]):
    """Materials by name; the first look-up of an unknown name loads installed packages."""

    def __init__(self) -> None:
        super().__init__()
        self._complete = False

    def __contains__(self, name: object) -> bool:
        """Return whether there is a material of this name."""
        if super().__contains__(name):
            return True
        self.complete()
        return super().__contains__(name)

    def complete(self) -> None:
        """Add the materials of installed packages, once."""
        if not self._complete:
            self._complete = True
            self._load_packages()

    def _load_packages(self) -> None:
        for point in entry_points(group=GROUP):
            try:
                found = point.load()
                if isinstance(found, type) and self.get(name_of(found)) is not found:
                    self.add(found)
            except Exception as error:
                package = point.dist.name if point.dist else "a package"
                raise UsageError(
                    f"the material '{point.name}' of {package} ({point.value}) cannot be loaded: "
                    f"{_reason(error)}"
                ) from error

    def add(self, entry: M) -> M:
        """Add a material from outside; see `register_material`."""
        name = name_of(entry)
        known = self.get(name)
        if known is not None and _place(known) != _place(entry):
            raise UsageError(
                f"cannot register {_place(entry)}: there is a material '{name}' already, "
                f"{_place(known)}; give it another name in its `model`"
            )
        if "parameters" not in dir(entry):
            raise UsageError(
                f"cannot register {_place(entry)}: it needs a method parameters(self) that returns "
                "a NamedTuple with a density and the kernels stress, energy and speed"
            )
        self[name] = entry
        return entry


def name_of(entry: object) -> str:
    """Return the name of a material in a case, from its field ``model: Literal["name"]``.

    Raises
    ------
    UsageError
        If it is no material, or has no name.
    """
    if not (isinstance(entry, type) and issubclass(entry, Material)):
        raise UsageError(f"cannot register {entry!r}: it is no class derived from Material")
    field = entry.model_fields.get("model")
    names = get_args(field.annotation) if field is not None else ()
    if len(names) != 1 or not isinstance(names[0], str) or not names[0]:
        raise UsageError(
            f"cannot register {_place(entry)}: its name in a case is missing; add a field\nmodel: "
            'Literal["my-material"]'
        )
    return names[0]


def _place(entry: type) -> str:
    return f"{entry.__module__}.{entry.__qualname__}"


#: The materials by their name in the case, ``materials: {NAME: {model: ...}}``; the package adds
#: pgimp's own.
MATERIALS = Registry()


def register_material(entry: M) -> M:
    """Let cases use a material from outside the package; a decorator.

    Parameters
    ----------
    entry : type
        A class derived from `pgimp.physics.materials.Material`. Its field
        ``model: Literal["my-material"]`` is its name in a case. Its ``parameters()`` gives the
        kernels' view of it, see `pgimp.physics.materials`. Registered again, as by a notebook's
        cell, it replaces itself.

    Returns
    -------
    type
        The class.

    Raises
    ------
    UsageError
        If it is no such class, or if the name is taken.
    """
    return MATERIALS.add(entry)


_FOLDER = (
    "--import {name}: it is a folder; name the Python file in it that registers the material: "
    "--import {name}/FILE.py"
)

#: Imports of `import_file`, as absolute paths or names of modules, in order.
imported: list[str] = []


def import_file(name: str) -> None:
    """Import a Python file, or a module by its name, that registers materials.

    Parameters
    ----------
    name : str
        ``fluid.py``, ``path/fluid.py``, or ``package.module``. A file can import modules beside
        it.

    Raises
    ------
    UsageError
        If there is none, if another module has its name, or for any error in it.
    """
    path = Path(name).resolve() if name.endswith(".py") or "/" in name else None
    try:
        if path is None:
            sys.path.append("")
            spec = importlib.import_module(name).__spec__
            if spec is not None and spec.origin is None:  # an empty package
                raise UsageError(_FOLDER.format(name=name))
        else:
            _import_path(path, name)
    except UsageError:
        raise
    except (Exception, SystemExit) as error:
        where = "" if path is None else _line(error, path)
        raise UsageError(f"--import {name}: {where}{_reason(error)}") from error
    imported.append(name if path is None else str(path))


def _import_path(path: Path, name: str) -> None:
    """Import a file under its own name, which Numba's cache needs to find its classes."""
    if path.is_dir():
        raise UsageError(_FOLDER.format(name=name.rstrip("/")))
    if not path.is_file():
        raise UsageError(f"--import {name}: there is no such file")
    module = path.stem
    if not module.isidentifier():
        raise UsageError(
            f"--import {name}: '{module}' cannot be the name of a module: letters, digits and _"
        )
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # last: no file beside it shall replace another module
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None or Path(spec.origin).resolve() != path:
        raise UsageError(
            f"--import {name}: there is another module of the name {module}; rename the file"
        )
    importlib.import_module(module)


def _reason(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, UsageError) else f"{type(error).__name__}: {text}"


def _line(error: BaseException, path: Path) -> str:
    """Line of the file at which an error was raised, as text."""
    if isinstance(error, SyntaxError):
        return f"line {error.lineno}: "
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == str(path)]
    return f"line {lines[-1]}: " if lines else ""
