"""Scenes of all kinds whose bodies meet by their surfaces: momenta, energy, depth."""

import numpy as np
import pytest
from scenes import SOFT, box, energy, scene, start

pytestmark = pytest.mark.slow(60)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}
PAIR = {"soft": SOFT, "stiff": SOFT | {"young": 400.0, "density": 2.0}}


def ball(centre, radius, velocity=None, material="soft"):
    """A round body, exact to its surface."""
    region = {"ball": {"centre": list(centre), "radius": radius}}
    body = {"material": material, "region": region} | EXACT
    return body if velocity is None else body | {"velocity": list(velocity)}


def run(case):
    """Lines of the history of all steps, and the least gap of a facet, in cells."""
    sim, deep = start(case), 0.0
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        gaps = sim.rank.contact._proximity.candidates["gap"]
        deep = min(deep, gaps.min(initial=0.0))
        lines.append(sim.diagnostics())
    return lines, deep / min(sim.scene.domain.frame.cell)


def require_kept(lines, meet=True):
    """Momenta are kept to rounding, and nothing gives energy: by friction it becomes heat."""
    first, last = lines[0], lines[-1]
    size = 1.0 + energy(first)
    for name in first:
        if name.startswith(("momentum", "angular-momentum")):
            assert abs(last[name] - first[name]) < 1e-11 * size, name
    for line in lines:
        heat = sum(line[name] for name in line if name.endswith("friction-heat"))
        assert energy(line) + heat < energy(first) * (1.0 + 0.01)
    met = sum(last[name] for name in last if name.endswith("normal-impulse")) > 0.0
    assert met or not meet


def random_scene(seed, D):
    """Round bodies and boxes that fly at each other; cells with unequal sides, too."""
    draw = np.random.default_rng(seed)
    sides = [1.0] * D if draw.random() < 0.5 else draw.choice([1.0, 0.75, 1.25], D).tolist()
    cells = [14, 14] if D == 2 else [9, 7, 7]
    whole, bodies, taken = np.array(cells) * sides, {}, []
    while len(bodies) < (3 if D == 2 else 2):
        size = draw.uniform(2.2, 4.0) if D == 2 else draw.uniform(2.4, 3.0)
        centre = draw.uniform(0.6 * size + 0.1, whole - 0.6 * size - 0.1)
        if any(np.linalg.norm(centre - other) < 0.75 * (size + its) for other, its in taken):
            continue
        taken.append((centre, size))
        way = 0.5 * whole - centre
        velocity = (way / np.linalg.norm(way) * draw.uniform(0.5, 2.0)).tolist()
        material = ("soft", "stiff")[draw.integers(2)]
        if draw.random() < 0.5:
            body = ball(centre, 0.5 * size, velocity, material)
        else:
            half = 0.5 * size * draw.uniform(0.7, 1.0, D)
            body = box(centre - half, centre + half, velocity, material) | EXACT
        bodies["abc"[len(bodies)]] = body
    return scene(
        D,
        bodies,
        cells=cells,
        cell=sides,
        per_cell=draw.choice([2, 3], D).tolist(),
        materials=PAIR,
        step={"courant": 0.3},
        end=2.5 if D == 2 else 1.5,
        contact=[{"bodies": "all", "friction": float(draw.choice([0.0, 0.3]))}],
    )


@pytest.mark.parametrize("seed", [0, 1, 2, *(pytest.param(n, marks=pytest.mark.wide)
                                             for n in range(3, 40))])  # fmt: skip
def test_random_bodies_keep_momenta_and_energy(seed):
    require_kept(run(random_scene(seed, 2))[0], seed < 3)


@pytest.mark.wide
@pytest.mark.parametrize("seed", range(6))
def test_random_bodies_in_space_keep_momenta_and_energy(seed):
    require_kept(run(random_scene(seed, 3))[0], False)


def test_places_far_from_a_cell_are_none():
    """Coarse round bodies, of which two pass through each other: angular momentum is exact."""
    bodies = {
        "a": ball([4.0, 4.0], 1.5, [0.5, -2.0]),
        "b": ball([4.0, 1.5], 0.9, material="stiff"),
        "c": ball([8.0, 2.0], 0.9, [-2.0, 0.0]),
    }
    case = scene(2, bodies, cells=[11, 9], materials=PAIR, step={"courant": 0.3}, end=2.0,
                 contact=[{"bodies": ["a", "b"], "law": "ignore"},
                          {"bodies": ["a", "c"], "friction": 0.2},
                          {"bodies": ["b", "c"], "friction": 0.2}])  # fmt: skip
    lines, _ = run(case)
    require_kept(lines)


