"""Surfaces of bodies in the initial configuration that meet material in the current one."""

import pytest
from scenes import box, energy, scene, start

pytestmark = pytest.mark.slow(40)

WAVE, CELLS, APART = 10.0, 40, 0.3


def bars(speed, moving):
    """Two bars, the second in the current configuration, that meet while the scene moves."""
    v, V = speed * WAVE, moving * WAVE
    end = 0.5 * APART / v + 2.3 * CELLS / WAVE
    bodies = {
        "a": box([3.0], [3.0 + CELLS], [V + v]) | {"formulation": "total-lagrangian"},
        "b": box([3.0 + CELLS + APART], [3.0 + 2 * CELLS + APART], [V - v]),
    }
    cells = int(2 * CELLS + 12 + V * end)
    return scene(1, bodies, cells=[cells], end=end, step={"courant": 0.3},
                 contact=[{"bodies": ["a", "b"]}])  # fmt: skip


@pytest.mark.parametrize(("moving", "least"), [(0.0, 0.955), (0.2, 0.935)])
def test_bars_rebound_in_any_frame(moving, least):
    """At vertices of a grid in space the second was 0.909. Nothing gives momentum or energy."""
    sim = start(bars(0.01, moving))
    first = sim.diagnostics()
    while not sim.finished:
        sim.advance()
    last = sim.diagnostics()
    one, other = (
        [line[f"body.{name}.momentum-x"] / line[f"body.{name}.mass"] for name in "ab"]
        for line in (first, last)
    )
    assert least < (other[1] - other[0]) / (one[0] - one[1]) < 1.0
    size = abs(first["body.a.momentum-x"])
    assert abs(last["momentum-x"] - first["momentum-x"]) < 1e-11 * size
    assert energy(last) < energy(first)
