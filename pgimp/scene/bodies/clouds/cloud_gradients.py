"""Velocity gradients of particles from a file that only has their velocities.

With `method.affine` every particle carries the gradient of the velocity around it. For a body with
a prescribed initial motion the gradient follows from the motion. For a cloud it follows from the
velocities of nearby particles, by weighted least squares. The fit is exact for a field linear in
space; if the nearby particles lie on a line or in a plane, it is the solution of least norm.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.points.block import Block
from pgimp.scene.bodies.clouds.point_cloud import Cloud
from pgimp.scene.bodies.lattice import ParticleBlock

Reals = NDArray[np.float64]

#: Search radius for neighbours, over the largest particle's size.
_REACH = 2.0

#: Limits of the particle size, over the lattice particles' size: files may have anything.
_SMALLEST, _LARGEST = 0.25, 4.0

#: Cells along a direction: cell numbers stay below 2^63.
_MOST_CELLS = 2**20


def with_gradients(
    cloud: Cloud, box: Sequence[float], blocks: list[ParticleBlock]
) -> list[ParticleBlock]:
    """Add velocity gradients to particles of a cloud whose file has none.

    The gradients do not depend on the division into blocks.

    Parameters
    ----------
    cloud : Cloud
        All particles.
    box : sequence of float
        Size of a lattice box by direction.
    blocks : list of ParticleBlock
        The particles to complete; returned unchanged if the file gives no velocities.

    Raises
    ------
    CaseError
        If the file is no longer readable.
    """
    if not blocks or blocks[0].velocities is None or blocks[0].gradients is not None:
        return blocks
    positions, velocities = (
        np.concatenate([getattr(block, name) for block in blocks])
        for name in ("positions", "velocities")
    )
    from pgimp.kernels.once.neighbours import fit_gradients

    about, size, D = cloud.region.summary, np.array(box), len(box)
    low, extent = np.array(about.low), np.array(about.high) - np.array(about.low)
    ratio = np.clip((about.most / size.prod()) ** (1.0 / D), _SMALLEST, _LARGEST)
    reach = np.maximum(_REACH * ratio * size, extent / _MOST_CELLS)

    def cells(x: Reals) -> NDArray[np.int64]:
        return np.floor((x - low) / reach).astype(np.int64) + 1

    number = cells(np.array(about.high)[None])[0] + 2
    strides = np.append(np.cumprod(number[:0:-1])[::-1], 1).astype(np.int64)
    own = cells(positions)
    first, last = int(own[:, 0].min()) - 1, int(own[:, 0].max()) + 1

    def near(block: Block) -> NDArray[np.bool_]:
        along = np.floor((block.position[:, 0] - low[0]) / reach[0]) + 1
        return (first <= along) & (along <= last)

    parts = [(block.position, block.velocity) for _, block in cloud.region.chosen(near)]
    x = np.concatenate([position for position, _ in parts])
    v = np.concatenate([velocity for _, velocity in parts if velocity is not None])
    keys = (cells(x) * strides).sum(axis=1)
    order = np.argsort(keys, kind="stable")  # of a cell in the order of the file
    out = np.empty((len(positions), D * D))
    chosen = np.ascontiguousarray(positions), np.ascontiguousarray(velocities)
    own = (own * strides).sum(axis=1)
    fit_gradients((x[order], v[order], keys[order]), (*chosen, own), strides, reach, out)
    ends = np.cumsum([len(block.ids) for block in blocks])
    gradients = np.split(out, ends[:-1])
    return [block._replace(gradients=part) for block, part in zip(blocks, gradients, strict=True)]
