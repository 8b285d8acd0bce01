"""What surfaces that cut cells leave of a scene's vertices."""

from __future__ import annotations

from pgimp.case.checks.exact_surfaces import exact_surfaces, fallback
from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

#: Particles up to which a case is set up to look at its vertices.
_MOST = 2_000_000


def vertex_notes(case: Case, particles: int) -> list[str]:
    """Notes of vertices that hold little and move by themselves, as a run has them.

    Where cut cells cannot be exact, of that.

    Raises
    ------
    CaseError
        If steps are too long for vertices near a surface.
    """
    if note := fallback(case):
        return [note]
    if particles > _MOST or not any(exact_surfaces(case)):
        return []
    return Simulation(case, Serial()).rank.slaves.notes()
