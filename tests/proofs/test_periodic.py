"""Periodic faces: nothing that a body does shows where they are."""

from math import ceil, log2, sqrt

import numpy as np
import pytest
from scenes import box, energy, field, finish, scene, start, stir
from tiers import wide

pytestmark = pytest.mark.slow(60)

CELL = 0.25
JOINED = {face: "periodic" for face in ("x-min", "x-max", "y-min", "y-max")}


def pair(shift=0, axis=0, **parts):
    """Two blocks that meet, moved by some cells; all coordinates are between 4 and 8."""
    ends = ([4.0, 4.5], [4.25, 5.0]), ([4.5, 4.25], [5.0, 5.0])
    velocities = [3.0, 0.25], [1.0, -0.75]
    for low, high in ends:
        low[axis] += shift * CELL
        high[axis] += shift * CELL
    bodies = {
        name: box(*end, v) for name, end, v in zip("ab", ends, velocities, strict=True)
    }  # fmt: skip
    case = scene(
        2, bodies, cells=[8, 8], cell=CELL, end=0.5, step=2.0**-8, gravity=[0.5, 0.25],
        boundaries=JOINED, output={"fields": ["unwrapped", "displacement"]}, **parts,
    )  # fmt: skip
    case["grid"]["origin"] = [4.0, 4.0]
    return case


def states(sim):
    """Columns of the particles, positions with their turns."""
    x = field(sim, "x") + field(sim, "winding") * sim.scene.domain.periods
    return {"x": x, **{name: field(sim, name) for name in ("v", "F", "sigma")}}


@pytest.mark.parametrize("parts", [{}, {"contact": [{"bodies": "all", "friction": 0.3}]}])
def test_a_scene_that_is_moved_gives_the_same_bits(parts):
    """Along x exactly, also where bodies cross the seam in one run and not in the other."""
    ref = finish(start(pair(**parts)))
    wanted, turns = states(ref), []
    for shift in (1, 3, 4):
        sim = finish(start(pair(shift, **parts)))
        found = states(sim)
        found["x"] = found["x"] - [shift * CELL, 0.0]
        for name, values in wanted.items():
            np.testing.assert_array_equal(found[name], values)
        turns.append(int(field(sim, "winding")[:, 0].sum()))
    assert turns[0] < turns[1] < turns[2]


def test_along_y_a_scene_that_is_moved_differs_by_rounding():
    parts = {"contact": [{"bodies": "all", "friction": 0.3}]}
    wanted = states(finish(start(pair(axis=1, **parts))))
    found = states(finish(start(pair(4, axis=1, **parts))))
    found["x"] = found["x"] - [0.0, 4 * CELL]
    for name, values in wanted.items():
        np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shape", ["gimp", "cpdi"])
def test_a_block_goes_round_as_in_a_long_domain(shape):
    """Four times round, while it swings; in the long domain it never comes to a face."""

    def block(cells, boundaries, fields):
        sim = start(scene(
            2, box([1.0, 1.0], [3.0, 3.0], [16.0, 2.0]), cells=cells, shape=shape, end=2.0,
            step=0.01, boundaries=boundaries, output={"fields": fields},
        ))  # fmt: skip
        stir(sim, 0.5)
        return finish(sim)

    far = block([40, 10], {}, ["displacement"])
    near = block([8, 10], {"x-min": "periodic", "x-max": "periodic"}, ["unwrapped"])
    assert field(near, "winding")[:, 0].min() >= 4
    found = states(near)
    np.testing.assert_allclose(found["x"], field(far, "x"), rtol=0, atol=1e-11)
    for name in ("v", "sigma"):
        np.testing.assert_allclose(found[name], field(far, name), rtol=0, atol=1e-10)
    lines = near.diagnostics(), far.diagnostics()
    assert energy(lines[0]) == pytest.approx(energy(lines[1]), rel=1e-12)
    for name in ("body.body.centre-x", "momentum-x"):
        assert lines[0][name] == pytest.approx(lines[1][name], rel=1e-12)


def test_momentum_is_constant():
    """To rounding, in 5000 steps; the blocks collide across both seams."""
    case = pair(contact=[{"bodies": "all", "friction": 0.3}])
    case["time"]["end"] = 5000 * case["time"]["step"]
    del case["gravity"]
    sim = start(case)
    first, most = sim.diagnostics(), 0.0
    scale = first["mass"] * 3.0
    while not sim.finished:
        sim.advance()
        if sim.step % 100 == 0:
            line = sim.diagnostics()
            off = max(abs(line[f"momentum-{axis}"] - first[f"momentum-{axis}"]) for axis in "xy")
            most = max(most, off / scale)
    assert most < 2e-13


