"""Bodies of both configurations in one case: apart as if alone, together by the laws of contact."""

import numpy as np
import pytest
from pydantic import ValidationError
from scenes import SOFT, box, energy, field, finish, scene, start
from tiers import wide

from pgimp.kernels.data.ledger import IMPULSE

pytestmark = pytest.mark.slow(90)

HARD = SOFT | {"young": 1000.0}


def initial(body):
    return body | {"formulation": "total-lagrangian"}


def apart(D, shape, **parts):
    """A body of either configuration, which never meet but lie on the same vertices at times.

    The one in the initial configuration flies through where the other is; both are dragged along.
    """
    across = [[1.0, 3.0], [1.0, 4.0]][: D - 1]
    low, high = [[end[side] for end in across] for side in range(2)]
    flies = [4.0, 1.0, -0.7][:D]
    bodies = {
        "flies": initial(box([1.0, *low], [4.0, *high], flies)),
        "stays": box([5.3, *low], [8.1, *high], [-0.5, 0.3, 0.2][:D], "stiff"),
    }
    grip = {"body": "stays", "region": {"box": {"min": [7.0] + [0.0] * (D - 1),
                                                "max": [9.0] + [8.0] * (D - 1)}}}  # fmt: skip
    push = {"body": "stays", "face": "x-min", "pressure": 0.5}
    stiff = {**(HARD if D > 1 else {"model": "linear-1d", "young": 300.0, "density": 1.0})}
    case = scene(
        D, bodies, cells=[12, 6, 6][:D], shape=shape, end=0.6, step=0.004,
        gravity=[0.3, -0.2, 0.1][:D], contact=[{"bodies": "all", "law": "ignore"}],
        constraints={"grip": grip | {"velocity": [0.4, *[None] * (D - 1)]}},
        tractions={"push": push}, boundaries={"x-max": "slip"}, **parts,
    )  # fmt: skip
    stiff["viscosity"] = {"linear": 0.1, "quadratic": 1.0}
    case["materials"]["stiff"] = stiff
    return case


@pytest.mark.parametrize(("D", "shape", "affine", "more"), [
    pytest.param(1, "fuzzy-nearest", True, {}, marks=pytest.mark.wide),
    (2, "finite-gimp", True, {"volumetric": "b-bar"}),
    pytest.param(3, "gimp", False, {}, marks=pytest.mark.wide),
])  # fmt: skip
def test_bodies_that_do_not_meet_move_as_they_do_alone(D, shape, affine, more):
    """Each body as in a case without the other, also while both are at the same place.

    To rounding: the kernels are others, and products may be contracted otherwise.
    """
    case = apart(D, shape)
    case["method"] |= {"affine": affine, **more}
    together, n = finish(start(case)), {}
    for name in ("flies", "stays"):
        alone = {**case, "bodies": {name: case["bodies"][name]}}
        del alone["contact"]
        if name == "flies":
            alone["constraints"], alone["tractions"] = {}, {}
        sim = finish(start(alone))
        mine = field(together, "body") == list(case["bodies"]).index(name)
        n[name] = int(mine.sum())
        for column in ("x", "v", "F", "sigma", "V"):
            pair = field(together, column)[mine], field(sim, column)
            small = 1e-9 if sim.scene.by_cells else 1e-11
            np.testing.assert_allclose(*pair, rtol=small, atol=small, err_msg=f"{name} {column}")
    assert min(n.values()) > 0


def disks(first, second, cell=0.5, **parts):
    """Two disks of R = 2 that meet askew at a hundredth of the wave speed."""
    bodies = {
        name: {"material": "soft", "region": {"ball": {"centre": [x, y], "radius": 2.0}},
               "velocity": [v, 0.0], "formulation": configuration}
        for name, x, y, v, configuration in (
            ("a", 3.0, 3.0, 0.2, first), ("b", 7.2, 3.4, -0.2, second)
        )
    }  # fmt: skip
    count = [round(12.0 / cell), round(7.0 / cell)]
    return scene(2, bodies, cells=count, cell=cell, end=3.0, step={"courant": 0.3},
                 materials={"soft": HARD}, contact=[{"bodies": ["a", "b"], "friction": 0.3}],
                 **parts)  # fmt: skip


