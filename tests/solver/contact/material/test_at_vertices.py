"""Bodies in the current configuration beside surfaces: pairs at vertices, and their impulses."""

import numpy as np
import pytest
from scenes import SOFT, box, energy, finish, scene, start

from pgimp.solver.contact.impulses.impulse_contact import nothing_held

pytestmark = pytest.mark.slow(30)


def blocks(idle, **parts):
    """Two blocks that meet askew over a wall that lets go, and one that nothing meets."""
    bodies = {
        "a": box([2.1, 1.3], [5.1, 3.9], [0.3, 0.1]),
        "b": box([5.17, 1.0], [8.6, 4.2], [-0.3, -0.1]),
        "idle": box([11.0, 6.0], [13.0, 7.0]) | {"formulation": idle},
    }
    return scene(2, bodies, cells=[14, 8], step={"courant": 0.3},
                 materials={"soft": SOFT | {"young": 1000.0}},
                 contact=[{"bodies": ["a", "b"], "friction": 0.3}], **parts)  # fmt: skip


def by_vertex(rows):
    """What pairs have, by their vertices: normal towards the second body, gap, area."""
    return {tuple(row[0]): np.concatenate([row[1], row[2:]], axis=None) for row in rows}


def test_pairs_are_those_of_scenes_without_surfaces():
    """The same vertices, normals, gaps and areas; a row is a body's own field there."""
    plain, mixed = start(blocks("updated-lagrangian")), start(blocks("total-lagrangian"))
    while plain.time < 0.1:
        plain.advance()
        mixed.advance()
    contact, update = mixed.rank.contact, {}
    find = contact._at_vertices.find

    def look(rank, root, holding, dt):
        update["joint"] = find(rank, root, nothing_held(holding), dt)
        return update["joint"]

    contact._at_vertices.find = look
    plain.rank.mass_cutoff = np.inf  # vertices at which nothing is exchanged are listed, too
    plain.advance()
    mixed.advance()
    listed, one = plain.rank.contact.data.listed, []
    for vertex in listed.vertices[: int(listed.start[-1])]:
        pair = listed.pairs[vertex["first_pair"]]
        bodies = [listed.fields[vertex["first_field"] + f]["body"] for f in pair["fields"]]
        way = 1.0 if bodies[0] < bodies[1] else -1.0
        one.append((vertex["number"], way * pair["normal"], pair["gap_rate"], pair["area"]))
    pairs, coupling, vertices = update["joint"]
    other = []
    for end, state in zip(pairs.ends, pairs.states, strict=True):
        way = 1.0 if end["bodies"][0] < end["bodies"][1] else -1.0
        other.append((end["vertex"], way * state["normal"], state["gap_rate"], state["area"]))
    one, other = by_vertex(one), by_vertex(other)
    assert len(one) >= 4
    assert one.keys() == other.keys()
    for vertex, values in one.items():
        np.testing.assert_allclose(other[vertex], values, rtol=0.02, atol=0.02)
    np.testing.assert_array_equal(np.diff(coupling.start), 1)
    np.testing.assert_array_equal(coupling.entry, 1.0)
    assert len(coupling.answer) == 2 * len(pairs.ends)
    mass = vertices.values["mass"][coupling.column]
    np.testing.assert_allclose(coupling.answer[:, :2], 1.0 / mass[:, None] + np.zeros(2))


def test_impulses_are_those_of_scenes_without_surfaces():
    """But for the two passes of these: momenta within a tenth, and no energy from nothing."""
    lines = []
    for idle in ("updated-lagrangian", "total-lagrangian"):
        sim = start(blocks(idle, end=3.0))
        first = sim.diagnostics()
        lines.append(finish(sim).diagnostics())
        size = abs(first["body.a.momentum-x"])
        assert abs(lines[-1]["momentum-x"] - first["momentum-x"]) < 1e-12 * size
        assert energy(lines[-1]) < energy(first)
    one, other = lines
    normal = "contact.a+b.normal-impulse"
    assert other[normal] == pytest.approx(one[normal], rel=0.07)
    for name in ("body.a.momentum-x", "body.b.momentum-x"):
        assert abs(other[name] - one[name]) < 0.1 * one[normal]


def test_blocks_rest_on_a_wall_that_lets_go():
    """They close a gap of 0.02 cells, and sink by rho g H^2/(3 E); the wall bears their weight.

    At vertices a narrow block, of a cell and a half, stands by a part of that gap before the wall.
    """
    case = blocks("total-lagrangian", end=8.0, gravity=[0.0, -1.0], damping={"mass": 3.0},
                  boundaries={"y-min": {"unilateral": {"friction": 0.2}}})  # fmt: skip
    case["bodies"] |= {"a": box([2.1, 0.02], [5.1, 3.9]), "b": box([8.1, 0.02], [9.6, 2.2])}
    sim = start(case)
    while sim.time < 7.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    weight = line["body.a.mass"] + line["body.b.mass"]
    assert abs(line["reaction.y-min-y"]) == pytest.approx(weight, rel=0.01)
    for name, high, near in (("a", 3.9, 0.003), ("b", 2.2, 0.012)):
        rests = 0.5 * (high - 0.02) - (high - 0.02) ** 2 / (3.0 * 1000.0 / 0.91)
        assert line[f"body.{name}.centre-y"] == pytest.approx(rests, abs=near)
