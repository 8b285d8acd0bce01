"""Loads on surfaces before material in the current configuration, against the history's forces."""

import h5py
import numpy as np
import pytest
from scenes import SOFT, box, scene, start, write_case

import pgimp
from pgimp.cli import main
from pgimp.physics.columns import SURFACE

pytestmark = pytest.mark.slow(40)


def run_of(folder, first, second, velocity, friction):
    """A block on another one, which is held below; one of them has facets."""
    bodies = {
        "bed": box([1.0, 0.0], [13.0, 3.0]) | {"formulation": first},
        "block": box([3.3, 3.0], [9.3, 5.0], velocity) | {"formulation": second},
    }
    moving = velocity[0] != 0.0
    case = scene(
        2, bodies, cells=[14, 8], end=1.0 if moving else 8.0, step={"courant": 0.3},
        materials={"soft": SOFT | {"young": 1000.0}}, gravity=[0.0, -10.0],
        contact=[{"bodies": ["block", "bed"], "friction": friction}],
        damping={"mass": 0.2 if moving else 4.0}, boundaries={"y-min": "fixed"},
        output={"every": 0.5 if moving else 4.0, "surface": [*SURFACE]},
        history={"every": 0.5 if moving else 4.0},
    )  # fmt: skip
    write_case(folder / "case.yaml", case)
    assert main([str(folder / "case.yaml"), "-o", str(folder / "out"), "--quiet"]) == 0
    run, frames = pgimp.open(folder / "out"), []
    for path in sorted((folder / "out" / "frames").glob("surface-*.h5")):
        with h5py.File(path) as file:
            frames.append({name: file[name][:] for name in file if name != "VTKHDF"})
            frames[-1]["x"] = frames[-1]["position"][frames[-1]["connectivity"]].mean(axis=1)
    return run.history, frames


@pytest.mark.parametrize(
    "kinds",
    [("updated-lagrangian", "total-lagrangian"), ("total-lagrangian", "updated-lagrangian")],
)
def test_a_resting_block_presses_with_its_weight(kinds, tmp_path):
    """At the middle below its centre of mass; where nothing is before a facet there is no gap."""
    history, frames = run_of(tmp_path, *kinds, [0.0, 0.0], 0.0)
    weight, frame = 10.0 * history["body.block.mass"][0], frames[-1]
    sign = 1.0 if kinds[1] == "total-lagrangian" else -1.0
    area, pressure = frame["area"], frame["contact-pressure"]
    traction = (frame["traction"] * area[:, None]).sum(axis=0)
    force = history["contact.block+bed-y"][-1]
    assert sign * traction[1] == pytest.approx(force, rel=1e-9)
    assert force == pytest.approx(weight, rel=2e-3)
    assert pressure @ area == pytest.approx(force, rel=1e-3)
    middle = (pressure * area) @ frame["x"][:, 0] / (pressure @ area)
    assert middle == pytest.approx(history["contact.block+bed.centre-x"][-1], rel=2e-3)
    assert middle == pytest.approx(6.3, abs=0.02)
    moment = np.cross(frame["x"], frame["traction"] * area[:, None])[:, 2].sum()
    assert sign * moment == pytest.approx(history["contact.block+bed.moment-z"][-1], rel=2e-3)
    under = (np.abs(frame["x"][:, 1] - 3.0) < 0.2) & (np.abs(frame["x"][:, 0] - 6.3) < 2.5)
    under &= np.abs(frame["normal"][:, 1]) > 0.9
    assert np.abs(frame["gap"][under]).max() < 0.03
    away = np.abs(frame["normal"][:, 1]) < 0.1
    assert np.isnan(frame["gap"][away & (frame["x"][:, 1] > 3.7)]).all()


@pytest.mark.parametrize("kinds", [("updated-lagrangian", "total-lagrangian")])
def test_slip_is_the_way_and_wear_the_heat_of_friction(kinds, tmp_path):
    history, frames = run_of(tmp_path, *kinds, [3.0, 0.0], 0.2)
    frame, heat = frames[-1], history["contact.block+bed.friction-heat"][-1]
    assert frame["wear-work"] @ frame["area"] == pytest.approx(heat, rel=1e-9)
    slid = frame["slip"][frame["slip"] > 0.0]
    way = history["body.block.centre-x"][-1] - history["body.block.centre-x"][0]
    assert slid.max() == pytest.approx(way, rel=0.1)
    assert np.median(slid) > 0.7 * way  # some have not pressed all the time
    tangential = abs((frame["traction"][:, 0] * frame["area"]).sum())
    assert tangential == pytest.approx(0.2 * (frame["contact-pressure"] @ frame["area"]), rel=0.12)


def test_gaps_are_found_where_vertices_are_after_they_have_changed_ranks():
    """A frame may come between a change of slabs and the next step."""
    bodies = {
        "bed": box([1.0, 0.0], [13.0, 3.0]),
        "block": box([3.3, 3.0], [9.3, 5.0]) | {"formulation": "total-lagrangian"},
    }
    sim = start(
        scene(2, bodies, cells=[14, 8], step={"courant": 0.3}, materials={"soft": SOFT},
              gravity=[0.0, -10.0], contact=[{"bodies": ["block", "bed"], "friction": 0.0}],
              damping={"mass": 4.0}, boundaries={"y-min": "fixed"},
              output={"every": 4.0, "surface": [*SURFACE]})
    )  # fmt: skip
    sim.advance()
    contact, near = sim.rank.contact, sim.rank.contact._material.near
    before = contact.material_gaps(sim.rank, contact.rigid_bodies)
    contact._material.near = near._replace(records=near.records + 10**6)
    contact.moved()
    after = contact.material_gaps(sim.rank, contact.rigid_bodies)
    assert len(before[0]) > 3
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)
