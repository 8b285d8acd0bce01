"""Motion of vertices in checkpoints: written by plane, read by any number of ranks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_VELOCITY

if TYPE_CHECKING:
    from pgimp.decomposition.grid import Grid
    from pgimp.solver.rank import Rank

#: Datasets of a checkpoint: numbers of vertices by plane; by vertex, in the order of the keys, key
#: and motion. A key combines plane, y, z and velocity field, all counted in the whole grid.
MOTION_PLANES, MOTION = "vertex-planes", ("vertex", "vertex-motion")

_VELOCITY = slice(KEPT_VELOCITY, KEPT_VELOCITY + 3)
_DISPLACEMENT = slice(DISPLACEMENT, DISPLACEMENT + 3)


def stored_motion(rank: Rank) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers by plane, keys and values (velocity, displacement) of a rank's moving vertices."""
    grid = rank.grid
    if not grid.motion:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 6))
    values = grid.by_vertex(grid.kept.values)[: grid.owned].transpose(0, 2, 3, 1, 4)
    kept = np.concatenate([values[..., _VELOCITY], values[..., _DISPLACEMENT]], axis=-1)
    moving = kept.any(axis=-1) & grid.kept.fields
    keys = vertex_keys(grid, values.shape[3])[: grid.owned]
    counts = moving.sum(axis=(1, 2, 3)).astype(np.int64)
    return counts, keys[moving], kept[moving]


def vertex_keys(grid: Grid, fields: int) -> np.ndarray:
    """Keys of a rank's vertices, (planes, y, z, fields) int64."""
    ny, nz = (*grid.frame.vertices, 1, 1)[1:3]
    x, y, z, f = np.meshgrid(
        *(
            np.arange(n) + low
            for n, low in zip(
                (grid.planes, *grid.window.extent[1:], fields), (*grid.window.lower, 0), strict=True
            )
        ),
        indexing="ij",
    )
    return ((x * ny + y) * nz + z) * fields + f


def put_motion(rank: Rank, keys: np.ndarray, values: np.ndarray) -> bool:
    """Set the motion of a rank's planes from a checkpoint; whether all keys are of its vertices."""
    grid = rank.grid
    mine = grid.by_vertex(grid.kept.values).transpose(0, 2, 3, 1, 4)
    known = vertex_keys(grid, mine.shape[3])
    index = np.searchsorted(known.reshape(-1), keys)
    inside = index < known.size
    if not (inside.all() and (known.reshape(-1)[index] == keys).all()):
        return False
    x, y, z, f = np.unravel_index(index, known.shape)
    mine[x, y, z, f, _VELOCITY], mine[x, y, z, f, _DISPLACEMENT] = values[:, :3], values[:, 3:]
    return True


def set_motion(rank: Rank, field: int, vertices: np.ndarray, values: np.ndarray) -> None:
    """Set the motion of a velocity field; other vertices of the field have none.

    Parameters
    ----------
    field : int
        The velocity field.
    vertices : (n, 3) int64
        Numbers of vertices; those that the rank does not have are left out.
    values : (n, 6) float64
        Their velocities and displacements.
    """
    grid = rank.grid
    mine = grid.by_vertex(grid.kept.values)[:, field]
    mine[..., _VELOCITY] = mine[..., _DISPLACEMENT] = 0.0
    at = vertices - grid.window.lower
    there = ((at >= 0) & (at < mine.shape[:3])).all(axis=1)
    x, y, z = at[there].T
    mine[x, y, z, _VELOCITY], mine[x, y, z, _DISPLACEMENT] = np.split(values[there], 2, axis=1)
