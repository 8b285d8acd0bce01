"""Bounds on filled parts until the next selection, against motions that use up all of the slack."""

from itertools import product

import numpy as np
import pytest
from scenes import scene

from pgimp.case.schema import Case
from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.fill import fill
from pgimp.kernels.contact.gap import LEAST_FILLED
from pgimp.kernels.contact.lagrangian.candidates import find_candidates
from pgimp.kernels.contact.lagrangian.filled import _greatest_filled, bound_filled
from pgimp.kernels.contact.lagrangian.rigid_ends import may_fill
from pgimp.kernels.contact.lagrangian.vertices import (
    NEAR_MOTION,
    NEAR_PARTICLE,
    VERTEX_SUMS,
    ContactVertices,
    Reached,
)
from pgimp.kernels.data.frame import Frame
from pgimp.mpi.comm import Serial
from pgimp.scene.rigid import images
from pgimp.scene.scene import Scene

HALF, COUNT = 0.25, 60


def weights(x):
    """Weights of the vertices at -2, .., 3 for particles at `x` in cells, and their slopes."""
    x = x[..., None] - np.arange(-2, 4)
    away = np.abs(x)
    edge = 1.0 + HALF - away
    w = np.select(
        [away < HALF, away < 1.0 - HALF, away < 1.0 + HALF],
        [1.0 - (x * x + HALF**2) / (2.0 * HALF), 1.0 - away, edge**2 / (4.0 * HALF)], 0.0,
    )  # fmt: skip
    slope = np.select(
        [away < HALF, away < 1.0 - HALF, away < 1.0 + HALF],
        [away / HALF, np.ones_like(x), edge / (2.0 * HALF)], 0.0,
    )  # fmt: skip
    return w, -np.sign(x) * slope


def moved(rng, D, F, slack):
    """Displacements in cells and changes of F, if vertices move by the slack; some grow most."""
    w, g = weights(rng.random((COUNT, D)))
    S, G = np.ones((COUNT, 1)), np.ones((COUNT, D, 1))
    for d in range(D):
        S = (S[..., None] * w[:, d, None, :]).reshape(COUNT, -1)
        rows = np.where(np.arange(D)[:, None] == d, g[:, d, None], w[:, d, None])
        G = (G[..., None] * rows[:, :, None, :]).reshape(COUNT, D, -1)
    cofactors = np.linalg.det(F)[:, None, None] * np.linalg.inv(F).transpose(0, 2, 1)
    most = np.sign(np.einsum("pij,pjv->piv", cofactors, G))
    u = np.where(rng.random(most.shape) < rng.random((COUNT, 1, 1)) ** 2,
                 rng.choice([-1.0, 1.0], most.shape), most)  # fmt: skip
    return slack * np.einsum("piv,pv->pi", u, S), slack * np.einsum("piv,pjv->pij", u, G)


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("slack", [0.05, 0.3])
def test_no_particle_fills_more_than_its_bound(D, slack):
    """Compressed and sheared ones that vertices pull apart, each alone in its group."""
    rng = np.random.default_rng((D, int(100 * slack)))
    frame = Frame(origin=(0.0,) * D, cell=(1.0,) * D, inverse=(1.0,) * D, cells=(9,) * D, ghost=2)
    table, motion = np.zeros(COUNT, NEAR_PARTICLE), np.zeros(COUNT, NEAR_MOTION)
    table["half_width"][:, :D], table["group"] = HALF, np.arange(COUNT)
    F = rng.normal(0.0, 0.2, (COUNT, D, D)) + rng.uniform(0.3, 1.3, (COUNT, D, 1)) * np.eye(D)
    F[np.linalg.det(F) < 0.1] = np.eye(D)
    x = rng.uniform(3.0, 6.0, (COUNT, D))
    motion["position"][:, :D], motion["volume"] = x, np.linalg.det(F)
    motion["inverse_F"][:, :D, :D] = np.linalg.inv(F)
    none = np.empty(0, np.int64)
    contact_vertices = ContactVertices(
        np.full(3, -20), np.full(3, 60), COUNT, none, none, none, Reached.empty(0, 0),
        np.empty(0, VERTEX_SUMS), none, none,
    )  # fmt: skip
    boxes = np.array([[[-50] * 3, [50] * 3]])
    patches = find_candidates(
        frame, (table, motion), (slack, 0.0), 3, np.array([0, -50, 50]), boxes, (), contact_vertices
    )
    most = np.empty(len(patches.keys))
    bound_filled(frame, table, motion, slack, 3, patches, most)
    bounds = {}
    for key, bound in zip(patches.keys.tolist(), most, strict=True):
        vertex, group = divmod(key, COUNT)
        extent, low = contact_vertices.extent, contact_vertices.low
        number = np.array(np.unravel_index(vertex, extent)) + low
        bounds[group, *number[:D].tolist()] = bound
    tightest = 0.0
    for _ in range(6):
        u, dF = moved(rng, D, F, slack)
        volume = np.linalg.det(F + dF)
        for p in range(COUNT):
            for number in product(*(range(int(c) - 1, int(c) + 4) for c in x[p])):
                S = weights(x[p] + u[p] - np.array(number) + frame.ghost)[0][:, 2].prod()
                if S == 0.0:
                    continue
                bound = bounds.get((p, *number), 0.0)
                assert volume[p] * S <= bound * (1.0 + 1e-12)
                tightest = max(tightest, volume[p] * S / bound) if bound else tightest
    assert tightest > 0.3


