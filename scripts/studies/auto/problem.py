"""What a problem with a known answer is, and the methods for which it is measured."""

from collections.abc import Callable
from typing import Any, NamedTuple

#: Methods by name, besides that of the case itself; all with two particles a cell and direction.
METHODS = {
    "former default": {},
    "affine": {"affine": True},
    "affine, mean": {"affine": True, "volumetric": "b-bar"},
    "cpdi, affine": {"shape": "cpdi", "affine": True},
    "finite-gimp, affine": {"shape": "finite-gimp", "affine": True},
    "initial": {"formulation": "total-lagrangian"},
    "initial, mean": {"formulation": "total-lagrangian", "volumetric": "b-bar"},
}


class Problem(NamedTuple):
    """A problem for which every method is measured."""

    case: str  #: Name in cases/, without its method.
    what: str  #: Quantity whose error it is, and what it is compared with.
    changes: dict[str, Any]
    error: Callable[[Any], float]  #: Relative error, from the results of a run.
    methods: tuple[str, ...] = tuple(METHODS)  #: The named ones that may fit.
