"""What the history tells of energy when a stage or a file brings other parameters or states.

A block that has been squashed against a wall; with the next stage nothing moves at once.
"""

import numpy as np
import pytest
from point_files import write_csv
from run_files import digests
from scenes import box, field, finish, scene, start
from staged_bar import entered

import pgimp
from pgimp.mpi.comm import Serial

METAL = {
    "model": "von-mises", "young": 100.0, "poisson": 0.3, "density": 1.0, "yield-stress": 2.0,
}  # fmt: skip
HOT = {
    "model": "johnson-cook", "young": 100.0, "poisson": 0.3, "density": 1.0, "a": 2.0,
    "temperature": 300.0, "melting": 1000.0, "specific-heat": 0.1,
}  # fmt: skip
SOIL = {
    "model": "mohr-coulomb", "young": 100.0, "poisson": 0.3, "density": 1.0, "cohesion": 1e3,
    "friction-angle": 30.0,
}  # fmt: skip
VOCE = {"stress": 1.0, "rate": 5.0}
HIT = 0.3


def block(material, *stages):
    """The case of the block, with the changes of its material in stages."""
    case = scene(
        2, box([0.0, 1.0], [3.0, 4.0], [-3.0, 0.5]), end=HIT,
        boundaries={"x-min": "slip", "y-min": "slip"}, history={"every": 0.1},
    )  # fmt: skip
    case["materials"] = {"soft": material}
    case["time"]["stages"] = [
        {"name": f"stage{i}", "end": HIT + 0.1 * i, "materials": {"soft": changes}}
        for i, changes in enumerate(stages, 1)
    ]
    return case


@pytest.mark.parametrize(
    ("material", "changes"),
    [
        (METAL, {"yield-stress": 1.0, "hardening": 10.0}),
        (METAL | {"saturation": VOCE}, {"saturation": VOCE | {"rate": 50.0}}),
        (HOT, {"specific-heat": 0.5}),
    ],
)
def test_work_that_was_done_stays_what_it_was(material, changes):
    """Of another yield stress or heat capacity the strain and temperature so far know nothing."""
    sim, before = entered(block(material, changes))
    now = sim.diagnostics()
    assert before["plastic-work"] > 0.1
    for name in {"plastic-work", "heat", "dissipated-energy"} & {*before}:
        assert now[name] == pytest.approx(before[name], rel=1e-12), name
    later = finish(sim).diagnostics()
    assert later["plastic-work"] > now["plastic-work"]


def test_that_is_kept_when_runs_go_on_from_stage_to_stage(tmp_path):
    options = {"comm": Serial(), "quiet": True}
    changes = {"yield-stress": 1.0}, {"hardening": 9.0}
    together = pgimp.run(block(METAL, *changes), output=tmp_path / "together", **options)
    for stages in range(3):
        case = block(METAL, *changes[:stages])
        folder = pgimp.run(case, output=tmp_path / "parts", resume=bool(stages), **options).path
    assert digests(folder) == digests(together.path)
    assert (np.diff(together.history["plastic-work"]) >= 0.0).all()


def test_a_soil_of_half_the_stiffness_has_half_the_energy():
    """Its stress follows from a stretch that it remembers, to which half the moduli give half."""
    sim, before = entered(block(SOIL, {"young": 50.0}))
    now = sim.diagnostics()
    assert before["strain-energy"] > 1.0
    assert now["strain-energy"] == pytest.approx(0.5 * before["strain-energy"], rel=1e-12)
    assert now["dissipated-energy"] == pytest.approx(before["dissipated-energy"], abs=1e-12)
    sim.advance()
    # What one step loses; half the energy would be a hundred times as much.
    step = sim.diagnostics()["dissipated-energy"] - now["dissipated-energy"]
    assert abs(step) < 0.01 * before["strain-energy"]


def test_what_a_file_says_of_the_time_before_is_not_of_this_run(tmp_path):
    path = tmp_path / "hot.csv"
    particles = {"position": np.array([[1.5, 1.5], [2.5, 1.5]]), "volume": np.ones(2)}
    before = {"plastic-work": [0.25, 0.5], "temperature": [500.0, 600.0]}
    write_csv(path, particles, **before)
    case = scene(2, {"material": "soft", "region": {"points": {"file": str(path)}}}, per_cell=1)
    case["materials"] = {"soft": HOT}
    line = start(case).diagnostics()
    assert line["plastic-work"] == line["heat"] == 0.0


@pytest.mark.parametrize("material", ["neo-hookean", "von-mises"])
def test_a_skin_that_its_body_leaves_does_not_jump(material):
    """Mean dilatation: particles of which others leave keep their volumes and energy."""
    model = {"model": material, "young": 1000.0, "poisson": 0.49, "density": 1.0}
    if material == "von-mises":
        model |= {"yield-stress": 20.0}
    bodies = {"thick": box([2.0, 1.0], [6.0, 3.0]), "skin": box([2.0, 3.0], [6.0, 3.15])}
    clamp = {"body": "thick", "region": {"box": {"min": [2.0, 1.0], "max": [3.0, 3.0]}}}
    case = scene(
        2, {name: body | {"formulation": "total-lagrangian"} for name, body in bodies.items()},
        cells=[8, 6], end=0.6, step={"courant": 0.05}, gravity=[0.0, -40.0],
        constraints={"clamp": clamp | {"velocity": [0.0, 0.0]}}, materials={"soft": model},
    )  # fmt: skip
    case["method"]["volumetric"] = "b-bar"
    case["time"]["stages"] = [
        {"name": "skinned", "end": 0.7, "remove": ["thick"], "constraints": {"clamp": None}}
    ]
    sim = start(case)
    while not sim.stage_done:
        sim.advance()
    sim.next_stage()
    line, volumes, ratio = sim.diagnostics(), field(sim, "V"), field(sim, "fbar_ratio")
    assert abs(ratio - 1.0).max() > 0.05
    sim.advance()
    then = sim.diagnostics()
    # A step changes 1e-3 of them; a jump to ratios of 1 tenths, paid for by what was dissipated.
    np.testing.assert_allclose(field(sim, "V"), volumes, rtol=0.01)
    for name in ("strain-energy", "dissipated-energy"):
        assert abs(then[name] - line[name]) < 0.01 * line["dissipated-energy"], name
