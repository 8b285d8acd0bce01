"""A body force of one's own: the entry in the case."""

from __future__ import annotations

from typing import Any, ClassVar

from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import BODY_FORCE, Kind
from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.schema.sizes import Problems


class OwnForce(FunctionEntry, BodyForceEntry):
    """Force per mass by a function of one's own."""

    KIND: ClassVar[Kind] = BODY_FORCE

    @property
    def initial(self) -> bool:
        """Whether it depends on initial positions."""
        return "X" in self.registered.given

    def check(self, dimensions: int) -> Problems:
        """See `BodyForceEntry.check`."""
        yield from self.misfits(dimensions)

    def parameters(self) -> Any:
        """See `BodyForceEntry`."""
        return self.source()