def wave(dimension, n, model, along, swing, drift=(), **parts):
    """A plane wave over n cells, for five quarters of its period."""
    axis = "xyz".index(along)
    cells = [4] * dimension
    cells[axis] = n
    modulus = {"linear-1d": 1.0, "neo-hookean": 1.2 if swing == along else 0.4}[model]
    end = 1.25 / sqrt(modulus)
    material = {"model": model, "young": 1.0, "density": 1.0}
    if model == "neo-hookean":
        material["poisson"] = 0.25
    exact = {"along": along, "swing": swing, "amplitude": 1e-6 if swing == along else 1e-3}
    faces = [f"{a}-{end}" for a in "xyz"[:dimension] for end in ("min", "max")]
    case = scene(
        dimension, box([0.0] * dimension, [each / n for each in cells]), cells=cells, cell=1 / n,
        end=end, step=end / ceil(end * n / 0.2), boundaries=dict.fromkeys(faces, "periodic"),
        exact={"plane-wave": exact | ({"drift": drift} if drift else {})}, **parts,
    )  # fmt: skip
    case["materials"]["soft"] = material
    return case


@pytest.mark.parametrize(
    ("words", "configuration"),
    [
        ((1, "linear-1d", "x", "x"), "current"),
        wide((2, "neo-hookean", "x", "x"), "current"),
        ((2, "neo-hookean", "x", "y"), "current"),
        wide((2, "neo-hookean", "y", "x"), "current"),
        ((2, "neo-hookean", "y", "x"), "initial"),
    ],
    ids=lambda each: each if isinstance(each, str) else "-".join(map(str, each)),
)
def test_waves_are_back_after_a_period(words, configuration):
    """Errors of the displacement fall by 5 to 8 when cells are halved, below 1e-3 on 32."""
    errors = []
    for n in (16, 32):
        dimension, model, along, swing = words
        case = wave(dimension, n, model, along, swing)
        case["bodies"]["body"]["formulation"] = configuration
        line = finish(start(case)).diagnostics()
        errors.append(line["error.displacement-l2"] / case["exact"]["plane-wave"]["amplitude"])
    assert errors[1] < 4e-3
    assert log2(errors[0] / errors[1]) > 1.8


@pytest.mark.wide
def test_a_wave_drifts_through_the_seam():
    """Once round in x and half in y meanwhile."""
    errors = []
    for n in (16, 32):
        case = wave(2, n, "neo-hookean", "x", "y", drift=[0.8, 0.1])
        sim = finish(start(case))
        assert field(sim, "winding").max() >= 1
        errors.append(sim.diagnostics()["error.displacement-l2"] / 1e-3)
    assert errors[1] < 4e-3 < errors[0]


def test_gravity_drives_a_parabola():
    """Newton's fluid between fixed walls, along a periodic direction (Poiseuille)."""
    height, viscosity, g = 1.0, 1.0, 1.0
    for axis in (0, 1):
        across = 1 - axis
        cells = [4, 4]
        cells[across] = 16
        high = [n / 16 for n in cells]
        faces = {f"{'xy'[axis]}-{end}": "periodic" for end in ("min", "max")}
        faces |= {f"{'xy'[across]}-{end}": "fixed" for end in ("min", "max")}
        case = scene(
            2, box([0.0, 0.0], high), cells=cells, cell=1 / 16, shape="gimp", end=1.2, step=4e-4,
            boundaries=faces, gravity=[g * (axis == 0), g * (axis == 1)],
        )  # fmt: skip
        case["materials"]["soft"] = {
            "model": "newtonian", "bulk": 400.0, "shear-viscosity": viscosity, "density": 1.0,
        }  # fmt: skip
        sim = finish(start(case))
        y, v = field(sim, "x")[:, across], field(sim, "v")[:, axis]
        exact = 0.5 * g / viscosity * y * (height - y)
        np.testing.assert_allclose(v, exact, rtol=0, atol=0.01 * 0.125)
        assert abs(field(sim, "v")[:, across]).max() < 1e-6


def test_velocities_between_moving_walls():
    """Couette's, of particles too, not only of the grid: what it cannot resolve fades by itself."""
    faces = {"x-min": "periodic", "x-max": "periodic"}
    faces |= {"y-min": {"velocity": [0.0, 0.0]}, "y-max": {"velocity": [1.0, 0.0]}}
    case = scene(
        2, box([0.0, 0.0], [0.25, 0.5]), cells=[4, 8], cell=1 / 16, shape="gimp", end=4.0,
        step=8e-4, boundaries=faces,
    )  # fmt: skip
    case["materials"]["soft"] = {
        "model": "newtonian", "bulk": 400.0, "shear-viscosity": 0.5, "density": 1.0,
    }  # fmt: skip
    sim = finish(start(case))
    np.testing.assert_allclose(
        field(sim, "v")[:, 0], 2.0 * field(sim, "x")[:, 1], rtol=0, atol=0.01
    )  # without pic-damping: 0.12
