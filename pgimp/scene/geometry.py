"""Geometry in files: read by rank 0, shared with all ranks while particles are created."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from math import inf
from typing import Any

import numpy as np

from pgimp.case.checks.periodic import periodic_axes
from pgimp.case.checks.places.probes import check_near
from pgimp.case.checks.regions import check_bounds
from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.mesh.tree import build_tree, nothing
from pgimp.geometry.points.block import States
from pgimp.geometry.points.saved import Wanted
from pgimp.geometry.regions import Points
from pgimp.geometry.regions.base import Region
from pgimp.geometry.regions.enclosed import Enclosed
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import Particles, continued_columns
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.limits import limits
from pgimp.mpi.node import one_rank_first
from pgimp.physics.variation import Places, TableVariation
from pgimp.physics.variation.own import OwnVariation
from pgimp.scene.mass_scaling import is_scaled
from pgimp.scene.materials import LARGEST, SMALLEST
from pgimp.scene.variations import tables
from pgimp.schema.messages import dotted

#: Size ratio of body and grid that suggests another unit, and the ratio of the units.
_FAR_TOO_LARGE, _MILLI = 50.0, 0.001


def _meshes(case: Case, only: Collection[str] | None = None) -> Iterator[tuple[str, Enclosed]]:
    """Meshes of a case, with the key of their region; of all bodies, or of some."""
    for section in ("bodies", "constraints"):
        for name, entry in getattr(case, section).items():
            if only is not None and getattr(entry, "body", name) not in only:
                continue
            for region in entry.region.simple():
                if isinstance(region, Enclosed):
                    yield f"{section}.{name}.region", region


def share(case: Case, comm: Communicator, only: Collection[str] | None = None) -> None:
    """Read the files of a case on rank 0, and share them with all ranks; collective.

    `only` takes the meshes of some bodies, and of what is theirs; the rest has been read before.

    Raises
    ------
    CaseError
        The same on every rank: an unusable file, or a body beyond the domain.
    """
    with located(case):
        _share(case, comm, only)


def _share(case: Case, comm: Communicator, only: Collection[str] | None) -> None:
    if only is None:
        release(case)
    known: dict[Region, object] = {}
    for key, mesh in _meshes(case, only):
        mesh.__dict__.pop("surface", None)

        def read(key: str = key, mesh: Enclosed = mesh) -> object:
            try:
                return mesh.surface
            except CaseError as error:
                raise CaseError(f"{key}: {error}") from None

        if mesh not in known:
            known[mesh] = on_root(comm, read)
        mesh.__dict__["surface"] = known[mesh]
    for entry in case.rigid_bodies.values() if only is None else ():
        for region in entry.region.simple():
            if region in known:  # as terrain, and what lies on it
                region.__dict__["surface"] = known[region]
    if known:
        with one_rank_first(comm):
            _warm_up()
    if only is not None:
        return
    _read_points(case, comm)
    _learn_functions(case)
    _read_tables(case, comm)
    if problems := on_root(comm, lambda: _beyond(case) or _away(case)):
        raise CaseError("\n".join(problems))


def _from_files(case: Case) -> dict[str, Region]:
    """Regions from files, by the bodies' names."""
    return {
        name: body.region
        for name, body in case.bodies.items()
        if any(region.FROM_FILE for region in body.region.simple())
    }


def _beyond(case: Case) -> list[str]:
    """Problems of bodies from files that exceed the domain, with another unit as explanation."""
    messages = []
    for name, region in _from_files(case).items():
        path = ("bodies", name, "region")
        problems = list(check_bounds(path, region, case.grid))
        messages += [f"{dotted(problem.path)}: {problem.text}" for problem in problems]
        hints = dict.fromkeys(_unit(case, part) for part in region.simple()) if problems else {}
        messages += [f"{dotted(path)}: {hint}" for hint in hints if hint]
    return messages


