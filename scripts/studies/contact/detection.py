"""Two ways to find gap and normal at a vertex where bodies touch, measured beside each other.

Surface vectors: each particle has the integrals A0 = int N dA and K0 = int N (X - X_p) dA over the
surface within its box, here by quadrature of the exact surface. Vertices sum A = sum S A0,
B = sum S |A0| and Q = sum S sym(K0 + A0 (x_p - x_v)). With c = |A|/B of each body the normal is
that of c_a^20 B_a A_a/|A_a| - c_b^20 B_b A_b/|A_b|, and the gap that of the offsets n.Qn/(A.n).
Volume fractions are what is built, see `pgimp.kernels.contact.gap`: gap and normal from sums of
V_p S and V_p grad S. Particles, their volumes and weights are pgimp's.

Of volume fractions there are two: with particles that a surface cuts where they are, at their
places on the lattice, and as they are built, with what is left of their boxes, less what curvature
adds.

Nothing moves: bodies touch in a point or along a face, so that the exact gap is known everywhere.
"""

import re
from functools import partial
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np
from studies.contact import gap
from studies.contact.touches import balls, corner, edge, flat
from studies.harness import table
from studies.scenes import box

import pgimp
from pgimp.kernels.contact.gap import LEAST_FILLED
from pgimp.kernels.contact.volumes import MIN_HALF_WIDTH
from pgimp.physics.shapes.gimp import GimpParameters

#: Particles a cell along each direction.
PER_CELL = 2
#: Vertices around the point of contact that are looked at, along each direction.
REACH = 3
#: Power of the flatness c, and least part of a body's surface that is across the normal, of 1.3.
FLATTER, ACROSS = 20, 0.05


def _weights(x, way=0.0):
    """Lowest vertex, weights and their slopes, (n, D, 3), of particles at x.

    Of those that are cut with the way to their centroids, see `pgimp.kernels.contact.volumes`.
    """
    half = np.maximum(0.5 / PER_CELL - np.abs(way), MIN_HALF_WIDTH)
    first = np.floor(x + way - half)
    each = np.vectorize(
        lambda half, f: np.array(GimpParameters.weights(None, half, f)), signature="(),()->(k,n)"
    )(half + 0.0 * x, x + way - first)
    w, g = each[..., 0, :], each[..., 1, :]
    return first.astype(int), w, g


def _spread(x, values, low, count, way=0.0):
    """Sums of S and of its slopes, times values (n, k): (vertices, k) and (vertices, k, D)."""
    D = x.shape[1]
    first, w, g = _weights(x, way)
    sums = np.zeros((count**D, values.shape[1]))
    slopes = np.zeros((count**D, values.shape[1], D))
    for corner_ in np.ndindex(*[3] * D):
        S, place = np.ones(len(x)), np.zeros(len(x), int)
        slope = np.ones((len(x), D))
        inside = np.ones(len(x), bool)
        for d in range(D):
            at = first[:, d] + corner_[d] - low[d]
            inside &= (at >= 0) & (at < count)
            place = place * count + at
            S = S * w[:, d, corner_[d]]
            for e in range(D):
                slope[:, e] *= (g if d == e else w)[:, d, corner_[d]]
        np.add.at(sums, place[inside], (S[:, None] * values)[inside])
        np.add.at(slopes, place[inside], (values[:, :, None] * slope[:, None])[inside])
    return sums, slopes


class Body(NamedTuple):
    """Particles of a body, and what they know of its surface: see `Particles`, and the head."""

    x: np.ndarray
    V: np.ndarray
    offset: np.ndarray
    excess: np.ndarray
    A: np.ndarray
    K: np.ndarray


def _bodies(make, shift, lattices):
    """Two bodies that touch, each from its own place on the lattice."""
    touch, found = make(shift), []
    for number, lattice in enumerate(lattices):
        there = make(shift + lattice)
        D = len(there.middle)
        other = box([0.0] * D, [1.0] * D)
        pair = gap.stiff({"a": there.regions[number], "b": other}, np.zeros(D))
        core = pgimp.Simulation(pair).core
        rows, p = core.live(), core.particles
        rows = rows[p.body[rows] == 0]
        A, K = _surface_sums(p.x[rows], there.surfaces[number])
        x = p.x[rows] + touch.middle - there.middle
        found.append(Body(x, p.V[rows], p.offset[rows], p.excess[rows, 0], A, K))
    return touch, found


