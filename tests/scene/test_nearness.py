"""Warnings of bodies and walls that come near each other, against what simulations do."""

import numpy as np
import pytest
from mentioned import mentions
from tiers import wide

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.checks import bonds, nearness
from pgimp.scene.scene import Scene
from pgimp.solver.simulation import Simulation

pytestmark = pytest.mark.slow(20)


def line(bodies, method=None, **more):
    """Boxes along x in cells of 1: name to (low, high, velocity)."""
    return Case.model_validate(
        {
            "format": 1,
            "dimensions": 1,
            "grid": {"size": [40.0], "cell": [1.0]},
            "method": {"shape": "gimp", "particles-per-cell": [2]} | (method or {}),
            "time": {"end": 100.0, "step": {"courant": 0.3}},
            "materials": {"m": {"model": "linear-1d", "young": 1.0, "density": 1.0}},
            "bodies": {
                name: {
                    "material": "m",
                    "region": {"box": {"min": [low], "max": [high]}},
                    "velocity": [velocity],
                }
                for name, (low, high, velocity) in bodies.items()
            },
        }
        | more
    )


def bonded(case):
    scene = Scene(case)
    lattice, counts, notes = count_particles(scene, Serial())
    return list(bonds.bonded(scene, lattice, counts, touching=False)), notes


@pytest.mark.parametrize(("shape", "n"), [("gimp", 2), wide("mpm", 2), wide("fuzzy-constant", 2)])
def test_bodies_feel_each_other_from_the_reach_on(shape, n):
    """The greatest gap at which momentum passes, over places of the gap between vertices."""
    method, gaps = {"shape": shape, "particles-per-cell": [n]}, []
    for velocity in np.linspace(0.003, 0.05, 7):
        bodies = {"a": (5.0, 9.0, float(velocity)), "b": (15.0, 19.0, -0.05)}
        sim = Simulation(line(bodies, method), Serial())
        first, gap = sim.diagnostics()["body.a.momentum-x"], 6.0
        # Weights at the end of a support are a square or third power of the distance to it.
        while abs(sim.diagnostics()["body.a.momentum-x"] - first) < 1e-11:
            gap = 6.0 - (0.05 + velocity) * sim.time
            sim.advance()
        gaps.append(gap)
    (reach,) = nearness.reach(sim.case)
    assert reach == {"gimp": 2.0, "mpm": 1.5, "fuzzy-constant": 3.5}[shape]
    # Where a vertex lies just so, they feel each other from the whole reach; never from farther.
    assert reach - 0.15 < max(gaps) <= reach


@pytest.mark.parametrize("gap", [0.5, 0.9, 1.1, 1.6, 1.9, 2.1])
@pytest.mark.parametrize("place", [0.0, 0.25, 0.5, 0.75])
def test_bodies_that_share_a_vertex_at_the_start_pass_momentum_at_once(gap, place):
    end = 9.0 + place
    case = line({"a": (5.0, end, 0.0), "b": (end + gap, 19.0, -1e-3)})
    sim = Simulation(case, Serial())
    for _ in range(3):  # the first one makes a stress, and no way worth mentioning
        sim.advance()
    # Less passes where b has moved into the reach of a vertex since the start.
    moved = abs(sim.diagnostics()["body.a.momentum-x"]) > 1e-8
    warned, notes = bonded(case)
    assert bool(warned) == (moved and not notes)
    assert all("'a' and 'b' share vertices of the grid from the start" in text for text in warned)


def said(case):
    return " ".join(nearness.warnings(case))


def test_who_may_meet():
    at_rest, coming = (5.0, 9.0, 0.0), (20.0, 24.0, -0.5)
    assert "'a' and 'b' (from t = " in said(line({"a": at_rest, "b": coming}))
    assert "2 cells apart" in said(line({"a": at_rest, "b": coming}))
    # Within reach already, though no vertex may be shared yet; but not if they touch.
    assert "may meet" in said(line({"a": at_rest, "b": (10.5, 24.0, -0.1)}))
    assert not said(line({"a": at_rest, "b": (9.0, 24.0, -0.1)}))
    assert not said(line({"a": at_rest, "b": (10.5, 24.0, 0.1)}))
    # Away from each other, side by side, and not before the end.
    assert not said(line({"a": coming, "b": (*at_rest[:2], -0.6)}))
    assert not said(line({"a": (*at_rest[:2], -0.5), "b": coming}))
    assert not said(line({"a": at_rest, "b": coming}, time={"end": 1.0, "step": 0.1}))
    # Falling alike they do not meet, unless a wall or a constraint keeps one back.
    fall = {"gravity": [-0.1]}
    both = {"a": at_rest, "b": (20.0, 24.0, 0.0)}
    assert not said(line(both, **fall))
    assert "may meet" in said(line(both, **fall, boundaries={"x-min": "unilateral"}))
    grip = {"body": "a", "region": {"box": {"min": [5.0], "max": [6.0]}}, "velocity": [0.0]}
    assert "may meet" in said(line(both, **fall, constraints={"c": grip}))
    push = grip | {"velocity": [{"table": [[0.0, 0.0], [10.0, 1.0]]}]}
    assert "may meet" in said(line(both, constraints={"c": push}))
    assert not said(line(both))
    # Gravity that turns around brings one nearer, whatever its sum.
    both["a"], sway = (0.0, 4.0, 0.0), {"table": [[0.0, [0.0]], [50.0, [-0.1]], [100.0, [0.0]]]}
    assert "may meet" in said(line(both, gravity=sway, boundaries={"x-min": "fixed"}))


