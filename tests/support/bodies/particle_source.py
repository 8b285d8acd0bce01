"""Particles of known values on any number of ranks, to write frames of, and small disks to fill."""

import os
import subprocess
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

from pgimp.mpi.comm import Serial
from pgimp.physics.derived import DERIVED
from pgimp.physics.fields import BY_RANKS, EVERY, OPTIONAL
from pgimp.running.frames import Frames

LATERAL = {1: 3, 2: 4, 3: 6}
#: Fields of domains that are not periodic, and that need no material.
SAME = tuple(
    name
    for name in OPTIONAL
    if name not in {*BY_RANKS, "unwrapped", "strain-energy-density", "recovered-stress"}
)
#: Those that are stored, not computed from others.
PLAIN = tuple(name for name in SAME if name not in DERIVED)


def make_case(fields=PLAIN, **output):
    settings = {"fields": list(fields), "precision": "float64", "compression": "none"} | output
    return SimpleNamespace(title="a test", units="none", output=SimpleNamespace(**settings))


def make_sim(comm, count, dimension, empty=(), gone=()):
    """Spread particles of random values over the ranks, in storage with holes and no order.

    Returns the fake simulation and the values of all particles by id. Ranks in `empty` get none;
    particles in `gone` have left.
    """
    random = np.random.default_rng(7)
    values = {
        "id": np.arange(count),
        "body": (2 * np.arange(count) // count).astype(np.int32),
        "x": random.normal(size=(count, dimension)),
        "v": random.normal(size=(count, dimension)),
        "F": random.normal(size=(count, dimension**2)),
        "sigma": random.normal(size=(count, LATERAL[dimension])),
        "V": random.uniform(0.5, 2.0, size=count),
        "V0": random.uniform(0.5, 2.0, size=count),
        "L": random.normal(size=(count, dimension**2)),
        "m": random.uniform(0.5, 2.0, size=count),
        "origin": random.normal(size=(count, dimension)),
        "winding": random.integers(-2, 3, size=(count, dimension)),
    }
    owner = random.integers(comm.size, size=count)
    owner[np.isin(owner, empty)] = 0
    mine = np.setdiff1d(np.flatnonzero(owner == comm.rank), gone)
    storage = random.permutation(2 * len(mine) + 3)[: len(mine)]
    particles = SimpleNamespace()
    for name, of_all in values.items():
        stored = np.full((2 * len(mine) + 3, *of_all.shape[1:]), -99, of_all.dtype)
        stored[storage] = of_all[mine]
        setattr(particles, name, stored)
    scene = SimpleNamespace(
        dimension=dimension,
        body_names=("left", "right"),
        materials=SimpleNamespace(
            names=("soft", "hard"),
            body_material=(1, 0),
            entries=(SimpleNamespace(model="hooke"), SimpleNamespace(model="neo-hookean")),
            fills=None,
        ),
        case=SimpleNamespace(geometry="plane-strain", time=SimpleNamespace(mass_scaling=1.0)),
        settings=SimpleNamespace(loses=len(gone) > 0),
        fields=EVERY,
        domain=SimpleNamespace(ends=()),
        carried=SimpleNamespace(plate=False),
        setting=None,
        stateless=False,
    )
    population = SimpleNamespace(columns=particles, up_to_date=lambda: particles, released=False)
    sim = SimpleNamespace(
        comm=comm,
        count=count,
        time=0.1,
        step=3,
        dt=0.1,
        finished=False,
        scene=scene,
        particles=particles,
        population=population,
        rank=SimpleNamespace(scene=scene, comm=comm, population=population),
        live=lambda: storage,
    )
    return sim, {name: np.delete(of_all, gone, axis=0) for name, of_all in values.items()}


def expected(values, dimension):
    """What a frame must hold, from the values by id and the definitions of the fields."""
    count = len(values["id"])

    def padded(array, columns):
        return np.hstack([array, np.zeros((count, columns - array.shape[1]))])

    deformation = np.tile(np.eye(3), (count, 1, 1))
    gradient = values["F"].reshape(count, dimension, dimension)
    deformation[:, :dimension, :dimension] = gradient
    rates = np.zeros((count, 3, 3))
    rates[:, :dimension, :dimension] = values["L"].reshape(count, dimension, dimension)
    stress = padded(values["sigma"], 6)
    tensor = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(count, 3, 3)
    mean = np.trace(tensor, axis1=1, axis2=2) / 3
    deviator = tensor - mean[:, None, None] * np.eye(3)
    green = 0.5 * (np.swapaxes(deformation, 1, 2) @ deformation - np.eye(3))
    return {
        "id": values["id"],
        "body": values["body"],
        "material": np.array([1, 0])[values["body"]],
        "position": padded(values["x"], 3),
        "volume": values["V"],
        "radius": values["V"] ** (1 / dimension) / 2,
        "velocity": padded(values["v"], 3),
        "stress": stress,
        "displacement": padded(values["x"] - values["origin"], 3),
        "deformation": deformation.reshape(count, 9),
        "pressure": -mean,
        "von-mises": np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2))),
        "strain": green.reshape(count, 9)[:, [0, 4, 8, 1, 5, 2]],
        "mass": values["m"],
        "initial-volume": values["V0"],
        "velocity-gradient": rates.reshape(count, 9),
        "density": values["m"] / values["V"],
        "connectivity": np.arange(count),
        **derived(tensor, deviator, deformation),
        "kinetic-energy-density": 0.5 * values["m"] / values["V"] * (values["v"] ** 2).sum(axis=1),
    }


