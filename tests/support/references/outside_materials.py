"""Materials and functions from outside the package, for as long as a test needs them."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pgimp
from pgimp.physics.functions.registry import FUNCTIONS
from pgimp.physics.materials import MATERIALS, registry

SOFTENING = Path(pgimp.__file__).parent / "cases/softening.py"


@contextmanager
def registered(*paths):
    """Import files that register materials or functions; what they did is forgotten at the end."""
    materials, modules, imported = dict(MATERIALS), {*sys.modules}, [*registry.imported]
    functions = dict(FUNCTIONS)
    for path in paths:
        registry.import_file(str(path))
    try:
        yield [sys.modules[path.stem] for path in paths]
    finally:
        _forget(materials, modules, imported)
        FUNCTIONS.clear()
        FUNCTIONS.update(functions)


def _forget(materials, modules, imported):
    for name, module in [*sys.modules.items()]:
        file = getattr(module, "__file__", None)
        if name not in modules and file and Path(file) in map(Path, registry.imported):
            del sys.modules[name]
    MATERIALS.clear()
    MATERIALS.update(materials)
    registry.imported[:] = imported
