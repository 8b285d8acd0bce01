"""Books of bodies at rest, and of friction, are the same in both configurations."""

import numpy as np
import pytest
from scenes import box, field, finish, scene, start
from tiers import wide

pytestmark = pytest.mark.slow(40)

CONFIGURATIONS = ("current", "initial")
SUPPORTS = ("wall", "rough", "fixed", "rigid", "body")
#: Height of the upper face of what is below.
LEVEL = 1.0


def lying(dimension, below, configuration, gravity=None, **parts):
    """A block of three cells on something; gravity sets in at once."""
    up, low, high = dimension - 1, [1.0] * (dimension - 1), [4.0] * (dimension - 1)
    face = f"{'xyz'[up]}-min"
    base = LEVEL if below in ("rigid", "body") else 0.0
    block = box([*low, base], [*high, base + 3.0]) | {"formulation": configuration}
    bodies, more = {"block": block}, {}
    if below == "rigid":
        deep = {"box": {"min": [-2.0] * up + [-3.0], "max": [9.0] * up + [LEVEL]}}
        bodies["floor"] = {"rigid": {}, "region": deep}
    elif below == "body":
        slab = box([0.0] * dimension, [6.0] * up + [LEVEL])
        bodies["slab"] = slab | {"formulation": configuration}
        more["boundaries"] = {face: "fixed"}
    else:
        rough = {"unilateral": {"friction": 0.4}}
        more["boundaries"] = {face: {"wall": "unilateral", "rough": rough}.get(below, below)}
    if below in ("rigid", "body"):
        more["contact"] = [{"bodies": "all", "friction": 0.3}]
    case = scene(dimension, bodies, cells=[6] * dimension,
                 gravity=[0.0] * up + [-1.0] if gravity is None else gravity,
                 end=parts.pop("end", 0.6), **more, **parts)  # fmt: skip
    return case


def transferred(case, transfer):
    case["method"] |= {"flip": {}, "pic": {"relaxation": 1000.0}, "affine": {"affine": True}}[
        transfer
    ]
    return case


CROSSED = [
    *[(2, below, "gimp", "flip") for below in SUPPORTS],
    wide(2, "rigid", "gimp", "pic"),
    (2, "rigid", "gimp", "affine"),
    (2, "rough", "cpdi", "flip"),
    wide(2, "rough", "bspline-quadratic", "flip"),
    (1, "wall", "gimp", "flip"),
    wide(3, "rough", "gimp", "flip"),
]


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
@pytest.mark.parametrize(("dimension", "below", "shape", "transfer"), CROSSED)
def test_what_is_at_rest_below_works_nothing(configuration, dimension, below, shape, transfer):
    """So external work is gravity's, weight times way of each particle, after every step.

    In the initial configuration contact stops bodies after gravity has acted on them: in a step at
    rest nothing is worked, though all vertices had m g dt before.
    """
    case = lying(dimension, below, configuration, shape=shape)
    case = transferred(case, transfer)
    if dimension > 1 and below in ("rough", "rigid"):
        case["gravity"][0] = 0.3
    sim = start(case)
    gravity = np.array(case["gravity"])
    weight = field(sim, "m")[:, None] * gravity
    first = field(sim, "x")
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        work = float((weight * (field(sim, "x") - first)).sum())
        # Rounding of the way of up to 300 particles.
        assert line["external-work"] == pytest.approx(work, rel=1e-11, abs=1e-12)
    assert work > 0.01


@pytest.mark.parametrize("below", ["wall", "rough", "rigid"])
def test_a_block_at_rest_works_nothing(below):
    """Of 27 that gravity could give by the block's height, a millionth in 200 steps at rest."""
    case = lying(2, below, "initial", end=30.0, gravity=[0.0, -1.0])
    case["materials"]["soft"]["viscosity"] = {"linear": 4.0, "quadratic": 0.0}  # it comes to rest
    sim = start(case)
    while sim.time < 28.0:
        sim.advance()
    before = sim.diagnostics()
    after = finish(sim).diagnostics()
    # Without rest in the books gravity would work g dt/2 a step: 0.18 here. What is left is the
    # thousandth of an impulse at which contact's sweeps end: the block sinks by so much.
    for name in ("external-work", "dissipated-energy"):
        assert abs(after[name] - before[name]) < 1e-4


@pytest.mark.parametrize("shape", ["gimp", "cpdi"])
@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_heat_of_a_wall_is_force_times_way(configuration, shape):
    """A block slides on a rough wall: heat and what is left are gravity's work."""
    slope = np.radians(24.0)
    gravity = [float(np.sin(slope)), -float(np.cos(slope))]
    body = box([1.0, 0.0], [5.0, 2.0]) | {"formulation": configuration}
    case = scene(2, body, cells=[14, 5], shape=shape, end=4.0, step={"courant": 0.3},
                 gravity=gravity)  # fmt: skip
    case["boundaries"] = {"y-min": {"unilateral": {"friction": 0.3}}}
    case["materials"]["soft"] |= {"young": 1000.0}
    sim = start(case)
    while sim.time < 1.0:
        sim.advance()
    begin = sim.diagnostics()
    end = finish(sim).diagnostics()
    gained = {name: end[name] - begin[name] for name in end}
    way = gained["body.body.centre-x"]
    heat = gained["wall.y-min.friction-heat"]
    press = end["reaction.y-min-y"]
    # The bottom, which slides, swings about the mean way of the block. In the initial configuration
    # the swing lasts: the block slides farther while less presses it, and patches of its surface
    # that come to the wall again lose in impacts what is among no heat.
    lasts = configuration == "initial"
    assert heat == pytest.approx(0.3 * press * way, rel=0.15 if lasts else 0.03)
    work = 8.0 * (gravity[0] * way + gravity[1] * gained["body.body.centre-y"])
    assert gained["external-work"] == pytest.approx(work, rel=1e-9)
    kept = gained["kinetic-energy"] + gained["strain-energy"]
    lost = heat + gained["wall.y-min.impact-loss"]
    assert kept + lost == pytest.approx(work, rel=0.05 if lasts else 0.03)
    assert gained["dissipated-energy"] == pytest.approx(lost, rel=0.08 if lasts else 0.06)
    slid = 0.3 * 8.0 * -gravity[1] * way  # by its weight
    assert gained["dissipated-energy"] == pytest.approx(slid, rel=0.03)


def test_walls_that_only_hold_a_component_take_nothing():
    """Columns belong to walls that let go or hold every component; others say what they work."""
    case = scene(2, box([0.0, 0.0], [2.0, 2.0]), end=0.01,
                 boundaries={"x-min": "slip", "y-min": "unilateral", "x-max": "fixed"})  # fmt: skip
    names = [name for name in start(case).diagnostics() if name.startswith("wall.")]
    assert names == ["wall.y-min.friction-heat", "wall.x-max.impact-loss", "wall.y-min.impact-loss"]
