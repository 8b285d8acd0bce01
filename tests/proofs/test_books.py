"""Momentum and external work balance to rounding, whatever acts, in random scenes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import box, field, finish, scene, start, stir, wall

pytestmark = pytest.mark.slow(30)

MOVING = wall(0.2, [[0.0, 0.0], [0.1, 0.3], [0.2, 0.3]])
#: One of each kind, in one order, for which the momentum update is compiled once.
WALLS = {"x-min": MOVING, "x-max": "slip", "y-min": "unilateral", "y-max": "fixed"}

#: What decides which kernels are compiled; all else is drawn at random. Where there is a `grip` a
#: part is held: always or never, which compiles less.
KINDS = {
    "gimp": {"shape": "gimp", "boundaries": WALLS, "grip": True},
    "affine": {"shape": "gimp", "affine": True, "boundaries": WALLS | {"x-min": wall(None, -0.1)}},
    "mirror": {"shape": "fuzzy-nearest", "wall": "mirror", "boundaries": WALLS, "grip": True},
    "bar": {"shape": "mpm", "boundaries": {"x-min": wall([[0.0, 0.0], [0.2, 0.3]])}, "grip": True},
}


def random_scene(seed, kind):
    """A block that fills a random part of the domain, and may lie at its walls."""
    rng = np.random.default_rng(seed)
    parts = dict(KINDS[kind])
    dimension = 1 if kind == "bar" else 2
    affine = parts.pop("affine", False)
    cells = [int(n) for n in rng.integers(4, 8, dimension)]
    low = [float(x) for x in rng.choice([0.0, 0.0, 0.37], dimension)]
    gaps = rng.choice([0.0, 0.0, 0.81], dimension)
    high = [n - float(gap) for n, gap in zip(cells, gaps, strict=True)]
    body = box(low, high, [float(v) for v in rng.uniform(-0.5, 0.5, dimension)])
    pull = [float(b) for b in rng.uniform(-1.0, 1.0, dimension)]
    if parts.pop("grip", False):
        held = [None if rng.random() < 0.4 else float(v) for v in rng.uniform(-0.3, 0.3, dimension)]
        middle = {"box": {"min": [1.1] * dimension, "max": [2.6] * dimension}}
        parts["constraints"] = {"grip": {"body": "body", "region": middle, "velocity": held}}
    case = scene(
        dimension,
        body,
        cells=cells,
        end=0.3,
        step=float(rng.choice([0.005, 0.01])),
        gravity={"table": [[0.0, [0.0] * dimension], [0.15, pull]]},
        **parts,
    )
    case["method"] |= {"relaxation": float(rng.choice([3.0, 30.0, 500.0])), "affine": affine}
    return case


@pytest.mark.parametrize("kind", KINDS)
def test_momentum_comes_from_what_the_history_names(kind):
    """With relaxation too, which takes on of walls' and grips' velocities what they have set."""

    # The force on vertices lighter than 1e-12 of a particle is lost: with boxes a part of 1e-6, the
    # root, of a particle's, in the few steps in which there are such vertices. Points have none.
    exact = 1e-12 if kind == "bar" else 1e-8

    @settings(max_examples=8, deadline=None, derandomize=True)
    @given(st.integers(0, 2**32))
    def check(seed):
        case = random_scene(seed, kind)
        sim = start(case)
        stir(sim, 0.3)
        axes = "xyz"[: case["dimensions"]]
        line = sim.diagnostics()
        while not sim.finished:
            weight = np.zeros(len(axes))
            for _ in range(7):
                if not sim.finished:
                    before = sim.time
                    sim.advance()
                    gravity = np.array(sim.scene.domain.gravity(before)[: len(axes)])
                    weight += line["mass"] * gravity * (sim.time - before)
            last, line = line, sim.diagnostics()
            for i, axis in enumerate(axes):
                forces = [
                    value for name, value in line.items()
                    if name.startswith(("reaction.", "constraint.")) and name.endswith(f"-{axis}")
                ]  # fmt: skip
                impulses = [weight[i], *(f * (line["time"] - last["time"]) for f in forces)]
                gained = line[f"momentum-{axis}"] - last[f"momentum-{axis}"]
                scale = abs(line[f"momentum-{axis}"]) + np.abs(impulses).sum()
                assert gained == pytest.approx(sum(impulses), rel=0, abs=exact * scale + 1e-12)

    check()


@pytest.mark.parametrize("wall_kind", ["face", "constraint"])
def test_relaxed_external_work_is_force_times_velocity(wall_kind):
    """Constant prescribed velocities, no other load: their work is their impulse times them."""
    pushed = {"boundaries": {"x-min": wall(0.2, -0.1)}}
    if wall_kind == "constraint":
        region = {"box": {"min": [0.0, 0.0], "max": [1.6, 1.6]}}
        grip = {"body": "body", "region": region, "velocity": [0.2, -0.1]}
        pushed = {"constraints": {"grip": grip}, "boundaries": {"y-max": "slip"}}
    case = scene(2, box([0.0, 1.0], [4.0, 3.0]), cells=[6, 4], end=0.5, **pushed)
    case["method"]["pic-damping"] = 20.0
    sim = start(case)
    sim.diagnostics()
    line = finish(sim).diagnostics()
    name = "constraint.grip" if wall_kind == "constraint" else "reaction.x-min"
    work = 0.5 * (0.2 * line[f"{name}-x"] - 0.1 * line[f"{name}-y"])
    assert abs(work) > 0.01
    assert line["external-work"] == pytest.approx(work, rel=1e-12)


def test_work_of_gravity_is_weight_times_way():
    """Also where constraints rule the velocity: the way is that of the grid's mass, and theirs."""
    region = {"box": {"min": [1.0, 1.0], "max": [2.6, 2.6]}}
    grip = {"body": "body", "region": region, "velocity": [0.0, 0.0]}
    case = scene(
        2, box([1.0, 1.0], [4.0, 3.0]), end=0.01, gravity=[0.3, -2.0], constraints={"grip": grip}
    )
    sim = start(case)
    line = finish(sim).diagnostics()
    way = field(sim, "x").sum(axis=0) - field(start(case), "x").sum(axis=0)
    weight = line["mass"] / sim.count * np.array([0.3, -2.0])
    # The grip is at rest and works nothing; its particles did not move, the others did by one step.
    assert line["external-work"] == pytest.approx(float(weight @ way), rel=1e-12)