def _surface_sums(x, surface):
    """A0 and K0 of particles at x; what lies in a box without one goes to the nearest."""
    D = x.shape[1]
    boxes = {tuple(row): k for k, row in enumerate(np.floor(x * PER_CELL).astype(int))}
    keys, index = np.unique(
        np.floor(surface.points * PER_CELL).astype(int), axis=0, return_inverse=True
    )
    index = index.reshape(-1)
    owner = np.empty(len(keys), int)
    for k, key in enumerate(keys):
        if tuple(key) in boxes:
            owner[k] = boxes[tuple(key)]
        else:
            owner[k] = ((x - (key + 0.5) / PER_CELL) ** 2).sum(axis=1).argmin()
    owner = owner[index]
    vector = surface.normals * surface.areas[:, None]
    A, K = np.zeros((len(x), D)), np.zeros((len(x), D, D))
    np.add.at(A, owner, vector)
    np.add.at(K, owner, vector[:, :, None] * (surface.points - x[owner])[:, None])
    return A, K


def _by_surfaces(grid, low, count, bodies):
    """Gaps and normals by surface vectors at the vertices; nan where they are not valid."""
    sums = []
    for body in bodies:
        x, A, K, D = body.x, body.A, body.K, body.x.shape[1]
        size = np.linalg.norm(A, axis=1)
        some = (size > 0.0) & (np.abs(x - grid.mean(axis=0)) < 0.5 * count + 2.0).all(axis=1)
        A, K, x, size = A[some], K[some], x[some], size[some]
        moment = K + A[:, :, None] * x[:, None]  # about the origin
        moment = 0.5 * (moment + moment.swapaxes(1, 2))
        values = np.concatenate([A, size[:, None], moment.reshape(len(x), -1)], axis=1)
        found, _ = _spread(x, values, low, count)
        a, b, q = found[:, :D], found[:, D], found[:, D + 1 :].reshape(-1, D, D)
        turn = a[:, :, None] * grid[:, None]
        sums.append((a, b, q - 0.5 * (turn + turn.swapaxes(1, 2))))
    with np.errstate(invalid="ignore", divide="ignore"):
        n = 0.0
        for sign, (a, b, _) in zip((1.0, -1.0), sums, strict=True):
            length = np.linalg.norm(a, axis=1)
            n = n + np.nan_to_num(sign * ((length / b) ** FLATTER * b / length)[:, None] * a)
        n = n / np.linalg.norm(n, axis=1)[:, None]
        offsets, valid = [], np.isfinite(n).all(axis=1)
        for sign, (a, b, q) in zip((1.0, -1.0), sums, strict=True):
            along = (a * n).sum(axis=1)
            offsets.append(np.einsum("vi,vij,vj->v", n, q, n) / along)
            valid &= sign * along > ACROSS * b
    return np.where(valid, offsets[1] - offsets[0], np.nan), n


