"""Bodies of both configurations in periodic domains: nothing depends on where a seam is."""

import pytest
from scenes import box, energy, finish, scene, start
from tiers import wide

pytestmark = pytest.mark.slow(40)

TOTAL, UPDATED = "total-lagrangian", "updated-lagrangian"


def sliding(shift, kinds, axis, side=12.0):
    """A block with friction on a floor from end to end; `axis` is along the floor."""

    def turned(*along):
        return list(along) if axis == 0 else list(along[::-1])

    ends = (4.25 + shift) % side, (8.4375 + shift) % side
    parts = [ends] if ends[0] < ends[1] else [(ends[0], side), (0.0, ends[1])]
    boxes = [{"box": {"min": turned(a, 2.0625), "max": turned(b, 4.5625)}} for a, b in parts]
    block = {"material": "soft", "region": boxes[0] if len(boxes) == 1 else {"union": boxes},
             "velocity": turned(2.0, -1.0), "formulation": kinds[0]}  # fmt: skip
    floor = box([0.0, 0.0], turned(side, 2.0)) | {"formulation": kinds[1]}
    name, across = ("x", "y-min") if axis == 0 else ("y", "x-min")
    faces = {f"{name}-min": "periodic", f"{name}-max": "periodic", across: "fixed"}
    case = scene(2, {"block": block, "floor": floor}, cells=turned(12, 7), step=0.02, end=1.5,
                 gravity=turned(0.0, -1.0), boundaries=faces,
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip
    sim = start(case)
    return sim.diagnostics(), finish(sim).diagnostics(), name


@pytest.mark.parametrize(
    ("kinds", "axis"),
    [((TOTAL, UPDATED), 0), ((UPDATED, TOTAL), 0), ((TOTAL, UPDATED), 1),
     wide((UPDATED, TOTAL), 1)],
)  # fmt: skip
def test_a_block_does_not_feel_where_a_seam_is(kinds, axis):
    """Beside it, cut by it, passing it. To the sweeps' tolerance: patches are in another order."""
    first, one, name = sliding(0.0, kinds, axis)
    assert energy(one) < energy(first)
    assert one[f"body.block.momentum-{name}"] < 15.0  # friction has slowed it
    assert one["contact.all.tangential-impulse"] == pytest.approx(
        0.3 * one["contact.all.normal-impulse"], rel=1e-3
    )
    size = max(abs(one[each]) for each in one if each.startswith("contact"))
    for shift in (6.0, 3.0):
        other = sliding(shift, kinds, axis)[1]
        for each in one:
            if each.startswith(("body", "contact", "reaction")) and "centre" not in each:
                if "angular" not in each and "moment-z" not in each:
                    assert abs(one[each] - other[each]) < 1e-6 * size, each


def test_a_slice_of_three_cells_is_as_wide_ones():
    """Material fills the tent of a facet with its images, too: the load on a column is even."""
    found = []
    for cells in (3, 6):
        bodies = {"low": box([0.0, 0.0], [cells, 4.0]),
                  "high": box([0.0, 4.0], [cells, 6.5]) | {"formulation": TOTAL}}  # fmt: skip
        faces = {"x-min": "periodic", "x-max": "periodic", "y-min": "fixed"}
        weight = {"table": [[0.0, [0.0, 0.0]], [5.0, [0.0, -0.5]]]}
        sim = start(scene(
            2, bodies, cells=[cells, 8], step=0.02, end=12.0, gravity=weight, boundaries=faces,
            damping={"mass": 2.0}, contact=[{"bodies": "all", "friction": 0.3}],
        ))  # fmt: skip
        while sim.time < 11.0:
            sim.advance()
        sim.diagnostics()
        line = finish(sim).diagnostics()
        assert line["contact.all.area"] == pytest.approx(cells, rel=1e-9)
        assert abs(line["reaction.y-min-y"]) == pytest.approx(0.5 * line["mass"], rel=1e-3)
        found.append(line["body.high.centre-y"])
    assert found[0] == pytest.approx(found[1], abs=1e-6)
