"""Geometry that lies in files: read by rank 0, known to all ranks while particles are made."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pgimp.case.check_bodies import check_bounds
from pgimp.case.messages import dotted
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.output.collective import on_root
from pgimp.parallel.node import one_rank_first
from pgimp.scene.meshtree import nothing, plant
from pgimp.scene.regions import Mesh


def _meshes(case: Case) -> Iterator[tuple[str, Mesh]]:
    """Meshes of a case, with the key of their region."""
    for section in ("bodies", "constraints"):
        for name, entry in getattr(case, section).items():
            for region in entry.region.simple():
                if isinstance(region, Mesh):
                    yield f"{section}.{name}.region", region


def share(case: Case, comm: Any) -> None:
    """Read the files of a case on rank 0, and let all ranks have them; collective.

    Raises
    ------
    CaseError
        The same on every rank: a file that cannot be used, or what lies beyond the domain.
    """
    from pgimp.kernels.jit import discard_damaged

    known: dict[Mesh, Any] = {}
    for key, mesh in _meshes(case):

        def read(key: str = key, mesh: Mesh = mesh) -> Any:
            try:
                return discard_damaged(lambda: mesh.surface)
            except CaseError as error:
                raise CaseError(f"{key}: {error}") from None

        if mesh not in known:
            known[mesh] = on_root(comm, read)
        mesh.__dict__["surface"] = known[mesh]
    if not known:
        return
    with one_rank_first(comm):
        discard_damaged(_warm_up)
    problems = [
        f"{dotted(problem.path)}: {problem.text}"
        for name, body in case.bodies.items()
        if any(region.FROM_FILE for region in body.region.simple())
        for problem in check_bounds(
            ("bodies", name, "region"), body.region, case.dimensions, case.grid
        )
    ]
    if problems:
        raise CaseError("\n".join(problems))


def _warm_up() -> None:
    """Compile what all ranks will ask of a mesh."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    surface = plant(corners[faces], np.zeros(4, np.int64), 3)
    point = np.full((1, 3), 0.1)
    surface.distance(point)
    surface.crossings(point, 0)
    surface.fill([np.array([0.0, 1.0])] * 3, [(0, 1)] * 3)


def do_without(case: Case) -> None:
    """Take the bodies in files for empty, where their particles exist already."""
    for _, mesh in _meshes(case):
        mesh.__dict__["surface"] = nothing(case.dimensions)


def release(case: Case) -> None:
    """Let go of what was read; it will be read anew when it is needed."""
    for _, mesh in _meshes(case):
        mesh.__dict__.pop("surface", None)
