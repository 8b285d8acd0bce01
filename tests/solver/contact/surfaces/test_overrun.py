"""Contact that was overrun is told: surfaces deeper in another body than a quarter of a cell."""

import numpy as np
import pytest
from scenes import SOFT, box, scene, start

from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD

pytestmark = pytest.mark.slow(40)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}


def told(case, way, moves=None):
    """What is said after the last body's vertices, or those with `moves`, have gone a `way`."""
    sim = start(case)
    sim.advance()
    rank, contact = sim.rank, sim.rank.contact
    table, frame = contact.known(rank), sim.scene.domain.frame
    D = sim.scene.dimension
    surface, values = table.surface, rank.grid.kept.values.reshape(-1, RECORD)
    gone = np.unique(table.cells.corners[surface.cell[surface.body == surface.body.max()]])
    if moves:
        gone = moves((table.numbers[:, :D] - frame.ghost) * frame.cell + frame.origin)
    some = contact._proximity._records[gone]
    values[some, DISPLACEMENT : DISPLACEMENT + D] += way
    return contact.overrun(rank, sim.now)


def two(D, other, cells, **more):
    """A box, and a body 0.3 cells beside it along x, the first to look or the last."""
    size = [4.6, *[3.4] * (D - 1)]
    bodies = {"left": box([2.1] * D, [size[0] + 1.1, *[a + 1.8 for a in size[1:]]]) | EXACT,
              "right": {"material": "soft", "region": other} | EXACT}  # fmt: skip
    parts = {"contact": [{"bodies": ["left", "right"]}], "end": 1e-2, "step": 1e-3} | more
    return scene(D, bodies, cells=cells, materials={"soft": SOFT}, **parts)


def box_of(low, high):
    return {"box": {"min": low, "max": high}}


@pytest.mark.parametrize("depth, deep", [(0.1, False), (0.2, False), (0.32, True), (1.5, True),
                                         (3.4, True)])  # fmt: skip
@pytest.mark.parametrize("shape", ["box", "ball"])
def test_what_is_deeper_than_a_quarter_of_a_cell_is_told(shape, depth, deep):
    other = box_of([6.0, 2.6], [9.2, 5.1])
    if shape == "ball":
        other = {"ball": {"centre": [7.7, 3.7], "radius": 1.7}}
    said = told(two(2, other, [12, 9]), [-0.3 - depth, 0.0])
    assert len(said) == deep
    if deep:
        assert "overrun" in said[0] and "'left'" in said[0] and "'right'" in said[0]


@pytest.mark.parametrize("depth, deep", [(0.18, False), (0.35, True), (2.0, True)])
def test_it_is_told_in_space(depth, deep):
    said = told(two(3, box_of([6.0, 2.4, 2.6], [8.9, 4.8, 5.0]), [11, 8, 8]), [-0.3 - depth, 0, 0])
    assert len(said) == deep


def test_bodies_beside_a_plane_of_symmetry_are_closed_by_their_images():
    """Halves have no surface in the plane, and are full all the same."""
    bodies = {"left": box([2.1, 0.0], [5.7, 3.4]) | EXACT,
              "right": box([6.0, 0.0], [9.2, 1.3]) | EXACT}  # fmt: skip
    case = scene(2, bodies, cells=[12, 6], materials={"soft": SOFT}, end=1e-2, step=1e-3,
                 contact=[{"bodies": ["left", "right"]}],
                 boundaries={"y-min": "slip"})  # fmt: skip
    assert not told(case, [-0.4, 0.0])
    assert told(case, [-0.7, 0.0])


def test_a_body_in_its_own_is_told():
    """The ends of a fork pass through each other; bent until they nearly touch they do not."""
    fork = {"difference": [box_of([2.1, 1.7], [9.3, 7.7]), box_of([4.2, 3.2], [10.0, 6.2])]}
    bodies = {"fork": {"material": "soft", "region": fork} | EXACT}
    case = scene(2, bodies, cells=[12, 10], materials={"soft": SOFT}, end=1e-2, step=1e-3,
                 contact=[{"bodies": ["fork"], "self": True}])  # fmt: skip

    def upper(X):
        return (X[:, 1] > 5.5) & (X[:, 0] > 5.5)

    assert not told(case, [0.0, -2.9], upper)
    said = told(case, [0.0, -3.6], upper)
    assert len(said) == 1 and "its own, 'fork'" in said[0]


