"""What a problem with a known answer is, and the methods for which it is measured."""

from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

#: Shapes that are tried in either configuration.
_SHAPES = {
    "updated-lagrangian": ("gimp", "finite-gimp", "cpdi", "bspline-quadratic"),
    "total-lagrangian": ("gimp", "bspline-quadratic"),
}


def _methods() -> dict[str, dict[str, Any]]:
    """Return 32 methods in the current configuration and 16 in the initial one, by name."""
    found = {}
    for configuration, shapes in _SHAPES.items():
        initial = configuration == "total-lagrangian"
        word, key, value = (
            ("averaged", "mass", "averaged") if initial else ("affine",) * 2 + (True,)
        )
        for shape, count, mean, more in product(shapes, (2, 3), (False, True), (False, True)):
            words = ["initial"] * initial + [shape] * (shape != "gimp" or not initial)
            words += [word] * more + ["mean"] * mean + ["3 a cell"] * (count == 3)
            keys = {"formulation": configuration, "shape": shape, "particles-per-cell": count}
            keys |= {key: value} if more else {}
            found[", ".join(words)] = keys | ({"volumetric": "b-bar"} if mean else {})
    return found


#: Keys by name of the 48 methods, with two particles a cell and direction unless the name says 3.
METHODS = _methods()
#: The method that was the default before there were choices.
FORMER = "gimp"


class Problem(NamedTuple):
    """A problem for which every method is measured."""

    case: str  #: Name in cases/, without its method.
    what: str  #: Quantity whose error it is, and what it is compared with.
    changes: dict[str, Any]
    error: Callable[[Any], float]  #: Relative error, from the results of a run.
    #: The named methods that may fit; problems that take some seconds try all.
    methods: tuple[str, ...] = tuple(METHODS)
    #: Relative error of a run that stops, by its message; without it there is none.
    stopped: Callable[[str], float] | None = None
