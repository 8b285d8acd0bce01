"""Velocity gradients of particles from a file, with the affine transfer."""

import numpy as np
import pytest
from clouds import affine, points
from meshes import case
from point_files import write_csv, write_hdf5
from scenes import field, start

import pgimp
from pgimp.mpi.comm import Serial


def scattered(D, seed, n=9, spread=0.3):
    """Particles near the points of a lattice in the square from -1.5 to 1.5, and a linear field."""
    rng = np.random.default_rng(seed)
    along = (np.arange(n) + 0.5) / n * 3.0 - 1.5
    x = np.stack(np.meshgrid(*[along] * D), axis=-1).reshape(-1, D)
    x = rng.permutation(x + rng.uniform(-spread, spread, x.shape) * 3.0 / n)
    gradient, constant = rng.normal(size=(D, D)), rng.normal(size=D)
    volume = np.full(len(x), (3.0 / n) ** D)
    return {"position": x, "volume": volume, "velocity": constant + x @ gradient.T}, gradient


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("n", [5, 9, 14])
def test_the_gradient_of_a_linear_field_is_exact(tmp_path, D, n, ending):
    """Of particles coarser than the lattice's (0.25) and finer; at the surface too."""
    data, gradient = scattered(D, D, n)
    (write_csv if ending == "csv" else write_hdf5)(tmp_path / f"p.{ending}", data)
    sim = start(affine(points(tmp_path / f"p.{ending}"), D))
    L = field(sim, "L").reshape(-1, D, D)
    assert len(L) == len(data["volume"])
    assert np.abs(L - gradient).max() < 1e-12


def test_a_smooth_field_has_its_gradient_by_second_order(tmp_path):
    """Against the derivative: 4 times less for half the distance in the interior."""
    errors = []
    for n in (10, 20):
        data, _ = scattered(2, 3, n, 0.0)
        x, y = data["position"].T
        data["velocity"] = np.stack([np.sin(x + 2 * y), x * x * y], axis=1)
        write_hdf5(tmp_path / "p.h5", data)
        L = field(start(affine(points(tmp_path / "p.h5"), 2, cell=6.0 / n / 1.5)), "L")
        wave = np.cos(x + 2 * y)
        exact = np.stack([wave, 2 * wave, 2 * x * y, x * x], axis=1)
        interior = (np.abs(data["position"]) < 1.0).all(axis=1)
        errors.append(np.abs(L - exact)[interior].max())
    assert errors[1] < 0.35 * errors[0] and errors[0] < 0.3


def test_few_neighbours_or_neighbours_on_a_line_give_the_solution_of_least_norm(tmp_path):
    gradient = np.array([[1.0, 2.0, 0.5], [-0.5, 0.3, 0.7], [0.2, 0.4, -0.9]])
    line = np.array([0.6, 0.0, 0.8])
    groups = {
        "line": (np.arange(4)[:, None] * 0.2 * line - 1.0, np.outer(line, line)),
        "pair": (np.array([[1.0, 1.0, -1.0], [1.0, 1.2, -1.0]]), np.diag([0.0, 1.0, 0.0])),
        "plane": (
            np.array([[0.2 * i, 0.2 * j, 1.5] for i in range(4) for j in range(3)]),
            np.diag([1.0, 1.0, 0.0]),
        ),
        "alone": (np.array([[-1.5, 1.5, -1.5]]), np.zeros((3, 3))),
    }
    x = np.concatenate([place for place, _ in groups.values()])
    expected = np.concatenate(
        [np.tile(gradient @ within, (len(place), 1, 1)) for place, within in groups.values()]
    )
    data = {"position": x, "volume": np.full(len(x), 0.25**3), "velocity": x @ gradient.T}
    write_hdf5(tmp_path / "p.h5", data)
    L = field(start(affine(points(tmp_path / "p.h5"), 3)), "L").reshape(-1, 3, 3)
    np.testing.assert_allclose(L, expected, atol=1e-12)


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("D", [1, 2, 3])
def test_a_gradient_in_the_file_is_taken_as_it_is(tmp_path, D, ending):
    data, _ = scattered(D, D)
    given = np.random.default_rng(3).normal(size=(len(data["volume"]), D, D))
    if ending == "csv":
        names = [f"velocity-gradient-{a}{b}" for a in "xyz"[:D] for b in "xyz"[:D]]
        write_csv(
            tmp_path / "p.csv",
            data,
            **dict(zip(names, given.reshape(len(given), -1).T, strict=True)),
        )
    else:
        padded = np.zeros((len(given), 3, 3))
        padded[:, :D, :D] = given
        write_hdf5(tmp_path / "p.h5", data | {"velocity-gradient": padded})
    sim = start(affine(points(tmp_path / f"p.{ending}"), D))
    assert (field(sim, "L") == given.reshape(len(given), -1)).all()
    assert start(case(points(tmp_path / f"p.{ending}"), dimension=D)).count == len(given)


def test_a_frame_of_a_spinning_disk_goes_on_spinning(tmp_path):
    """A frame with the gradients of its particles; at the start they are those of the motion."""
    disk = {"ball": {"centre": [0.1, 0.0], "radius": 1.2}}
    fields = ["velocity", "stress", "deformation", "mass", "initial-volume", "velocity-gradient"]
    spin = affine(disk, 2, end=0.02, output={"fields": fields})
    spin["bodies"]["body"] |= {
        "surface": "whole-particles",
        "velocity": {"rotation": {"about": [0.1, 0.0], "rate": 2.0}},
    }
    sim = start(spin)
    pgimp.run(spin, comm=Serial(), output=tmp_path / "spin", quiet=True)
    expected = np.tile([0.0, -2.0, 2.0, 0.0], (sim.count, 1))
    np.testing.assert_allclose(field(sim, "L"), expected, atol=1e-12)
    frames = sorted((tmp_path / "spin/frames").glob("particles-*.h5"))
    first = start(affine(points(frames[0]), 2))
    np.testing.assert_allclose(field(first, "L"), expected, atol=1e-12)
    assert first.count == sim.count
    while not sim.finished:
        sim.advance()
    last = start(affine(points(frames[-1]), 2))
    assert np.array_equal(field(last, "L"), field(sim, "L"))