def _unit(case: Case, region: Region) -> str:
    """Describe the unit in which a far too large region would fit; empty if it would not."""
    if not isinstance(region, Enclosed | Points):
        return ""
    low, high = (np.array(end) for end in region.bounds())
    origin, corner = (np.array(end, float) for end in (case.grid.origin, case.grid.corner))
    if not ((high - low) > _FAR_TOO_LARGE * (corner - origin)).any():
        return ""
    about = np.zeros(case.dimensions)  # centre of the scaling
    if isinstance(region, Enclosed) and region.translate is not None:
        about += region.translate
    low, high = about + _MILLI * (low - about), about + _MILLI * (high - about)
    if not ((low >= origin) & (high <= corner)).all():
        return ""
    ask = f"are lengths in {region.file} in a smaller unit than the grid's, as mm for m?"
    if isinstance(region, Enclosed):
        return f"{ask} scale: {_MILLI * region.scale:g} would make it fit"
    return (
        f"{ask} Times {_MILLI:g}, and volumes times {_MILLI**case.dimensions:g}, its particles "
        "would fit"
    )


def _away(case: Case) -> list[str]:
    """Problems of probes outside their bodies."""
    messages, regions = [], _from_files(case)
    for name, probe in case.probes.items():
        region = regions.get(getattr(probe, "body", None) or "")
        if region is not None:
            path = ("probes", name, "at")
            messages += [
                f"{dotted(problem.path)}: {problem.text}"
                for problem in check_near(path, probe, region, case.grid)
            ]
    return messages


def _warm_up() -> None:
    """Compile the kernels for meshes of all ranks."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    surface = build_tree(corners[faces], np.zeros(4, np.int64), 3)
    point = np.full((1, 3), 0.1)
    surface.distance(point)
    surface.crossings(point, 0)
    surface.fill([np.array([0.0, 1.0])] * 3, [(0, 1)] * 3)


def _read_points(case: Case, comm: Communicator) -> None:
    """Check the files of particles on rank 0, and share their extents with all ranks."""
    if not any(isinstance(body.region, Points) for body in case.bodies.values()):
        return
    capacity = _most_particles(case, comm)
    for name, body in case.bodies.items():
        points = body.region
        if not isinstance(points, Points):
            continue
        material = case.materials[body.material]
        states = {state.name: state.tensor for state in material.states}
        columns = [
            (column, ".".join(path), part)
            for path, variation in material.variations.items()
            for part in variation.parts()
            for column in part.columns
        ]
        points.expect(
            dict.fromkeys((column for column, _, _ in columns), False) | states,
            _wanted(case, name, points.body, states),
        )

        def read(
            name: str = name,
            points: Points = points,
            material: Any = material,
            columns: Any = columns,
        ) -> Any:
            try:
                found = points.read(capacity)
            except CaseError as error:
                raise CaseError(f"bodies.{name}.region: {error}") from None
            for column, key, _ in columns:
                if found.saved:
                    raise CaseError(
                        f"bodies.{name}.region: parameters from columns, as materials."
                        f"{case.bodies[name].material}.{key}, are in files of your own, and "
                        f"{points.file} is of a run: take another variation"
                    )
                if column not in found.states:
                    raise CaseError(
                        f"bodies.{name}.region: the particles {points.file} have no column "
                        f"'{column}', from which materials.{case.bodies[name].material}.{key} is "
                        "to be taken"
                    )
            stress = found.stress and not found.saved  # of a run it goes with the rest
            if stress and not material.CARRIES_STRESS:
                raise CaseError(
                    f"bodies.{name}.region: the particles {points.file} have a stress, but the "
                    f"stress of '{material.model}' follows from the deformation alone; leave it "
                    "out, or use hooke"
                )
            if stress and not material.CARRIES_PRESSURE and (first := points.mean_stress()):
                particle, mean = first
                raise CaseError(
                    f"bodies.{name}.region: {particle}, has a mean stress of {mean:.3g}, but the "
                    f"pressure of '{material.model}' follows from the volume, which is that of the "
                    "start: it would be gone in the first step; give deviators, stresses less "
                    "their mean"
                )
            tension = stress and not material.BEARS_TENSION
            if tension and (first := points.mean_stress(tension=True)):
                particle, mean = first
                raise CaseError(
                    f"bodies.{name}.region: {particle}, has a mean stress of {mean:.3g}, tension, "
                    f"of which '{material.model}' bears none: it would be gone in the first step; "
                    "compression is negative"
                )
            for state in material.states:
                if state.least == -inf or state.name not in found.states:
                    continue
                if first := points.below(state.name, state.least):
                    particle, value = first
                    raise CaseError(
                        f"bodies.{name}.region: {particle}, has a {state.name} of {value:.6g}, but "
                        f"that of '{material.model}' is {state.least:g} or more: {state.meaning}"
                    )
            least, most = found.least * material.density, found.volume * material.density
            if not (least > SMALLEST and most < LARGEST):
                raise CaseError(
                    f"bodies.{name}.region: the particles {points.file} have masses of {least:.3g} "
                    f"and {most:.3g} in all: nothing can be computed; choose other units"
                )
            return found

        points.__dict__["summary"] = found = on_root(comm, read)
        means = dict(zip(found.states, found.means, strict=True))
        for column, _, part in columns:
            part.learn(means[column])


def _wanted(case: Case, name: str, named: str | None, states: States) -> Wanted:
    """What a body needs of a frame or a checkpoint of a run."""
    body, inertia = case.bodies[name], case.time.mass_scaling
    law, axes = case.materials[body.material], periodic_axes(case.boundaries)
    density = None if law.variations else law.density / (inertia if is_scaled(case) else 1.0)
    periods = tuple(
        (case.grid.origin[d], case.grid.size[d] if d in axes else 0.0)
        for d in range(case.dimensions)
    )
    return Wanted(
        name, named, str(getattr(law, "model", "")), states, case.geometry,
        body.formulation == "total-lagrangian", density, inertia, periods, case.method.affine,
        continued_columns(),
    )  # fmt: skip


def _learn_functions(case: Case) -> None:
    """Take typical values of parameters by functions of one's own, at the middles of bodies."""
    for name, material in case.materials.items():
        regions = [body.region for body in case.bodies.values() if body.material == name]
        for variation in material.variations.values():
            for part in variation.parts():
                if isinstance(part, OwnVariation) and regions:
                    ends = np.array([region.bounds() for region in regions], float)
                    values = part.own_values(Places(ends.mean(axis=1), {}))
                    part.learn(float(values.mean()))


