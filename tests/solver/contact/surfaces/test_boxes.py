"""Bodies of whole particles, and of particles from files, meet by the surfaces of their boxes."""

import numpy as np
import pytest
from scenes import SOFT, energy, finish, scene, start
from tiers import wide

from pgimp.mpi.comm import Serial
from pgimp.solver.contact.surfaces.box_bodies import boxes_of

pytestmark = pytest.mark.slow(30)

HARD = SOFT | {"young": 1000.0}
STRAIN, END = 2e-3, 5.0


def lattice(low, high, step=0.5):
    """Points in the middle of boxes, (n, D)."""
    axes = [np.arange(a + 0.5 * step, b, step) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def from_file(path, x, volume):
    """A body of particles at places in a file."""
    names = ",".join("xyz"[: x.shape[1]]) + ",volume"
    rows = [",".join(map(repr, [*map(float, row), volume])) for row in x]
    path.write_text("\n".join([names, *rows]) + "\n")
    return {"points": {"file": str(path)}}


def initial(region, **more):
    return {"material": "soft", "formulation": "total-lagrangian", "region": region} | more


def box(low, high):
    return {"box": {"min": [*map(float, low)], "max": [*map(float, high)]}}


def meeting(bodies, cells, end, pairs, **more):
    contact = [{"bodies": [*pair], "friction": more.pop("friction", 0.0)} for pair in pairs]
    return scene(len(cells), bodies, cells=cells, end=end, contact=contact,
                 step={"courant": 0.3}, materials={"soft": HARD}, **more)  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "shift"),
    [
        ("file", (0.13, 0.17)), wide("file", (0.0, 0.0)), wide("file", (0.13, 0.17, 0.21)),
        ("whole-particles", (0.0, 0.0)),
    ],
)  # fmt: skip
def test_plates_press_a_block_of_boxes_evenly(tmp_path, kind, shift):
    """Wherever it is in the grid: at vertices stress was 0.2 to 1.4 of the mean."""
    D = len(shift)
    low = np.array([8.0, 8.0, 2.0][:D]) + shift
    high = low + [4.0, 3.0, 3.0][:D]
    region = box(low, high)
    if kind == "file":
        region = from_file(tmp_path / "block.csv", lattice(low, high), 0.5**D)
    surface = "cut-particles" if kind == "file" else kind
    bodies = {"block": initial(region, surface=surface)}
    for name, way in (("low", -1.0), ("high", 1.0)):
        speed, rest = [0.0] * D, [0.0] * D
        speed[1] = -1.5 * way * STRAIN / (0.4 * END)
        table = [[0.0, speed], [0.4 * END, speed], [0.401 * END, rest]]
        middle, half = 0.5 * (low + high), np.array([3.5, 1.0, 3.0][:D])
        middle[1] += 2.5 * way
        plate = box(middle - half, middle + half)
        bodies[name] = {"rigid": {"velocity": {"table": table}}, "region": plate}
    case = meeting(bodies, [20, 20, 7][:D], END, [("block", "low"), ("block", "high")],
                   damping={"mass": 6.0})  # fmt: skip
    sim = finish(start(case))
    stress = sim.particles.sigma[sim.live()][:, 1]
    assert stress.mean() == pytest.approx(-STRAIN * 1000.0 / (0.91 if D == 2 else 1.0), rel=0.01)
    np.testing.assert_allclose(stress, stress.mean(), rtol=1e-5)


def test_disks_of_boxes_rebound_in_any_frame(tmp_path):
    """Of whole particles, on one from a file: momenta are kept, and energy is not made."""
    R, found = 4.0, []
    x = lattice([11.9, 3.1], [19.9, 11.1])
    x = x[((x - [15.73, 7.4]) ** 2).sum(axis=1) < R * R]
    for V in (0.0, 0.2):
        speed, end = 20.0 * V, 5.0
        disk = {"ball": {"centre": [7.13, 7.21], "radius": R}}
        bodies = {
            "a": initial(disk, surface="whole-particles", velocity=[speed + 0.3, 0.0]),
            "b": initial(from_file(tmp_path / "b.csv", x, 0.25), velocity=[speed - 0.3, 0.0]),
        }
        size = [int(26 + speed * end), 15]
        sim = start(meeting(bodies, size, end, [("a", "b")], friction=0.3))
        first, last = sim.diagnostics(), finish(sim).diagnostics()
        v = [
            [line[f"body.{name}.momentum-x"] / line[f"body.{name}.mass"] for name in "ab"]
            for line in (first, last)
        ]
        found.append((v[1][1] - v[1][0]) / (v[0][0] - v[0][1]))
        scale = first["body.a.mass"]
        for name, length in (("momentum-x", 1), ("momentum-y", 1), ("angular-momentum-z", 20)):
            assert abs(last[name] - first[name]) < 1e-11 * scale * length * (1.0 + speed)
        assert energy(last) < energy(first)
    assert found[0] == pytest.approx(found[1], abs=1e-6)
    assert 0.8 < found[0] < 1.0


@pytest.mark.parametrize("jitter", [0.0, 0.06])
def test_boxes_of_particles_off_any_lattice(tmp_path, jitter):
    """Those near a lattice fill the boxes there; those on one of their own have its boxes."""
    low, high = np.array([3.0, 3.0]), np.array([7.0, 6.0])
    x = lattice(low, high)
    x += np.random.default_rng(3).uniform(-jitter, jitter, x.shape)
    body = initial(from_file(tmp_path / "block.csv", x, 0.25))
    sim = start(scene(2, {"block": body}, cells=[10, 10], end=1.0))
    assert isinstance(sim.rank.comm, Serial)
    found = boxes_of(sim.rank, 0)
    (whole,) = found.slabs((-5, 100))
    areas = [np.diff(e) for e in found.edges]
    filled = whole.exists.reshape([len(each) for each in areas]) * np.outer(*areas)
    assert filled.sum() == pytest.approx(12.0)
    inside = [0.5 * (e[1:] + e[:-1]) for e in found.edges]
    at = np.argwhere(filled > 0.0)
    middle = np.stack([inside[d][at[:, d]] for d in range(2)], axis=1)
    assert (middle > low).all() and (middle < high).all()