def _by_volumes(low, count, bodies, built):
    """Gaps, normals and parts filled by volume fractions.

    Particles that surfaces cut count where they are, or, as `built`, where their volume is, and
    gaps are less by what curvature adds to them.
    """
    parts, outward, excess = [], [], 0.0
    for body in bodies:
        near = (body.x > low - 2.0).all(axis=1) & (body.x < low + count + 1.0).all(axis=1)
        x, V, d, e = (values[near] for values in body[:4])
        cut = (d != 0.0).any(axis=1)
        values = np.column_stack([V, e, cut])
        sums, slopes = _spread(x, values, low, count, d if built else 0.0)
        part = sums[:, 0]
        if built:
            excess = excess + sums[:, 1] / np.maximum(sums[:, 2], 1e-300)
        parts.append(part)
        outward.append(slopes[:, 0])
    missing = 1.0 - parts[0] - parts[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        n = outward[0] - outward[1]
        n = n / np.linalg.norm(n, axis=1)[:, None]
        areas = [np.abs((g * n).sum(axis=1)) for g in outward]
        small = np.where(areas[0] < areas[1], *parts)
        part = np.minimum(small, np.where(areas[0] < areas[1], *parts[::-1]))
        gaps = missing / np.sqrt(np.minimum(2.0 * part, 1.0))
    return gaps - excess, n, parts


class Found(NamedTuple):
    """What one way finds: gaps at first contact, and squares of errors with their weights."""

    first: list
    gaps: list
    angles: list


def measure(make, shift, lattices, found):
    """Add what the ways find of two bodies that touch to `found`."""
    touch, bodies = _bodies(make, shift, lattices)
    D = len(touch.middle)
    low = np.floor(touch.middle).astype(int) - REACH
    count = 2 * REACH + 2
    grid = low + np.stack(np.meshgrid(*[np.arange(count)] * D, indexing="ij"), -1).reshape(-1, D)
    plain, n, _ = _by_volumes(low, count, bodies, built=False)
    built, n_built, parts = _by_volumes(low, count, bodies, built=True)
    by_surfaces, n_surfaces = _by_surfaces(grid, low, count, bodies)
    x = grid - touch.middle
    aside = x - (x @ touch.normal)[:, None] * touch.normal
    inner = (np.abs(x) < REACH - 1.0).all(axis=1)
    near = inner & (np.linalg.norm(aside, axis=1) < 1.01)
    met = near & (np.minimum(*parts) >= LEAST_FILLED)
    weight = parts[0] * parts[1] / (parts[0] + parts[1] + 1e-300)
    exact = touch.distance(x)
    ways = {"surfaces": (by_surfaces, n_surfaces), "plain": (plain, n), "built": (built, n_built)}
    for name, (gaps, normals) in ways.items():
        use = met & np.isfinite(gaps) & np.isfinite(normals).all(axis=1)
        if not use.any():
            continue
        entry = found.setdefault(name, Found([], [], []))
        entry.first.append(-gaps[use].min())
        part = weight[use] / weight[use].sum()
        entry.gaps.append(part @ (gaps[use] - exact[use]) ** 2)
        angle = np.degrees(np.arccos(np.clip(normals[use] @ touch.normal, -1.0, 1.0)))
        entry.angles.append(part @ angle**2)


def _way(angle, dimensions=2):
    a = angle * pi / 180.0
    return [cos(a), sin(a), 0.0][:dimensions]


def rows(quick=False):
    """Rows of the table: what touches, and what each way finds of it."""
    rng = np.random.default_rng(3)
    touching = {f"flat faces at {angle:.0f} degrees, 2D": [partial(flat, 2, _way(angle))] * 12
                for angle in (0.0, 20.0, 45.0)}  # fmt: skip
    for radius in (5.0, 10.0):
        touching[f"disks, R = {radius:.0f} cells"] = [
            partial(balls, 2, radius, _way(30.0 * k)) for k in range(12)
        ]
    for angle in (45.0, 20.0):
        what = f"a square's corner at {angle:.0f} degrees on a plane"
        touching[what] = [partial(corner, angle)] * 12
    touching["the edge of a block that lies on a plane"] = [edge] * 12
    for name, way in (
        ("along an axis", [1.0, 0.0, 0.0]), ("at 30 degrees", _way(30.0, 3)),
        ("along a diagonal", [1.0, 1.0, 1.0]),
    ):  # fmt: skip
        touching[f"flat faces {name}, 3D"] = [partial(flat, 3, way)] * 4
    for radius in (5.0, 10.0):
        touching[f"balls, R = {radius:.0f} cells"] = [
            partial(balls, 3, radius, [*_way(25.0 * k), 0.4 * k]) for k in range(6)
        ]
    for what, makers in touching.items():
        found = {}
        for make in makers[: 2 if quick else None]:
            D = 3 if what.endswith("3D") or what.startswith("balls") else 2
            shift, *lattices = rng.random((3, D)) - 0.5
            # On the lattice a face lies on the boxes' sides.
            lattices = [np.zeros(D)] * 2 if "block" in what else lattices
            measure(make, shift, lattices, found)
        yield what, found


def text(quick=False):
    """The table of both ways."""
    ways = {"surfaces": "surface vectors", "plain": "volume fractions", "built": "as built"}
    titles = (
        "what touches", *ways.values(), "gap: surface vectors", "volume fractions",
        "normal: surface vectors", "volume fractions",
    )  # fmt: skip
    lines = []
    for what, found in rows(quick):
        first = [f"{min(found[w].first):.3f} to {max(found[w].first):.3f}" for w in ways]
        gaps = [f"{np.sqrt(np.mean(found[w].gaps)):.3f}" for w in ("surfaces", "plain")]
        angles = [f"{np.sqrt(np.mean(found[w].angles)):.1f}" for w in ("surfaces", "plain")]
        lines.append((what, *first, *gaps, *angles))
    return re.sub(r"-(0\.0+)\b", r"\1", table(titles, lines))