def derived(tensor, deviator, deformation):
    """Derived fields by LAPACK."""
    stresses, directions = np.linalg.eigh(tensor)
    stresses, directions = stresses[:, ::-1], directions[:, :, ::-1]
    largest = np.abs(directions).argmax(axis=1)[:, None]
    directions = directions * np.sign(np.take_along_axis(directions, largest, axis=1))
    second, third = 0.5 * (deviator**2).sum(axis=(1, 2)), np.linalg.det(deviator)
    left, singular, _ = np.linalg.svd(deformation)
    log = (left * np.log(singular)[:, None]) @ np.swapaxes(left, 1, 2)
    deviation = log - np.trace(log, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    trace = np.trace(tensor, axis1=1, axis2=2)
    cosine = np.clip(1.5 * np.sqrt(3.0) * third / second**1.5, -1.0, 1.0)
    return {
        "principal-stress": stresses,
        **{f"principal-direction-{k + 1}": directions[:, :, k] for k in range(3)},
        "max-shear": 0.5 * (stresses[:, 0] - stresses[:, 2]),
        "stress-invariants": np.stack([trace, second, third], axis=1),
        "lode-angle": np.degrees(np.arccos(cosine)) / 3,
        "triaxiality": trace / 3 / np.sqrt(3 * second),
        "volume-ratio": np.linalg.det(deformation),
        "principal-stretch": singular,
        "log-strain": log.reshape(-1, 9)[:, [0, 4, 8, 1, 5, 2]],
        "equivalent-strain": np.sqrt((deviation**2).sum(axis=(1, 2)) * 2 / 3),
    }


def write_frames(directory, comm, count, dimension, empty=(), number=2, gone=(), **output):
    (directory / "frames").mkdir(parents=True, exist_ok=True)
    comm.Barrier()
    sim, values = make_sim(comm, count, dimension, empty, gone)
    frames = Frames(directory, make_case(**output), sim)
    for _ in range(number):
        frames.write(sim)
    frames.finish()
    frames.close()
    return frames, values


class Lines:
    """A simulation of which only the history matters."""

    def __init__(self):
        self.comm, self.step, self.time = Serial(), 0, 0.0
        self.values = np.random.default_rng(3).normal(size=4) * 10.0 ** np.array([0, 200, -300, 17])

    def diagnostics(self):
        return {"time": self.time, "step": self.step, "dt": 0.1 + 0.2} | {
            f"value_{i}": value for i, value in enumerate([*self.values, float("nan"), -0.0])
        }


@contextmanager
def small_disk(place):
    """A file system of one megabyte; only root may mount one, which CI is."""
    if os.geteuid() != 0:
        pytest.skip("needs root to mount a small file system")
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", place], check=True)
    try:
        yield place
    finally:
        subprocess.run(["umount", place], check=True)


def fill_up(place, but=0):
    """Take all space of a file system but so many bytes; returns the file that does."""
    room = os.statvfs(place)
    ballast = place / "ballast"
    ballast.write_bytes(bytes(room.f_bavail * room.f_frsize - but))
    return ballast
