"""What ``pgimp check`` says of materials, speeds and steps: each by its key, and only if true."""

import pytest
from checked import PLATE, plate, said
from mentioned import mentions
from scenes import box, scene

from pgimp.case.load import load
from pgimp.case.reader import read_case
from pgimp.commands import check
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.checks import nearness
from pgimp.scene.checks.units import in_si
from pgimp.scene.geometry import share
from pgimp.solver.time.stability import stable_courant
from pgimp.utilities.check.bodies import report_walls
from pgimp.utilities.check.prepare import prepare
from pgimp.utilities.model.costs import Costs
from pgimp.utilities.model.pilot import pilot

METAL = {
    "model": "johnson-cook", "young": 1.24e11, "poisson": 0.34, "density": 8960.0, "a": 9.0e7,
    "b": 2.92e8, "n": 0.31, "c": 0.025, "m": 1.09, "reference-rate": 1.0, "specific-heat": 383.0,
    "temperature": 293.0, "melting": 1356.0,
}  # fmt: skip
WATER = {"model": "newtonian", "bulk": 2.0e9, "shear_viscosity": 1.0e-3, "density": 1000.0}


@pytest.mark.parametrize(
    ("material", "change", "expected"),
    [
        (METAL, {}, []),
        (METAL, {"specific-heat": 0.383}, ["specific-heat: 0.383 would be", "above melting"]),
        (METAL, {"young": 124.0e12}, ["young: 1.24e+14 would be 1.24e+14 Pa"]),
        (WATER, {}, []),
        (WATER, {"bulk": 2.0e15, "density": 1.0}, ["bulk: 2e+15 would be 2e+15 Pa", "are bulk"]),
    ],
)
def test_each_material_is_doubted_by_its_own_numbers(material, change, expected):
    region = {"box": {"min": [0.0, 0.0], "max": [0.1, 0.1]}}
    case = load({
        "format": 1, "units": "SI", "dimensions": 2, "grid": {"size": [0.2, 0.2],
        "cell": [0.01, 0.01]}, "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 1.0e-3, "step": {"courant": 0.3}}, "materials": {"it": material | change},
        "bodies": {"a": {"material": "it", "region": region}},
    })  # fmt: skip
    texts = [text for text in said(case) if "materials.it" in text]
    assert all(any(words in text for text in texts) for words in expected), texts
    assert bool(texts) == bool(expected)
    numbers = in_si(case, "it")
    assert numbers["density"] == ((material | change)["density"], "kg/m^3")


@pytest.mark.parametrize(
    ("change", "where", "words"),
    [
        ({"bodies.a.velocity": [1e20, 0.0]}, "bodies.a.velocity", "'a' crosses 1e+20 cells"),
        ({"materials.soft.young": 1e60}, "materials.soft", "a wave in 'a' crosses"),
        ({"bodies.r": {"rigid": {"velocity": [1e20, 0.0]}, "region": {"box": {
            "min": [7, 3], "max": [8, 5]}}}}, "bodies.r.rigid", "the rigid body 'r' crosses"),
    ],
)  # fmt: skip
def test_what_is_too_fast_is_named(change, where, words):
    bodies = {"a": box([2, 2], [4, 4])}
    case = scene(2, bodies, end=0.1) | {"time": {"end": 0.1, "step": {"courant": 0.3}}}
    with pytest.raises(CaseError) as caught:
        prepare(load(case, change))
    assert str(caught.value).startswith(f"{where}: {words}")
    assert "steps away" in str(caught.value)


@pytest.mark.parametrize(
    ("poisson", "per_cell", "limit"),
    [
        (0.3, 2, 0.325), (0.35, 2, 0.31), (0.4, 2, 0.295), (0.499, 2, 0.26), (0.3, 4, 0.1625),
        (0.3, 1, 0.45), (0.4, 1, 0.4), (0.45, 1, 0.37), (0.499, 1, 0.35),
    ],
)  # fmt: skip
def test_steps_with_mean_dilatation_are_warned_of_where_they_are_unstable(poisson, per_cell, limit):
    """No more than docs/hard-cases.md has, measured with one and two particles a cell."""
    case = scene(3, {"a": box([2] * 3, [4] * 3)}, end=0.1)
    case["method"] |= {"volumetric": "b-bar", "particles-per-cell": [per_cell] * 3}
    case["materials"]["soft"] = {
        "model": "neo-hookean", "young": 1.0, "density": 1.0, "poisson": poisson,
    }  # fmt: skip
    assert stable_courant(load(case)) == pytest.approx(limit)


