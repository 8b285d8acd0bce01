"""Largest stable Courant numbers in the initial configuration, by eigenvalues.

There vertices keep velocities and displacements, and weights are constant: steps are stable up to
2/omega, with the greatest frequency omega of the matrices of stiffness and lumped mass. Bodies are
those of `courant`, unstrained, cut by the grid at many offsets.

Run as ``scripts/hard vertices``; writes the table of docs/hard-cases.md, and the numbers that
``courant: auto`` takes, in pgimp/case/stepping/courant.py.
"""

from math import floor

import numba
import numpy as np
from studies.harness import ROOT, Table, put

from pgimp.physics.shapes import SHAPES
from pgimp.physics.shapes.base import weights

#: Cells along a body, and offsets to the grid, by dimensions.
BODIES = {1: (8, 400), 2: (4, 60), 3: (3, 12)}
#: By name the shape, and Poisson's ratio if not 0.3. At 0.45 and 0.499 of two shapes.
ROWS = {
    **{shape: (shape, 0.3) for shape in SHAPES if shape != "cpdi-corners"},
    **{f"{shape}, {nu}": (shape, nu) for shape in ("gimp", "cpdi") for nu in (0.45, 0.499)},
}
#: Particles a cell and direction, by dimensions.
COUNTS = {1: (1, 2, 3, 4, 8), 2: (1, 2, 3, 4), 3: (1, 2)}
#: Vertices before the body and behind it.
ROOM = 4
#: Of a particle's mass: vertices with less are left out, as in a step.
CUTOFF = 1e-12


def vertex_limit(method, dimension, per_cell, poisson=0.3):
    """Largest stable dt c/h of the most unstable body, c that of longitudinal waves."""
    count = BODIES[dimension][1]
    offsets = np.random.default_rng(1).random((count, dimension))
    return min(box_limit(method, offset, per_cell, poisson) for offset in offsets)


def box_limit(method, offset, per_cell, poisson=0.3):
    """Largest stable dt c/h of a body whose low corner is at an offset to the grid's lines."""
    dimension = len(offset)
    cells = BODIES[dimension][0]
    entry = {**method, "particles-per-cell": [per_cell] * dimension}
    shape = SHAPES[entry["shape"]].model_validate(entry).fixed((1.0,) * dimension)
    places = ROOM + np.add.outer(offset, (np.arange(cells * per_cell) + 0.5) / per_cell)
    factors = [_weights(shape, x, cells + 2 * ROOM) for x in places]
    return 2.0 / np.sqrt(_stiffest(factors, poisson if dimension > 1 else 0.0))


@numba.njit
def _weights_at(shape, half, f):
    return weights(shape, half, f)


def _weights(shape, x, vertices):
    """Weights and gradients of particles along a direction, 2 of (particles, vertices)."""
    half = shape.half[0] if shape.half else 0.0
    found = np.zeros((2, len(x), vertices))
    for row, place in enumerate(x):
        first = int(np.floor(place - half))
        for which, values in enumerate(_weights_at(shape, half, place - first)):
            found[which, row, first : first + len(values)] = values
    return found


def _stiffest(factors, poisson):
    """The greatest omega^2 h^2/c^2 of a body; the volumes and densities of its particles are 1."""
    D = len(factors)
    products = [_product([each[int(d == along)] for d, each in enumerate(factors)])
                for along in (None, *range(D))]  # fmt: skip
    mass = products[0].sum(axis=0)
    used = mass > CUTOFF
    gradients, n = [each[:, used] for each in products[1:]], int(used.sum())
    shear = (0.5 - poisson) / (1.0 - poisson) if D > 1 else 0.5  # over the modulus of the waves
    lame = 1.0 - 2.0 * shear
    pairs = [[one.T @ other for other in gradients] for one in gradients]
    trace = sum(pairs[d][d] for d in range(D))
    K = np.block([
        [lame * pairs[a][b] + shear * (pairs[b][a] + (trace if a == b else 0.0)) for b in range(D)]
        for a in range(D)
    ])  # fmt: skip
    scale = np.tile(1.0 / np.sqrt(mass[used]), D)
    K *= scale[:, None] * scale
    assert K.shape == (D * n, D * n)
    return float(np.linalg.eigvalsh(K)[-1])


def _product(factors):
    """Products over the directions, (particles, vertices)."""
    found = np.ones((1, 1))
    for each in factors:
        found = np.einsum("pv,qw->pqvw", found, each).reshape(len(found) * len(each), -1)
    return found


def measured():
    """Limits by row, dimensions and particles a cell, rounded down."""
    return {
        row: {
            D: {n: floor(100.0 * vertex_limit({"shape": shape}, D, n, nu)) / 100.0 for n in counts}
            for D, counts in COUNTS.items()
            if D > 1 or nu == 0.3
        }
        for row, (shape, nu) in ROWS.items()
    }


def write_limits(found, path=ROOT / "pgimp" / "case" / "stepping" / "courant.py"):
    """Put the numbers, at most 1, where `courant: auto` finds them."""
    text = path.read_text(encoding="utf-8")
    head, _, rest = text.partition("VERTEX_LIMITS:")
    lines = ["VERTEX_LIMITS: dict[str, dict[int, dict[int, float]]] = {"]
    for row, by in found.items():
        if row in SHAPES and row != "mpm":
            lines.append(f'    "{row}": {{')
            for D, limits in by.items():
                most = {n: min(limit, 1.0) for n, limit in limits.items()}
                lines.append(f"        {D}: {most!r},")
            lines.append("    },")
    tail = rest[rest.index("\n}\n") + 2 :]
    path.write_text("\n".join([head + lines[0], *lines[1:], "}"]) + tail, encoding="utf-8")


def main():
    """Find all limits; write the table and the numbers."""
    found = measured()
    kinds = [(D, n) for D, counts in COUNTS.items() for n in counts]
    table = Table("shape", *(f"{D}D, {n} a cell" for D, n in kinds))
    for row, by in found.items():
        table.add(row, *(f"{by[D][n]:.2f}" if D in by else "" for D, n in kinds))
    put({"vertex-limits": table.text()})
    write_limits(found)
