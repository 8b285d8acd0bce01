"""An exact solution of one's own: the entry in the case."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import Field

from pgimp.physics.exact.base import Solution
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import EXACT_SOLUTION, Kind
from pgimp.schema.base import Positive
from pgimp.schema.problems import Problem


class OwnSolution(FunctionEntry, Solution):
    """Displacement, velocity and stress by a function of one's own."""

    KIND: ClassVar[Kind] = EXACT_SOLUTION
    moves: ClassVar[bool] = True

    reference: Positive = Field(
        default=1.0, description="stress to which the column `error` refers [stress]"
    )

    def problems(self, case: Any) -> Iterator[Problem]:
        """See `Solution`; what the case has besides is up to its author."""
        for found in self.misfits(case.dimensions):
            yield found._replace(path=("exact", *found.path))

    def mismatches(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        """See `Solution`."""
        yield from ()

    def parameters(self, case: Any) -> Any:
        """Parameters of the kernels."""
        return self.source(float(self.reference))