def test_particles_of_a_file_that_fill_the_cells_at_a_wall_touch_it(tmp_path):
    """Their centres lie half a particle inside."""
    places = [0.125 + 0.25 * i for i in range(8)]
    rows = "".join(f"{x},{y},0.0625\n" for x in places for y in places)
    (tmp_path / "a.csv").write_text("x,y,volume\n" + rows)
    case = scene(2, box([0, 0], [2, 2]), cells=[4, 8], cell=0.5, end=0.01) | {
        "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "fixed"}
    }
    case["bodies"]["body"]["region"] = {"points": {"file": str(tmp_path / "a.csv")}}
    case = load(case)
    share(case, Serial())
    assert nearness.warnings(case) == []


@pytest.fixture
def report(capsys, monkeypatch):
    """What check prints of a case, without what compiles and measures."""
    monkeypatch.setattr(check, "measure", lambda *scene: None)

    def lines(case):
        check.report(case)
        return capsys.readouterr().out.splitlines()

    return lines


SETTLING = "gravity: [0.0, -1.0]\nboundaries: {x-min: fixed}\nstart: {equilibrate: {steps: 700}}\n"


@pytest.mark.parametrize("later", ["", ", stages: [{name: weak, equilibrate: {}}]"])
def test_a_short_time_is_not_doubted_where_a_run_settles(report, later):
    text = PLATE.replace(
        "end: 1.0, step: {courant: 0.3}", f"end: 0.01, step: {{courant: 0.3}}{later}"
    )
    warned = [line for line in report(read_case(text, "x")) if "a wave crosses only" in line]
    assert bool(warned) == (not later)
    said = report(read_case(text + SETTLING, "x"))
    assert not [line for line in said if "a wave crosses only" in line]
    (line,) = (line for line in said if line.startswith("settling"))
    mentions(line, "by estimate in", "at most 700", "not among those above")


def test_a_pilot_run_does_not_count_steps_of_settling():
    case = read_case(PLATE.replace("end: 1.0", "end: 0.1") + SETTLING, "x")
    found = pilot(case, 128, 20.0, Costs(1e-5, ((200.0, 1e-6), (1e6, 1e-6)), 1e-9), 2.0)
    assert found.done == 1.0 and found.steps == pytest.approx(20.0, rel=0.3)


def test_what_makes_the_step_short_is_said_and_advice_knows_it(report):
    """A rigid body at 60 times the speed of waves; the case follows the waves already."""
    fast = {"rigid": {"density": 7800.0}, "velocity": [0.0, -2000.0],
            "region": {"box": {"min": [3.0, 2.5], "max": [5.0, 3.5]}}}  # fmt: skip
    data = plate().model_dump(by_alias=True)
    data["bodies"]["ball"] = fast
    data["contact"] = [{"bodies": ["beam", "ball"]}]
    said = report(load(data))
    (text,) = (line for line in said if line.startswith("warning: time.step"))
    mentions(text, "the rigid body 'ball' crosses 4e+03 cells", "bodies.ball.velocity")
    assert "courant: 0.3" not in text
    (note,) = (line for line in said if "{courant: auto}" in line)
    assert float(note.split("begin with ")[1].split()[0]) < 1.0 / 4000.0
    slow = data | {"time": {"end": 1.0, "step": 1.0e-6}}
    assert any("{courant: 0.3} takes" in line for line in report(load(slow)))


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            {},
            "x-min reflects; x-max moves as prescribed; y-min lets go; y-max absorbs (wall: auto)",
        ),
        ({"method.shape": "cpdi"}, "do not reflect: cpdi needs no mirrors (wall: auto)"),
        ({"bodies.rod.material": "soft"}, "do not reflect: 'rod' is no liquid or gas (wall: auto)"),
        ({"method.wall": "ghost"}, None), ({"method.wall": "mirror"}, None),
        (
            {"method.wall": "mirror", "boundaries.y-min": {"unilateral": {"friction": 0.2}}},
            "no mirrors where there is friction: y-min",
        ),
        ({"boundaries": {}}, None),
        ({"bodies.rod.material": "soft", "bodies.pool.material": "soft"}, None),
    ],
)  # fmt: skip
def test_walls_of_liquids_are_told(change, expected, capsys):
    """Which reflect, and why others do not, where the case leaves it to pgimp."""
    bodies = {
        "pool": box([0, 0], [4, 2], material="water"), "rod": box([5, 0], [6, 2], material="water"),
    }  # fmt: skip
    case = scene(2, bodies, boundaries={
        "x-min": "slip", "x-max": {"velocity": [0.0, None]}, "y-min": "unilateral",
        "y-max": "absorbing",
    })  # fmt: skip
    case["materials"]["water"] = {"model": "newtonian", "bulk": 100.0, "density": 1.0}
    report_walls(load(case, change))
    told = capsys.readouterr().out
    assert told == (f"walls            {expected}\n" if expected else "")
