"""Momentum of vertices that become slaves with a stage: their masters get it."""

import pytest
from scenes import SOFT, box, scene
from staged_bar import entered

PAIR = {"soft": SOFT, "stiff": SOFT | {"young": 400.0, "density": 2.0}}
INITIAL = {"formulation": "total-lagrangian"}


def parted(before, after, edge=7.03):
    """Two bodies that fly apart while they bend, with laws of contact in two stages."""
    spin = {"rotation": {"about": [8.0, 3.0], "rate": 0.4}, "translation": [0.7, -0.3]}
    bodies = {
        "a": box([3.2, 4.3], [edge, 7.1], [-0.5, 0.3]) | INITIAL,
        "b": box([edge, 4.3], [10.8, 7.1], spin, "stiff") | INITIAL,
    }
    laws = [[{"bodies": ["a", "b"], **law}] for law in (before, after)]
    case = scene(2, bodies, cells=[14, 14], materials=PAIR, step={"courant": 0.3}, end=0.4,
                 contact=laws[0])  # fmt: skip
    case["time"]["stages"] = [{"name": "later", "end": 0.5, "contact": laws[1]}]
    return case


@pytest.mark.parametrize("edge", [7.03, 6.99])
@pytest.mark.parametrize("parts", [True, pytest.param(False, marks=pytest.mark.wide)])
def test_bodies_that_part_or_join_keep_their_momentum(edge, parts):
    """It was off by a thousandth: slivers of cells were full ones while both were one body."""
    laws = {"law": "tie"}, {"friction": 0.3}
    sim, before = entered(parted(*laws[:: 1 if parts else -1], edge))
    sim.advance()
    now = sim.diagnostics()
    for name in ("momentum-x", "momentum-y"):
        assert now[name] == pytest.approx(before[name], abs=1e-12), name
    assert now["angular-momentum-z"] == pytest.approx(before["angular-momentum-z"], rel=1e-4)
    assert now["kinetic-energy"] < 1.01 * before["kinetic-energy"]
