"""Surface tractions (18): their entries in the case, and the particles that carry them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from pgimp.case.base import Model, Name, Number, Vector
from pgimp.case.dispatch import Either
from pgimp.case.problems import Problem, raise_problems
from pgimp.scene.tables import Table, VectorTable

if TYPE_CHECKING:
    from pgimp.kernels.tractions import Traction


class TractionEntry(Model):
    """A force on a face of a body that fills a box; it follows the particles along the face."""

    body: Name = Field(description="name of the body, whose region is a box")
    face: str = Field(description="face of its box, x-min to z-max")
    traction: Annotated[
        tuple[float, ...] | VectorTable | None,
        Either(
            "one number a direction or {table: [[time, [..]], ...]}",
            {tuple: Vector, dict: VectorTable, None: None},
        ),
    ] = Field(
        default=None,
        description="force per current area: a vector, or a table over time, linear in between "
        "and held at both ends [stress]",
    )
    pressure: Annotated[
        float | Table | None,
        Either(
            "a number or {table: [[time, value], ...]}", {float: Number, dict: Table, None: None}
        ),
    ] = Field(
        default=None,
        description="force per current area against the face's current normal: positive pushes "
        "into the body; a number or a table over time [stress]",
    )

    @model_validator(mode="after")
    def _check_kind(self) -> TractionEntry:
        if (self.traction is None) == (self.pressure is None):
            text = "expected either a traction or a pressure"
            raise_problems("traction", [Problem(("traction",), text)])
        return self

    @property
    def varies(self) -> bool:
        """Whether the parameters change in time."""
        return isinstance(self.traction, VectorTable) or isinstance(self.pressure, Table)

    @property
    def axis(self) -> int:
        """Direction of the face's normal."""
        return "xyz".index(self.face[0])

    @property
    def side(self) -> int:
        """Which end along the axis: -1 or 1."""
        return -1 if self.face.endswith("min") else 1

    def parameters(self, column: int, half: tuple[float, ...], follows: bool, t: float) -> Traction:
        """Parameters of the kernels at time `t`; see `Traction`."""
        from pgimp.kernels.tractions import Traction

        q, b = self.pressure, self.traction
        pressure = 0.0 if q is None else q.value(t) if isinstance(q, Table) else float(q)
        vector = () if b is None else b.value(t) if isinstance(b, VectorTable) else b
        x, y, z = (*(float(c) for c in vector), 0.0, 0.0, 0.0)[:3]
        return Traction(self.axis, self.side, column, half, follows, (x, y, z), pressure)

    def attach(
        self, box: Any, X: np.ndarray, half: np.ndarray, outermost: float, patch: np.ndarray
    ) -> None:
        """Give particles their patches of the face.

        Parameters
        ----------
        box : Box
            Region of the body.
        X : (n, D) float64
            Initial positions of the body's particles.
        half : (D,) float64
            Half the spacing of the particles.
        outermost : float
            Coordinate, along the axis, of the particles that carry patches.
        patch : (n, 2) float64
            Set to area and distance, zeros for the particles that carry none.
        """
        axis = self.axis
        carry = np.abs(X[:, axis] - outermost) < half[axis]
        area = np.ones(len(X))
        for d in range(X.shape[1]):
            if d != axis:
                low = np.maximum(X[:, d] - half[d], box.min[d])
                area *= np.maximum(np.minimum(X[:, d] + half[d], box.max[d]) - low, 0.0)
        face = (box.min if self.side < 0 else box.max)[axis]
        patch[:, 0] = np.where(carry, area, 0.0)
        patch[:, 1] = np.where(carry, face - X[:, axis], 0.0)

    def area(self, box: Any) -> float:
        """Area of the face."""
        sides = [high - low for low, high in zip(box.min, box.max, strict=True)]
        return float(np.prod([s for d, s in enumerate(sides) if d != self.axis]))