def test_disks_meet_alike_in_any_configuration():
    """Impulse and loss of two bodies in the current one, two in the initial one, one in either."""
    found = {}
    for one, other in (
        ("current", "current"),
        ("initial", "initial"),
        ("initial", "current"),
        ("current", "initial"),
    ):
        sim = start(disks(one, other))
        first = sim.diagnostics()
        last = finish(sim).diagnostics()
        for axis in "xy":
            assert abs(last[f"momentum-{axis}"] - first[f"momentum-{axis}"]) < 1e-13 * last["mass"]
        found[one, other] = (
            last["contact.a+b.normal-impulse"], energy(last) / energy(first),
            last["body.a.momentum-y"],
        )  # fmt: skip
    # Four cells to the radius, and elsewhere on the grid for either: errors of first order.
    impulse, kept, turned = found["current", "current"]
    for mine in found.values():
        assert mine[0] == pytest.approx(impulse, rel=0.05)
        assert kept - 0.12 < mine[1] < 1.0
        assert mine[2] == pytest.approx(turned, rel=0.12)


@pytest.mark.parametrize("slides", ["initial", wide("current")])
def test_a_block_slides_on_a_bed_of_the_other_configuration(slides):
    """g (sin - mu cos): mu 0.3 at 24 degrees."""
    g, slope = (np.sin(np.radians(24.0)), np.cos(np.radians(24.0))), 0.3
    block, bed = box([1.0, 2.0], [5.0, 4.0]), box([0.0, 0.0], [14.0, 2.0])
    block["formulation"] = slides
    bed["formulation"] = "current" if slides == "initial" else "initial"
    case = scene(2, {"block": block, "bed": bed}, cells=[14, 6], end=6.0, step={"courant": 0.3},
                 materials={"soft": HARD | {"young": 20000.0}},
                 boundaries={"y-min": "fixed", "x-min": "slip", "x-max": "slip"},
                 gravity=[g[0], -g[1]],
                 contact=[{"bodies": "all", "friction": slope}])  # fmt: skip
    sim = start(case)
    time, speed = [], []
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        if line["time"] > 1.0:
            time.append(line["time"])
            speed.append(line["body.block.momentum-x"] / line["body.block.mass"])
    assert np.polyfit(time, speed, 1)[0] == pytest.approx(g[0] - slope * g[1], rel=0.03)


@pytest.mark.wide
def test_water_rests_on_a_plate_in_the_initial_configuration():
    """The plate's supports bear the weight of both, and no water comes through."""
    water = {"model": "newtonian", "density": 1.0, "bulk": 400.0, "shear-viscosity": 0.5}
    bodies = {
        "plate": initial(box([0.0, 1.0], [8.0, 3.0], material="soft")),
        "water": box([0.0, 3.0], [8.0, 7.0], material="water"),
    }
    ends = {
        f"{side}": {"body": "plate", "velocity": [0.0, 0.0],
                    "region": {"box": {"min": [x, 1.0], "max": [x + 1.0, 3.0]}}}
        for side, x in (("left", 0.0), ("right", 7.0))
    }  # fmt: skip
    case = scene(2, bodies, cells=[8, 8], end=12.0, step={"courant": 0.3},
                 materials={"soft": HARD | {"young": 5000.0}, "water": water},
                 boundaries={"x-min": "slip", "x-max": "slip"}, gravity=[0.0, -1.0],
                 constraints=ends, contact=[{"bodies": "all"}])  # fmt: skip
    case["method"] |= {"relaxation": 1.0, "volumetric": "b-bar"}
    sim, held = start(case), []
    while not sim.finished:
        sim.advance()
        if sim.time > 8.0:
            line = sim.diagnostics()
            held.append(line["contact.all.normal-impulse"])
    push = (held[-1] - held[0]) / (sim.time - 8.0)
    assert push == pytest.approx(8.0 * 4.0, rel=0.03)  # the water's weight
    mine = field(sim, "body") == 1
    plate = field(sim, "x")[~mine]
    assert field(sim, "x")[mine][:, 1].min() > plate[:, 1].max() - 0.75  # it sags in the middle


def test_bodies_that_meet_without_an_entry_stick_and_are_booked():
    """In the row of pairs that no entry is for: once it was past the end of the books."""
    bodies = {
        "one": initial(box([1.0, 1.0], [4.0, 4.0], [2.0, 0.3])),
        "other": box([4.2, 1.0], [7.0, 4.0]),
    }
    sim = start(scene(2, bodies, cells=[12, 6], end=0.6))
    finish(sim)
    gained = float((field(sim, "m") * field(sim, "v")[:, 0])[field(sim, "body") == 1].sum())
    booked = sim.rank.ledger.contact
    assert booked.shape[1] == 1
    assert -booked[:, 0, IMPULSE].sum() == pytest.approx(gained, rel=1e-9) and gained > 1.0