def test_walls():
    near = line({"a": (0.75, 4.0, 0.0)}, boundaries={"x-min": "slip"})
    (text,) = nearness.warnings(near)
    mentions(text, "boundaries.x-min: ", "'a'", "interacts", "from 1", "cell away", "pulled away")
    assert not nearness.notes(near)
    for low, gravity, count in ((0.0, -0.1, 0), (3.0, 0.0, 0), (3.0, -0.1, 1)):
        parts = {"a": (low, 8.0, 0.0)}, {"gravity": [gravity]}
        case = line(parts[0], boundaries={"x-min": "slip"}, **parts[1])
        assert not nearness.warnings(case)
        notes = nearness.notes(case)
        assert len(notes) == count
        # A wall that lets go is felt when it is reached, but by points, and never holds back.
        for shape, number in (("gimp", 0), ("mpm", count)):
            case = line(
                parts[0], boundaries={"x-min": "unilateral"}, method={"shape": shape}, **parts[1]
            )
            assert not nearness.warnings(case)
            assert len(nearness.notes(case)) == number
            assert not any("pulled away" in text for text in nearness.notes(case))


def water(bodies, **law):
    """Boxes in a plane, of water; two without velocities stand 1.5 cells apart."""
    names = {}
    for name, (low, high, velocity) in bodies.items():
        box = {"min": [low, 0.0], "max": [high, 4.0]}
        names[name] = {"material": "water", "region": {"box": box}, "velocity": [velocity, 0.0]}
    return Case.model_validate(
        {
            "format": 1, "dimensions": 2,
            "grid": {"size": [30.0, 6.0], "cell": [1.0, 1.0]},
            "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
            "time": {"end": 30.0, "step": {"courant": 0.3}},
            "materials": {"water": {"model": "newtonian", "bulk": 100.0, "density": 1.0} | law},
            "bodies": names,
            "boundaries": {"x-min": "slip", "y-min": "slip"},
        }
    )  # fmt: skip


def test_liquids_flow_together_and_leave_walls():
    """Two bodies of water that share vertices part without losing momentum: nothing bonds them."""
    parting = water({"a": (5.0, 9.0, -0.1), "b": (10.0, 14.0, 0.1)})
    assert not bonded(parting)[0]
    sim = Simulation(parting, Serial())
    sim.advance(5.0)
    assert sim.diagnostics()["body.b.momentum-x"] == pytest.approx(1.6, rel=1e-9)
    assert not said(water({"a": (5.0, 9.0, 0.0), "b": (14.0, 18.0, -0.5)}))
    coming = {"a": (3.0, 7.0, -0.5)}
    (text,) = nearness.notes(water(coming))
    assert "interacts with it from" in text
    assert "pulled away" not in text
    (text,) = nearness.notes(water(coming, tension=True))
    assert "pulled away" in text


def plane(velocity, low=(1.0, 1.0), high=(3.0, 3.0)):
    box = {"min": [*low], "max": [*high]}
    return Case.model_validate(
        {
            "format": 1,
            "dimensions": 2,
            "grid": {"size": [16.0, 16.0], "cell": [0.25, 0.25]},
            "method": {"shape": "mpm", "particles-per-cell": [2, 2]},
            "time": {"end": 10.0, "step": {"courant": 0.3}},
            "materials": {"m": {"model": "hooke", "young": 1, "poisson": 0, "density": 1}},
            "bodies": {
                "a": {"material": "m", "region": {"box": box}, "velocity": velocity},
                "b": {"material": "m", "region": {"ball": {"centre": [8, 2], "radius": 1}}},
            },
        }
    )


def test_in_the_plane_they_meet_only_if_they_are_at_one_place_at_a_time():
    assert "may meet" in said(plane([1.0, 0.0]))
    assert "may meet" in said(plane([1.0, 0.1]))
    assert not said(plane([1.0, 1.0]))
    assert not said(plane([0.1, 0.0]))
    # A body that turns fills its circle, but goes nowhere.
    turning = {"rotation": {"about": [2.0, 2.0], "rate": 50.0}}
    assert not said(plane(turning))
    turning = {"rotation": {"about": [3.75, 2.0], "rate": 50.0}}
    assert "may meet" in said(plane(turning, high=(6.5, 3.0)))
    # About a point far away its middle moves.
    assert "may meet" in said(plane({"rotation": {"about": [2.0, 12.0], "rate": 0.1}}))
