"""Materials from outside the package, for as long as a test needs them."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pgimp
from pgimp.physics.materials import MATERIALS, registry

SOFTENING = Path(pgimp.__file__).parent / "cases/softening.py"


@contextmanager
def registered(*paths):
    """Import files that register materials; all that was registered meanwhile is forgotten."""
    materials, modules, imported = dict(MATERIALS), {*sys.modules}, [*registry.imported]
    for path in paths:
        registry.import_file(str(path))
    try:
        yield [sys.modules[path.stem] for path in paths]
    finally:
        _forget(materials, modules, imported)


def _forget(materials, modules, imported):
    for name, module in [*sys.modules.items()]:
        file = getattr(module, "__file__", None)
        if name not in modules and file and Path(file) in map(Path, registry.imported):
            del sys.modules[name]
    MATERIALS.clear()
    MATERIALS.update(materials)
    registry.imported[:] = imported