def test_a_corner_does_not_enter_between_two_normals():
    """Both sides of a corner that presses into a curved surface are kept out."""
    balls = [{"ball": {"centre": [5.63, 6.09], "radius": 2.28}},
             {"ball": {"centre": [7.0, 6.09], "radius": 1.0}}]  # fmt: skip
    bodies = {
        "ring": {"material": "soft", "region": {"difference": balls}, "velocity": [0.68, 0.45]}
        | EXACT,
        "block": box([9.84, 10.37], [12.88, 12.6], [-1.12, -1.15], "stiff") | EXACT,
    }
    case = scene(2, bodies, cells=[14, 14], per_cell=3, materials=PAIR, step={"courant": 0.5},
                 end=3.0, contact=[{"bodies": "all"}])  # fmt: skip
    lines, deep = run(case)
    assert -0.06 < deep < 0.0
    require_kept(lines)


def test_a_rigid_body_beyond_the_domain_is_felt():
    """What the block has lost is what the contact has given; it comes back slower than it came."""
    bodies = {
        "block": box([6.1, 2.2], [9.3, 5.4], [3.0, 0.0]) | EXACT,
        "wall": {"rigid": {}, "region": {"box": {"min": [12.0, -3.0], "max": [14.0, 12.0]}}},
    }
    lines, deep = run(
        scene(2, bodies, cells=[11, 9], step={"courant": 0.3}, end=3.0,
              contact=[{"bodies": ["block", "wall"]}])
    )  # fmt: skip
    first, last = lines[0], lines[-1]
    lost = first["momentum-x"] - last["momentum-x"]
    assert 1.5 * first["momentum-x"] < lost < 2.0 * first["momentum-x"]
    np.testing.assert_allclose(last["contact.block+wall.normal-impulse"], lost, rtol=1e-12)
    assert energy(last) < energy(first)
    assert deep > -0.06  # what the compliance of patches takes at a third of the waves' speed


def test_free_rigid_bodies_take_what_others_lose():
    """A block flies at a free rigid ball off its centre: momenta of both, to rounding."""
    bodies = {
        "block": box([1.3, 1.9], [4.4, 4.6], [2.0, 0.0]) | EXACT,
        "ball": {"rigid": {"density": 2.0}, "velocity": [-0.5, 0.0],
                 "region": {"ball": {"centre": [6.6, 4.4], "radius": 1.6}}},
    }  # fmt: skip
    case = scene(2, bodies, cells=[11, 9], step={"courant": 0.3}, end=2.0,
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip
    lines, deep = run(case)
    first, last = lines[0], lines[-1]
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        parts = [line[name] + line[f"rigid.ball.{name}"] for line in (first, last)]
        assert abs(parts[1] - parts[0]) < 1e-11, name
    whole = [energy(line) + line["rigid.ball.kinetic-energy"] for line in lines]
    np.testing.assert_allclose(
        first["rigid.ball.kinetic-energy"] - last["rigid.ball.kinetic-energy"],
        last["rigid.ball.work"], rtol=1e-9,
    )  # fmt: skip
    assert max(whole) < whole[0] * (1.0 + 1e-3) and deep > -0.05


@pytest.mark.parametrize("stops", [0.0, 1.2])
def test_a_tool_that_slows_down_within_a_few_steps_does_not_sink_in(stops):
    """It moves by the mean of its velocity over a step: contact with that at the end lets it in.

    In three steps, from 0.11 of the wave speed to rest or back, that would be 0.02 to 0.05 cells.
    """
    rows = [[0.0, [0.0, -1.2]], [0.6, [0.0, -1.2]], [0.72, [0.0, stops]], [0.9, [0.0, stops]]]
    bodies = {
        "block": box([2.0, 0.0], [7.0, 3.0]) | EXACT,
        "plate": {"rigid": {"velocity": {"table": rows}},
                  "region": {"box": {"min": [0.5, 3.01], "max": [8.5, 4.5]}}},
    }  # fmt: skip
    _, deep = run(scene(2, bodies, cells=[9, 6], step={"courant": "auto"}, end=0.9,
                        boundaries={"y-min": "fixed"}, contact=[{"bodies": "all"}]))  # fmt: skip
    assert deep > -4e-3  # twice the length over which weights fade