def test_a_stretched_body_is_as_full():
    """Area vectors are the current ones: the solid angle does not follow a strain."""
    case = two(2, box_of([6.0, 2.6], [9.2, 5.1]), [12, 9])
    sim = start(case)
    sim.advance()
    table, frame = sim.rank.contact.known(sim.rank), sim.scene.domain.frame
    X = np.zeros((len(table.numbers), 3))
    X[:, :2] = (table.numbers[:, :2] - frame.ghost) * frame.cell + frame.origin[:2]
    F = np.array([[0.7, 0.4, 0.0], [0.0, 1.8, 0.0], [0.0, 0.0, 1.0]])
    surface = table.surface._replace(now=table.surface.x @ F.T)
    middle = surface.now[surface.body == 1].mean(axis=0)
    points = middle + np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, -9.0, 0.0]])
    turns = sim.rank.contact._watch._turns(table, surface, 1, X @ F.T - X, points)
    np.testing.assert_allclose(turns, [1.0, 0.0, 0.0], atol=5e-3)


@pytest.mark.parametrize("way, deep", [(-0.4, False), (-0.7, True), (-12.8, True), (5.0, False)])
def test_images_across_seams_are_seen(way, deep):
    """A box that lies across a seam is full there, and so are its images."""
    parts = [box_of([11.1, 2.1], [12.0, 5.2]), box_of([0.0, 2.1], [2.5, 5.2])]
    bodies = {"left": {"material": "soft", "region": {"union": parts}} | EXACT,
              "right": box([2.8, 2.6], [5.3, 4.6]) | EXACT}  # fmt: skip
    case = scene(2, bodies, cells=[12, 9], materials={"soft": SOFT}, end=1e-2, step=1e-3,
                 contact=[{"bodies": ["left", "right"]}],
                 boundaries={"x-min": "periodic", "x-max": "periodic"})  # fmt: skip
    assert len(told(case, [way, 0.0])) == deep


@pytest.mark.parametrize("depth, deep", [(0.03, False), (0.1, True)])
def test_surfaces_that_overlap_by_more_than_a_twentieth_of_a_cell_are_told(depth, deep):
    """Once; where gaps between lines of the history count as well."""
    case = two(2, box_of([6.0, 2.6], [9.2, 5.1]), [12, 9])
    sim = start(case)
    sim.advance()
    rank, contact = sim.rank, sim.rank.contact
    surface = contact.known(rank).surface
    gone = np.unique(contact.known(rank).cells.corners[surface.cell[surface.body == 1]])
    records = contact.proximity._records[gone]
    rank.grid.kept.values.reshape(-1, RECORD)[records, DISPLACEMENT] -= 0.3 + depth
    sim.advance()
    sim.advance()
    said = contact.overrun(rank, sim.now)
    assert len(said) == deep and not contact.overrun(rank, sim.now)
    if deep:
        assert f"was {depth:.2g} cells deep" in said[0] and "near (5.7, " in said[0]


def test_what_is_overrun_in_a_short_run_is_told_at_its_end():
    """A look each 200 steps would miss it; so would what meets: it is deeper than that sees."""
    sim = start(two(2, box_of([6.0, 2.6], [9.2, 5.1]), [12, 9]))
    sim.advance()
    rank, contact, now = sim.rank, sim.rank.contact, sim.now
    assert not contact.overrun(rank, now)
    surface = contact.known(rank).surface
    gone = np.unique(contact.known(rank).cells.corners[surface.cell[surface.body == 1]])
    records = contact.proximity._records[gone]
    rank.grid.kept.values.reshape(-1, RECORD)[records, DISPLACEMENT] -= 0.3 + 1.5
    assert not contact.overrun(rank, now._replace(number=9, end=9e-3))
    assert "was overrun" in contact.overrun(rank, now._replace(number=10, end=1e-2))[0]


def test_bodies_that_are_gone_are_not_looked_for_across_seams():
    bodies = {name: box([low, 2.6], [low + 2.5, 4.6]) | EXACT
              for name, low in (("left", 0.3), ("right", 4.1), ("goes", 7.9))}  # fmt: skip
    case = scene(2, bodies, cells=[12, 9], materials={"soft": SOFT}, end=1e-3, step=1e-3,
                 contact=[{"bodies": "all"}],
                 boundaries={"x-min": "periodic", "x-max": "periodic"})  # fmt: skip
    case["time"]["stages"] = [{"name": "later", "end": 2e-3, "remove": ["goes"]}]
    sim = start(case)
    sim.advance()
    sim.next_stage()
    sim.advance()
    assert not sim.rank.contact.overrun(sim.rank, sim.now)
