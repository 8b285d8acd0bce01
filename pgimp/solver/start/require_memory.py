"""Refusal of a run that the memory of its nodes cannot hold, before it is used."""

from pgimp.errors import CaseError
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.limits import Limit, limits
from pgimp.scene.bodies.extent import extents
from pgimp.scene.scene import Scene
from pgimp.solver.start.memory import Estimate, estimate, size_text

#: Rows of a rank's particles are numbered by int32.
MOST_ROWS = 2**31 - 1


class MemoryShortError(CaseError):
    """A run does not fit into memory; `estimate` is for the first rank."""

    def __init__(self, text: str, estimate: Estimate) -> None:
        super().__init__(text, estimate)
        self.estimate = estimate

    def __str__(self) -> str:
        """Return the message."""
        return str(self.args[0])


def require(scene: Scene, comm: Communicator, count: int | None = None) -> Estimate:
    """Refuse a run that the memory of its nodes cannot hold; collective.

    Returns
    -------
    Estimate
        The estimate of this rank.

    Raises
    ------
    MemoryShortError
        On every rank alike.
    CaseError
        Likewise, if a rank cannot number its particles.
    """
    found = estimate(scene, comm.size, comm.rank == 0, extents(scene.case), count)
    ranks = comm.allgather((found, limits()))
    # Total of the processes that share a limit; several may give it with other figures.
    needs: dict[str, float] = {}
    sharing: dict[str, list[Limit]] = {}
    for one, bounds in ranks:
        for limit in bounds:
            key = f"{limit.shared_by} {limit.name}"
            size = one.size + (one.untouched.size if limit.addresses else 0.0)
            needs[key] = needs.get(key, 0.0) + size
            sharing.setdefault(key, []).append(limit)
    frees = {key: max(1, min(limit.free for limit in some)) for key, some in sharing.items()}
    worst = max(needs, key=lambda key: needs[key] / frees[key], default="")
    if worst and needs[worst] > frees[worst]:
        limit = sharing[worst][0]
        who = f"{len(sharing[worst])} of {comm.size} ranks" if comm.size > 1 else "it"
        first = ranks[0][0]
        parts = [*first.parts, *[first.untouched] * limit.addresses]
        part = max(parts, key=lambda part: part.size)
        raise MemoryShortError(
            f"this case is too large: {who} would take about {size_text(needs[worst])}, where "
            f"{limit.name} leaves {size_text(frees[worst])}\n"
            f"  most of it, {size_text(part.size)} a rank, is for {part.what}\n"
            f"  try: {part.advice}" + (", or more nodes" if part.shared else ""),
            first,
        )
    if count is not None and count / comm.size > MOST_ROWS:
        raise CaseError(
            f"{count:,} particles on {comm.size} ranks: a rank can number {MOST_ROWS:,}; use "
            "more ranks"
        )
    return found
