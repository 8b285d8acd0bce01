"""What particles add to sums at the vertices."""

from typing import Any, Protocol


class Quantity(Protocol):
    """Quantity that is summed: a NamedTuple of its parameters, with two functions for kernels.

    Mass, momentum and forces are another: `pgimp.kernels.loads.loads.Loads`.
    """

    @staticmethod
    def supports(quantity, shape, frame, window, particles, rows, layer, buffer) -> None:
        """Store the supports of four particles, see `pgimp.kernels.transfer.supports`."""

    @staticmethod
    def share(quantity, shape, frame, particles, p) -> Any:
        """Contributions of particle `p`, a `pgimp.kernels.transfer.scatter.Share`."""