@kernel
def rigid_bound(rigid_bodies, frame, number, slack, out):
    """Bound on the filled part of a vertex, and whether the body may fill some of it."""
    out[0] = _greatest_filled(rigid_bodies, 0, frame, number, slack)
    out[1] = may_fill(rigid_bodies, frame, number, slack)


@kernel
def rigid_part(rigid_bodies, frame, number, sides, out):
    """The filled part of a vertex."""
    out[0] = rigid_bodies.point[0].filled if fill(rigid_bodies, 0, frame, number, sides) else 0.0


MIDDLE, FLAT = np.array([7.0, 7.0, 5.0]), np.array([2.0, 0.6, 1.2])
REGIONS = {
    "plate": {"box": {"min": MIDDLE - FLAT, "max": MIDDLE + FLAT}},
    "cell": {"box": {"min": MIDDLE - 0.55, "max": MIDDLE + 0.55}},
    "ball": {"ball": {"centre": MIDDLE, "radius": 0.8}},
    "wedge": {"intersection": [
        {"box": {"min": MIDDLE - 2.0, "max": MIDDLE + 2.0}},
        {"half-space": {"point": MIDDLE, "normal": np.array([0.35, 1.0, 0.2])}}]},
}  # fmt: skip


def turned(D, rng, angle):
    """A rotation by an angle, about any axis in 3D."""
    axis = np.array([0.0, 0.0, 1.0]) if D == 2 else rng.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def flat(entry, D):
    """A region of numbers in D directions."""
    if isinstance(entry, dict):
        return {key: flat(value, D) for key, value in entry.items()}
    if isinstance(entry, list):
        return [flat(value, D) for value in entry]
    return entry[:D].tolist() if isinstance(entry, np.ndarray) else entry


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", REGIONS)
@pytest.mark.parametrize("cell", [(1.0, 1.0, 1.0), (0.8, 1.1, 0.9)])
def test_no_rigid_body_fills_more_than_its_bound(D, kind, cell):
    """Wherever it lies, and however it moves and turns, on walls too."""
    rng = np.random.default_rng((D, len(kind)))
    block = {"box": {"min": [0.0] * D, "max": list(cell[:D])}}
    case = scene(D, {
        "a": {"material": "soft", "region": block, "configuration": "initial"},
        "tool": {"rigid": {}, "region": flat(REGIONS[kind], D)},
    }, cells=[18, 14, 11][:D], cell=cell[:D], contact=[{"bodies": "all"}])  # fmt: skip
    rigid = Scene(Case.model_validate(case)).interaction.rigid_bodies
    rigid.measure(Serial())
    frame, rigid_bodies = rigid.frame, rigid.in_planes(1)
    row, lattice, field = rigid_bodies.motion[0], rigid_bodies.lattice[0], rigid.fields[0]
    middle = np.array([*MIDDLE[:D], *[0.0] * (3 - D)])
    row["reference"], out, tight = middle, np.zeros(2), 0
    arm = np.linalg.norm(rigid.surface.points - middle, axis=1).max()

    def place(centre, rotation):
        row["centre"], row["rotation"] = centre, rotation
        images.bound(row, lattice, field, rigid.frame, rigid.periods)

    for _ in range(30):
        slack = rng.choice([0.05, 0.3])
        way, part = slack * min(frame.cell), rng.choice([0.0, rng.random(), 1.0])
        centre, rotation = middle.copy(), turned(D, rng, rng.uniform(0.0, 6.3))
        centre[:D] += rng.uniform(-0.5, 0.5, D)
        shift = rng.normal(size=D)
        after = centre.copy()
        after[:D] += (1.0 - part) * way * shift / np.linalg.norm(shift)
        place(after, turned(D, rng, rng.choice([-1, 1]) * part * way / arm) @ rotation)
        low, high = lattice["least"][:D], lattice["most"][:D] + 1
        found = []
        for number in rng.integers(low, high, (120, D)).tolist():
            sides = tuple(int(n) for n in rng.choice([0, 0, 0, -1, 1], D)) + (0,) * (3 - D)
            number = (*number, *[0] * (3 - D))
            rigid_part(rigid_bodies, frame, number, sides, out)
            if LEAST_FILLED <= out[0] < 0.7:
                found.append((number, sides, out[0]))
        place(centre, rotation)
        for number, sides, filled in found:
            rigid_bound(rigid_bodies, frame, number, slack, out)
            assert out[1] == 1.0
            assert filled <= out[0] * 2.0 ** np.count_nonzero(sides) + 1e-12
            tight += out[0] < 0.7
    assert tight
