"""pgimp: the Generalized Interpolation Material Point method, on slabs over MPI.

From Python: ``load`` a case and change it, ``run`` it (under mpirun on all ranks), drive a
``Simulation`` step by step, ``open`` a run directory. Laws of your own come in by
``register_material``, functions by decorators, as ``body_force``. Importing pgimp imports neither
MPI nor Numba nor h5py.
"""

from __future__ import annotations

# As `typing` has it, which is not imported: a run's handlers of signals wait for this file.
TYPE_CHECKING = False

if TYPE_CHECKING:
    from typing import Any

    from pgimp.case.load import load
    from pgimp.commands.run import run
    from pgimp.errors import CaseError, PgimpError, RunError, UsageError
    from pgimp.mpi.peers import world
    from pgimp.physics.functions.decorators import (
        body_force,
        coefficient,
        exact_solution,
        stress,
        velocity,
    )
    from pgimp.physics.materials.parameters.outside import takes_vectors
    from pgimp.physics.materials.registry import register_material
    from pgimp.solver.callbacks.callback import Each
    from pgimp.solver.driver import Simulation
    from pgimp.utilities.element.march import element
    from pgimp.utilities.opened import open

__all__ = [
    "CaseError",
    "Each",
    "PgimpError",
    "RunError",
    "Simulation",
    "UsageError",
    "body_force",
    "coefficient",
    "element",
    "exact_solution",
    "load",
    "open",
    "register_material",
    "run",
    "stress",
    "takes_vectors",
    "velocity",
    "world",
]

_HOMES = {
    "CaseError": "pgimp.errors",
    "Each": "pgimp.solver.callbacks.callback",
    "PgimpError": "pgimp.errors",
    "RunError": "pgimp.errors",
    "Simulation": "pgimp.solver.driver",
    "UsageError": "pgimp.errors",
    "body_force": "pgimp.physics.functions.decorators",
    "coefficient": "pgimp.physics.functions.decorators",
    "element": "pgimp.utilities.element.march",
    "exact_solution": "pgimp.physics.functions.decorators",
    "load": "pgimp.case.load",
    "open": "pgimp.utilities.opened",
    "register_material": "pgimp.physics.materials.registry",
    "run": "pgimp.commands.run",
    "stress": "pgimp.physics.functions.decorators",
    "takes_vectors": "pgimp.physics.materials.parameters.outside",
    "velocity": "pgimp.physics.functions.decorators",
    "world": "pgimp.mpi.peers",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'pgimp' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
