"""Rigid bodies in periodic domains: they meet material across the seam as anywhere.

That the number of ranks and a resume change no bit: tests/proofs/test_ranks.py.
"""

import numpy as np
import pytest
from scenes import box, field, finish, scene, start

from pgimp.errors import CaseError

pytestmark = pytest.mark.slow(60)

CELL = 0.25
JOINED = {face: "periodic" for face in ("x-min", "x-max", "y-min", "y-max")}


def ball(centre, radius, rigid, **parts):
    """A round rigid body."""
    return {"rigid": rigid, "region": {"ball": {"centre": centre, "radius": radius}}} | parts


def trio(shift=0, axis=0, origin=(4.0, 4.0)):
    """A block between a wheel that turns and moves, and a ball that flies; all moved by cells.

    All coordinates are between 4 and 8. The domain may begin elsewhere.
    """
    move = [0.0, 0.0]
    move[axis] = shift * CELL
    at = lambda x, y: [x + move[0], y + move[1]]  # noqa: E731
    bodies = {
        "block": box(at(4.5, 4.75), at(5.25, 5.5), [2.0, 0.5]),
        "wheel": ball(
            at(5.75, 5.0), 0.375,
            {"velocity": [-1.0, 0.0], "rotation": {"about": at(5.75, 5.0), "rate": 3.0}},
        ),
        "stone": ball(at(4.125, 5.0), 0.3125, {"density": 2.0}, velocity=[3.0, 0.0]),
    }  # fmt: skip
    case = scene(
        2, bodies, cells=[12, 12], cell=CELL, end=0.5, step=2.0**-8, gravity=[0.5, 0.25],
        boundaries=JOINED, contact=[{"bodies": "all", "friction": 0.3}],
        output={"fields": ["unwrapped"]},
    )  # fmt: skip
    case["grid"]["origin"] = [*origin]
    return case


def states(sim):
    """Particles and the free body, positions with their turns; forces on both rigid bodies."""
    x = field(sim, "x") + field(sim, "winding") * sim.scene.domain.periods
    (state,) = sim.rank.free.states
    line = sim.diagnostics()
    names = [f"rigid.{name}.{what}" for name in ("wheel", "stone")
             for what in ("force-x", "force-y", "work")]  # fmt: skip
    found = {"x": x, "centre": np.array(state.centre[:2]), "spin": np.array(state.spin)}
    found["momentum"], found["force"] = np.array(state.momentum), np.array([line[n] for n in names])
    return found | {name: field(sim, name) for name in ("v", "F", "sigma")}


def moved(case):
    """The states at the end of a scene."""
    sim = start(case)
    sim.diagnostics()
    return states(finish(sim))


@pytest.fixture(scope="module")
def wanted():
    """The states at the end; the bodies do meet."""
    found = moved(trio())
    assert (abs(found["force"]) > 1e-3).all()
    return found


@pytest.mark.parametrize("shift", [1, 2])
def test_where_the_seam_is_changes_no_bit(wanted, shift):
    """It is moved by cells along x: first through the ball, then to where ball and block meet.

    Books are sums over the planes of the domain, and differ by rounding.
    """
    found = moved(trio(origin=(4.0 + shift * CELL, 4.0)))
    for name, values in wanted.items():
        if name == "force":
            np.testing.assert_allclose(found[name], values, rtol=1e-13)
        else:
            np.testing.assert_array_equal(found[name], values, name)


@pytest.mark.parametrize(("shift", "axis"), [(7, 0), (6, 1)])
def test_a_scene_that_is_moved_differs_by_rounding(wanted, shift, axis):
    """Distances and inertia of a round body are computed with its coordinates."""
    found = moved(trio(shift, axis))
    for name in ("x", "centre"):
        found[name] = found[name] - shift * CELL * np.eye(2)[axis]
    for name, values in wanted.items():
        np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-9, err_msg=name)


def test_momentum_is_constant_with_a_free_body():
    """Of the particles and the body together, to rounding, as they meet across the seam."""
    case = trio(7)
    del case["bodies"]["wheel"], case["gravity"]
    sim = start(case)

    def whole():
        line, (state,) = sim.diagnostics(), sim.rank.free.states
        return [line[f"momentum-{axis}"] + p for axis, p in zip("xy", state.momentum, strict=False)]

    begun, old = whole(), sim.rank.free.states[0]
    finish(sim)
    assert whole() == pytest.approx(begun, abs=1e-13)
    assert abs(sim.rank.free.states[0].momentum[0] - old.momentum[0]) > 0.1


def test_a_ball_goes_round_as_in_a_long_domain():
    """Its position and angle in the history go on; in the long domain it comes to no face."""

    def roll(cells, boundaries):
        bodies = {
            "belt": box([1.0, 1.0], [3.0, 2.0], [9.0, 0.0]),
            "roll": ball([4.5, 1.6], 0.75, {"density": 1.5}, velocity=[6.0, 0.0]),
        }
        return finish(start(scene(
            2, bodies, cells=[cells, 6], end=1.5, step=0.01, boundaries=boundaries,
            contact=[{"bodies": "all", "friction": 0.4}],
        )))  # fmt: skip

    near = roll(9, {"x-min": "periodic", "x-max": "periodic"})
    far = roll(30, {})
    (mine,), (theirs,) = near.rank.free.states, far.rank.free.states
    assert theirs.centre[0] > 12.0 and abs(theirs.momentum[0] - 6.0 * 1.5 * np.pi * 0.75**2) > 1.0
    np.testing.assert_allclose(mine.numbers[:16], theirs.numbers, rtol=0, atol=1e-9)
    assert mine.home[0] == pytest.approx(mine.centre[0] - 9.0, abs=1e-12)
    lines = near.diagnostics(), far.diagnostics()
    names = [n for n in lines[0] if n.startswith("rigid.roll") and "penetrating" not in n]
    for name in names:
        assert lines[0][name] == pytest.approx(lines[1][name], abs=1e-9), name


@pytest.mark.parametrize(
    ("region", "rigid", "words"),
    [
        ({"box": {"min": [-1.0, 0.0], "max": [13.0, 1.0]}}, {}, "is up to 14 long along x, and"),
        ({"box": {"min": [1.0, 0.0], "max": [9.5, 1.0]}}, {}, "is up to 8.5 long along x, and"),
        (
            {"box": {"min": [1.0, 0.0], "max": [7.0, 6.0]}}, {"density": 1.0},
            "long along x as it turns, and",
        ),
        ({"box": {"min": [9.0, 2.0], "max": [14.0, 4.0]}}, {}, "'block' reaches 1 into the rigid"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(region, rigid, words):
    case = scene(
        2, {"block": box([1.0, 2.0], [2.5, 4.0]), "die": {"rigid": rigid, "region": region}},
        cells=[12, 8], boundaries={"x-min": "periodic", "x-max": "periodic"},
    )  # fmt: skip
    with pytest.raises(CaseError) as error:
        start(case)
    assert words in str(error.value) and "bodies.die.region" in str(error.value)
