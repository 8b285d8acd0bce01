"""Loads on surfaces against forces of the history, weights, distances, heat, and Hertz."""

import h5py
import numpy as np
import pytest
from pressed_blocks import pressed_disk, resting_block, sliding_block
from run_files import digests
from scenes import write_case

import pgimp
from pgimp.cli import main
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(60)


class Surfaces:
    """A frame of surfaces."""

    def __init__(self, run, number):
        path = sorted((run.path / "frames").glob("surface-*.h5"))[number]
        with h5py.File(path) as file:
            self.names = list(file.attrs["bodies"])
            self.values = {name: file[name][:] for name in file if name != "VTKHDF"}
        self.x = self["position"][self["connectivity"]].mean(axis=1)

    def __getitem__(self, name):
        return self.values[name]

    def own(self, body):
        return self["body"] == self.names.index(body)

    def total(self, name, body):
        """Integral of a quantity over the surface of a body."""
        mine, area = self.own(body), self["area"]
        values = self[name] if self[name].ndim == 1 else self[name].T
        return (values * area)[..., mine].sum(axis=-1)


def run_of(case, folder):
    write_case(folder / "case.yaml", case)
    assert main([str(folder / "case.yaml"), "-o", str(folder / "out"), "--quiet"]) == 0
    return pgimp.open(folder / "out")


@pytest.fixture(scope="module")
def resting(tmp_path_factory):
    return run_of(resting_block(), tmp_path_factory.mktemp("resting"))


@pytest.fixture(scope="module")
def sliding(tmp_path_factory):
    return run_of(sliding_block(), tmp_path_factory.mktemp("sliding"))


def test_tractions_add_up_to_the_force_of_the_pair_and_the_weight(resting):
    history = resting.history
    force = np.array([history["contact.block+plate-x"], history["contact.block+plate-y"]])
    weight = history["body.block.mass"][0] * 10.0
    for number in (1, 2):
        frame = Surfaces(resting, number)
        for body, sign in (("block", 1.0), ("plate", -1.0)):
            found = sign * frame.total("traction", body)[:2]
            assert np.abs(found - force[:, number]).max() < 1e-10 * weight
        pressed = frame.total("contact-pressure", "block")
        mine, pressure = frame.own("block"), frame["contact-pressure"] * frame["area"]
        along = -(pressure[:, None] * frame["normal"])[mine].sum(axis=0)
        assert pressed == pytest.approx(along[1], rel=1e-5)  # normals turn by thousandths
        assert frame.total("contact-pressure", "plate") == pytest.approx(pressed, rel=1e-10)
    assert force[1, 2] == pytest.approx(weight, rel=1e-3)


def test_moment_and_centre_of_pressure(resting):
    frame, history = Surfaces(resting, 2), resting.history
    traction = frame["traction"] * frame["area"][:, None]
    weight = history["body.block.mass"][0] * 10.0
    moment = history["contact.block+plate.moment-z"][-1]
    for body, sign in (("block", 1.0), ("plate", -1.0)):
        mine = frame.own(body)
        found = sign * np.cross(frame.x, traction)[mine][:, 2].sum()
        # On the plate a load goes to the facets beside a place, not to the place.
        assert found == pytest.approx(moment, rel=1e-8 if body == "block" else 1e-4)
    centre = history["contact.block+plate.centre-x"][-1]
    assert centre == pytest.approx(6.3, abs=2e-3)  # below the centre of mass
    assert moment == pytest.approx(weight * centre, rel=1e-3)
    assert history["contact.block+plate.centre-y"][-1] == pytest.approx(3.0, abs=1e-3)
    assert np.isnan(history["contact.block+plate.centre-x"][0])
    assert history["contact.block+plate.area"][-1] == pytest.approx(6.0, rel=1e-6)


