"""A block under pressure all round, which turns: no torque, and books that close, for long."""

import pytest
from scenes import box, scene, start

EVERYWHERE = {"box": {"min": [0.0, 0.0], "max": [9.0, 9.0]}}


@pytest.mark.parametrize(
    ("configuration", "spin", "books"), [("current", 0.04, 0.1), ("initial", 1e-3, 0.02)]
)
def test_a_pressure_turns_nothing_and_its_work_is_booked(configuration, spin, books):
    """Spin and energy over two turns; the block breathes by the pressure, which sets in at once.

    Its particles keep their size. Their parts of the surface have to turn all the same: left behind
    them they held the block like a pendulum, and it swung back.
    """
    body = box([2.0, 2.0], [7.0, 7.0]) | {
        "velocity": {"rotation": {"about": [4.5, 4.5], "rate": 0.8}},
        "formulation": configuration,
    }
    load = {"body": "body", "region": EVERYWHERE, "pressure": 5.0}
    case = scene(2, body, cells=[9, 9], end=15.7, step={"courant": 0.3}, tractions={"load": load})
    case["method"]["affine"] = True
    sim = start(case)
    first, spun = sim.diagnostics(), []
    while not sim.finished:
        sim.advance()
        if sim.step % 20 == 0:
            line = sim.diagnostics()
            spun.append(line["angular-momentum-z"] / first["angular-momentum-z"])
    energy = line["kinetic-energy"] + line["strain-energy"] - line["external-work"]
    began = first["kinetic-energy"] + first["strain-energy"]
    assert 1.0 - spin < min(spun) < max(spun) < 1.0 + spin
    assert energy / began == pytest.approx(1.0, abs=books)