def _read_tables(case: Case, comm: Communicator) -> None:
    """Read the tables over a coordinate in files on rank 0, and share them with all ranks."""
    for key, table in tables(case):

        def read(key: str = key, table: TableVariation = table) -> object:
            try:
                return table.read()
            except CaseError as error:
                raise CaseError(f"{key}: {error}") from None

        table.__dict__["rows"] = on_root(comm, read)


def _most_particles(case: Case, comm: Communicator) -> int | None:
    """Number of particles that would fill the memory of all ranks; collective."""
    row = Particles.empty(1, Carried(case.dimensions))
    mine = min(limits(), key=lambda limit: limit.free, default=None)
    # Ranks of one node share its memory.
    pools: dict[str, int] = {}
    for limit in comm.allgather(mine):
        if limit is None:
            return None
        pools[limit.shared_by] = min(limit.free, pools.get(limit.shared_by, limit.free))
    return int(sum(pools.values())) // sum(column.nbytes for column in row)


def take_as_empty(case: Case, comm: Communicator) -> None:
    """Treat bodies from files as empty, if their particles exist already."""
    for _, mesh in _meshes(case):
        mesh.__dict__["surface"] = nothing(case.dimensions)
    for body in case.bodies.values():
        if isinstance(body.region, Points):
            body.region.__dict__["summary"] = body.region.nothing()


def release(case: Case) -> None:
    """Free the data from files; they are read again when needed."""
    for _, mesh in _meshes(case):
        mesh.__dict__.pop("surface", None)
    for body in case.bodies.values():
        if isinstance(body.region, Points):
            body.region.__dict__.pop("summary", None)
    for material in case.materials.values():
        for variation in material.variations.values():
            for part in variation.parts():
                part.release()
