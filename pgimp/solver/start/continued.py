"""Bodies that go on from a checkpoint of another run: its checksums, and its vertices' motion."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pgimp.case.locations import located
from pgimp.errors import CaseError, DamagedError
from pgimp.geometry.points.block import Saved, VertexGrid
from pgimp.geometry.regions import Points
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank import Rank
from pgimp.solver.state.stored_motion import MOTION, MOTION_PLANES, set_motion
from pgimp.solver.state.vertex_motion import velocity_field

#: Difference of two grids' vertices, in cells, that is rounding.
_NEAR = 1e-9

_FIRST = b"pgimp checkpoint"


def verify_checkpoints(scene: Scene, comm: Communicator) -> None:
    """Refuse damaged checkpoints that bodies are to go on from; collective.

    Raises
    ------
    CaseError
        On every rank, if one has changed since it was written.
    """
    regions = [body.region for body in scene.case.bodies.values()]

    def verify() -> None:
        for name in dict.fromkeys(each.file for each in regions if isinstance(each, Points)):
            if not Path(name).is_file():
                continue  # its reader says what is wrong
            with open(name, "rb") as stream:
                if stream.read(len(_FIRST)) != _FIRST:
                    continue
            try:
                CheckpointFile(name).verify(comm.rank, comm.size)
            except DamagedError as error:
                raise CaseError(f"cannot use the particles {name}: {error}") from None

    with located(scene.case):
        all_or_none(comm, verify, CaseError)


def continue_motion(rank: Rank) -> None:
    """Give vertices the motion that they had in the checkpoints of their bodies; collective.

    Raises
    ------
    CaseError
        On every rank, if a vertex would go on for one body and begin for another.
    """
    scene = rank.scene
    found = list(_continued(scene))
    if not any(found):
        return

    def put() -> None:
        fields = [velocity_field(rank.grid, body) for body in range(len(found))]
        for field in dict.fromkeys(fields):
            bodies = [
                b
                for b, other in enumerate(fields)
                if other == field and scene.settings.lagrangian[b]
            ]
            each = [found[b] for b in bodies]
            sources = {one and (one[0], _field(one[1])) for one in each}
            if sources in ({None}, set()):
                continue
            if len(sources) > 1:
                names = ", ".join(f"'{scene.body_names[b]}'" for b in bodies)
                raise CaseError(
                    f"bodies: {names} share vertices in the initial configuration, but do not go "
                    "on from one file, in which they shared them too; give them an entry in "
                    "contact"
                )
            source = found[bodies[0]]
            assert source is not None
            _put(rank, *source, field)

    with located(scene.case):
        all_or_none(rank.comm, put, CaseError)
    if scene.domain.ring is not None:  # planes behind the last layer are the first ones
        rank.share_motion()


def _continued(scene: Scene) -> Iterator[tuple[str, Saved] | None]:
    """File and what it says, of bodies in the initial configuration that go on from one."""
    for body in scene.case.bodies.values():
        region = body.region
        saved = region.summary.saved if isinstance(region, Points) else None
        goes_on = saved is not None and body.formulation == "total-lagrangian"
        yield (str(region.file), saved) if goes_on else None  # type: ignore[union-attr, misc]


def _field(saved: Saved) -> int:
    assert saved.grid is not None
    return saved.grid.fields[saved.number]


def _put(rank: Rank, name: str, saved: Saved, field: int) -> None:
    """Set the motion of the rank's vertices in a field from a checkpoint."""
    grid, old = rank.grid, saved.grid
    assert old is not None
    shift = _shift(name, rank.scene, old)
    _, ny, nz = [*(n + 1 + 2 * old.ghost for n in old.cells), 1, 1][:3]
    count = 1 + max(old.fields)
    try:
        file = CheckpointFile(name)
        planes = file.read_whole(MOTION_PLANES)
        edges = np.concatenate([[0], np.cumsum(planes)])
        first = rank.slab.first - shift[0]
        ends = np.clip([first, first + grid.planes], 0, len(planes))
        begin, end = edges[ends].tolist()
        none = np.zeros(0, np.int64), np.zeros((0, 6))
        keys, values = (
            (file.read_part(each, begin, end) for each in MOTION) if end > begin else none
        )
    except DamagedError as error:
        raise CaseError(f"cannot use the particles {name}: {error}") from None
    keys, f = np.divmod(keys, count)
    keys, z = np.divmod(keys, nz)
    x, y = np.divmod(keys, ny)
    mine = f == _field(saved)
    set_motion(rank, field, np.stack([x, y, z], axis=1)[mine] + shift, values[mine])


def _shift(name: str, scene: Scene, old: VertexGrid) -> np.ndarray:
    """Vertices by which the grid of a checkpoint begins further on, (3,) int64."""
    frame = scene.domain.frame
    by = (np.array(old.origin) - frame.origin) * frame.inverse
    whole = np.rint(by).astype(np.int64)
    same = np.allclose(old.cell, frame.cell, rtol=_NEAR, atol=0.0)
    if not same or (np.abs(by - whole) > _NEAR * np.array(frame.cells)).any():
        raise CaseError(
            f"grid: bodies in the initial configuration go on, from {name}, on the grid that they "
            f"had: cell {list(old.cell)}, and an origin whole cells from {list(old.origin)}"
        )
    whole += frame.ghost - old.ghost
    return np.concatenate([whole, np.zeros(3 - len(whole), np.int64)])