def test_pressure_ends_at_an_edge(tmp_path):
    """The part next to it may be borne by the plate's corner, whose facets look as well."""
    run = run_of(resting_block(edge=8.7), tmp_path)
    frame = Surfaces(run, 2)
    beyond = frame.own("block") & (frame.x[:, 0] > 8.7 + 0.07)
    assert (frame["contact-pressure"][beyond] == 0.0).all()
    assert np.isnan(frame["gap"][beyond]).all()
    under = frame.own("block") & (frame.x[:, 1] < 3.01) & (frame.x[:, 0] < 8.6)
    assert np.abs(frame["gap"][under]).max() < 0.01
    assert 5.0 < run.history["contact.block+plate.area"][-1] < 5.4 + 0.13
    force = run.history["contact.block+plate-y"][-1]
    assert frame.total("traction", "block")[1] == pytest.approx(force, rel=1e-10)


def test_slip_is_the_distance_and_wear_the_heat_of_friction(sliding):
    history = sliding.history
    for number in (1, 2, 3, 4):
        frame = Surfaces(sliding, number)
        heat = history["contact.block+plate.friction-heat"][number]
        assert heat > 0.0
        for body in ("block", "plate"):
            assert frame.total("wear-work", body) == pytest.approx(heat, rel=1e-10)
    time = history["time"]
    distance = history["body.block.centre-x"] - 10.3 + time
    block = frame.own("block") & (frame["slip"] > 0.0)
    assert block.sum() >= 40
    assert np.median(frame["slip"][block]) == pytest.approx(distance[-1], rel=0.03)
    # The plate has slid along the block only where that was.
    plate = frame.own("plate") & (frame["slip"] > 0.0)
    assert frame.x[plate, 0].min() > 7.3 - time[-1] - 0.2
    assert frame["slip"][plate].max() < frame["slip"][block].max() * 1.001
    # Tangential traction is the coefficient times the pressure.
    pressed = frame.total("contact-pressure", "block")
    assert abs(frame.total("traction", "block")[0]) == pytest.approx(0.2 * pressed, rel=0.02)


def test_hertz(tmp_path):
    """Of a disk with 16 cells in its radius, 2.6 cells in the half-width.

    The profile is off by .084 of the greatest pressure, rms; .26 before it is made smooth, as the
    forces of neighbouring patches alternate.
    """
    R, stiff = 16.0, 1000.0 / 0.91
    force = 0.02 * stiff * R
    run = run_of(pressed_disk(R, 60.0, force / (np.pi * R * R)), tmp_path)
    frame = Surfaces(run, -1)
    half = np.sqrt(4.0 * force * R / (np.pi * stiff))
    mine = frame.own("block") & (frame.x[:, 1] < R)
    x, area = (frame.x[:, 0] - R - 4.13)[mine], frame["area"][mine]
    pressure = frame["contact-pressure"][mine]
    load, under = pressure * area, np.abs(x) < 1.2 * half
    assert load.sum() == pytest.approx(force, rel=1e-3)
    assert abs(load @ x) < 0.02 * force * half
    assert 2.0 * np.sqrt(load @ x**2 / force) == pytest.approx(half, rel=0.1)
    assert run.history["contact.block+plate.area"][-1] == pytest.approx(2.0 * half, rel=0.03)
    exact = np.sqrt(np.maximum(0.0, 1.0 - (x / half) ** 2))
    off = pressure / (2.0 * force / (np.pi * half)) - exact
    assert np.sqrt(area[under] @ off[under] ** 2 / area[under].sum()) < 0.09


def test_loads_last_where_a_run_goes_on_into_a_stage(tmp_path):
    """From the checkpoint at its end no step is taken in the stage that they are of."""
    options = {"comm": Serial(), "quiet": True}
    case = sliding_block()
    region = {"box": {"min": [18.0, 4.0], "max": [20.0, 6.0]}}
    case["bodies"]["goes"] = case["bodies"]["block"] | {"region": region}
    case["time"]["end"] = 0.02
    stage = {"name": "later", "end": 0.03, "remove": ["goes"]}
    staged = case | {"time": case["time"] | {"stages": [stage]}}
    together = pgimp.run(staged, output=tmp_path / "together", **options)
    for resume, each in enumerate((case, staged)):
        parts = pgimp.run(each, output=tmp_path / "parts", resume=bool(resume), **options)
    assert digests(parts.path) == digests(together.path)
    assert Surfaces(together, -1).total("slip", "block") > 0.0