def test_what_cannot_be_in_one_case_is_said():
    case = disks("initial", "current")
    case["bodies"]["c"] = box([9.0, 5.0], [11.0, 6.0])
    case["bodies"]["d"] = box([1.0, 5.5], [2.0, 6.5])
    case["contact"] = [{"bodies": ["b", "c"]}]
    with pytest.raises(ValidationError, match="'b' and 'c' have an entry, but both are tied to"):
        start(case)
    case["contact"] = [{"bodies": "all"}]
    start(case)


def test_one_particle_a_cell_is_refused():
    """Displacements that alternate from vertex to vertex strain none in the middle of a cell."""
    case = disks("initial", "current")
    case["method"]["particles-per-cell"] = [1, 1]
    with pytest.raises(ValidationError, match="have hourglass modes with one particle along 2"):
        start(case)
    start(disks("current", "current") | {"method": case["method"]})


def test_parallelograms_of_both_configurations_are_refused():
    case = disks("initial", "current")
    case["method"]["shape"] = "cpdi-corners"
    with pytest.raises(ValidationError, match="is for bodies of one configuration, but"):
        start(case)
    start(disks("current", "current") | {"method": case["method"]})


@pytest.mark.wide
@pytest.mark.parametrize("drops", ["initial", "current"])
@pytest.mark.parametrize("size", [(0.5, 0.25), (1.0, 0.1)])
def test_a_drop_does_not_fall_through_a_slab(drops, size):
    """Less than one particle, or a skin: at no vertex it fills a tenth of the neighbourhood."""
    bodies = {
        "slab": initial(box([0.0, 2.0], [8.0, 4.0])),
        "drop": box([4.0, 4.5], [4.0 + size[0], 4.5 + size[1]], [0.0, -1.0])
        | {"formulation": drops},
    }
    held = {"body": "slab", "velocity": [0.0, 0.0]}
    ends = {
        side: held | {"region": {"box": {"min": [x, 2.0], "max": [x + 1.0, 4.0]}}}
        for side, x in (("left", 0.0), ("right", 7.0))
    }
    case = scene(2, bodies, end=3.0, step={"courant": 0.3}, materials={"soft": HARD},
                 boundaries={"x-min": "slip", "x-max": "slip"}, constraints=ends,
                 contact=[{"bodies": "all"}])  # fmt: skip
    sim = finish(start(case))
    drop = field(sim, "body") == 1
    assert field(sim, "x")[drop, 1].min() > 3.5
    # It comes to rest at least, and leaves again at most as fast as it came.
    push = sim.diagnostics()["contact.all.normal-impulse"] / field(sim, "m")[drop].sum()
    assert 0.9 < push < 2.0


def turned(formulation, volumes, bodies="ab", **parts):
    """Two squares far apart that turn and swell, some steps later."""
    each = {
        "a": box([2.0, 2.0], [5.0, 5.0], {"rotation": {"about": [3.3, 3.0], "rate": 0.7}}),
        "b": box([8.0, 2.0], [11.0, 5.0], {"rotation": {"about": [9.3, 3.0], "rate": 0.7}}),
    }
    data = scene(2, {n: each[n] for n in bodies}, cells=[14, 8], step=0.01, end=0.5, **parts)
    data["materials"]["soft"] |= {"poisson": 0.49}
    for name in bodies:
        data["bodies"][name] |= {"formulation": formulation} | volumes.get(name, {})
    sim = finish(start(data))
    return field(sim, "x"), field(sim, "sigma")


MEAN, OWN = {"volumetric": "b-bar"}, {"volumetric": "pointwise"}


@pytest.mark.parametrize("formulation", ["updated-lagrangian", "total-lagrangian"])
def test_each_body_moves_as_alone(formulation):
    both = turned(formulation, {"a": MEAN})
    for bodies, rows, volumes in (("a", slice(0, 36), MEAN), ("b", slice(36, 72), OWN)):
        alone = turned(formulation, {bodies: volumes}, bodies)
        for ours, own in zip(both, alone, strict=True):
            assert np.allclose(ours[rows], own, rtol=1e-9, atol=1e-9)
    assert not np.allclose(both[1][:36], both[1][36:], rtol=1e-3)  # volumes matter here
