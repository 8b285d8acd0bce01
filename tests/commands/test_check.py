"""``pgimp check`` points at mistakes of units, of the step and of the duration."""

import pytest
from messages import mentions

from pgimp.case.reader import read_case
from pgimp.commands import check
from pgimp.commands.init import packaged
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.running import forecast
from pgimp.running.schedule import Schedule
from pgimp.scene.facts import examine
from pgimp.scene.sanity import body_warnings, case_warnings, small_step_warning, strains
from pgimp.scene.scene import Scene, count_particles
from pgimp.tools.check.steps import report_stages

# A steel block of 0.1 m on a floor, in each of two consistent sets of units, and mixed up.
SI = {"units": "m, kg, s", "young": 2.1e11, "density": 7850.0, "side": 0.1, "gravity": 9.81}
MM = {"units": "mm, t, s", "young": 2.1e5, "density": 7.85e-9, "side": 100.0, "gravity": 9810.0}
BLOCK = """
format: 1
units: {units}
dimensions: 1
grid: {{size: [{twice}], cell: [{cell}]}}
method: {{shape: gimp, particles_per_cell: [2]}}
time: {{end: {end}, step: {{courant: 0.3}}}}
materials: {{steel: {{model: linear-1d, young: {young}, density: {density}}}}}
bodies: {{block: {{material: steel, region: {{box: {{min: [0.0], max: [{side}]}}}}}}}}
gravity: [-{gravity}]
boundaries: {{x-min: fixed}}
"""


def block(end=1.0e-3, **of):
    text = BLOCK.format(**of, end=end, twice=2.0 * of["side"], cell=0.1 * of["side"])
    return read_case(text, "block.yaml")


def findings(case):
    scene = Scene(case)
    lattice, counts, _ = count_particles(scene, Serial())
    return examine(scene, lattice, counts)


def facts(case):
    return findings(case).bodies


def said(case):
    return [text for body in facts(case) for text in body_warnings(case, body, case.time.end)]


@pytest.mark.parametrize("units", [SI, MM])
def test_consistent_units_are_not_doubted(units):
    assert said(block(**units)) == []
    (body,) = facts(block(**units))
    strain = units["density"] * units["gravity"] * units["side"] / units["young"]
    assert strains(block(**units), body)["by its own weight"] == pytest.approx(strain)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        # MPa with kg/m^3: soft as a cloud, and as heavy as nothing that there is.
        (MM | {"density": 7850.0}, ["loads of the order", "density 7850 would be 7.85e+15"]),
        # Pa with tonnes and mm: waves a thousand times too fast.
        (MM | {"young": 2.1e11}, ["wave speed 5.172e+09 would be 5.17e+06 m/s"]),
        # GPa in metres.
        (SI | {"young": 210.0}, ["loads of the order"]),
        # g/cm^3 in metres.
        (SI | {"density": 7.85e-3}, ["density 0.00785 would be 0.00785 kg/m^3"]),
        (SI | {"units": "SI"}, []),
        # Nothing is known of other units.
        (SI | {"density": 7.85e-3, "units": "none"}, []),
    ],
)
def test_units_mixed_up(change, expected):
    texts = said(block(**change))
    assert all(any(words in text for text in texts) for words in expected), texts
    assert bool(texts) == bool(expected)


def test_loads_of_every_kind():
    """Of a bar with wave speed 1000 and modulus 1e6."""
    case = read_case(
        """
format: 1
dimensions: 1
grid: {size: [20.0], cell: [1.0]}
method: {shape: gimp, particles_per_cell: [2]}
time: {end: 0.1, step: {courant: 0.3}}
materials: {bar: {model: linear-1d, young: 1.0e6, density: 1.0}}
bodies:
  bar: {material: bar, velocity: [-30.0], region: {box: {min: [5.0], max: [15.0]}}}
  free: {material: bar, region: {box: {min: [16.0], max: [18.0]}}}
gravity: {table: [[0.0, [0.0]], [1.0, [-4000.0]], [2.0, [10.0]]]}
boundaries: {x-min: {velocity: [{table: [[0.0, 0.0], [1.0, -50.0]]}]}}
tractions: {pull: {body: bar, face: x-max, pressure: {table: [[0.0, 1.0e5], [1.0, -2.0e5]]}}}
constraints: {grip: {body: bar, region: {box: {min: [5.0], max: [6.0]}}, velocity: [-70.0]}}
"""
    )
    bar, free = (strains(case, body) for body in facts(case))
    assert bar == pytest.approx(
        {
            "by its own weight": 0.04,
            "by stopping its velocity": 0.03,
            "by its tractions": 0.2,
            "by prescribed velocities": 0.07,
        }
    )
    assert free["by prescribed velocities"] == pytest.approx(0.05)
    assert "by its tractions" not in free


@pytest.mark.parametrize(
    ("end", "expected"),
    [
        (1.0e-6, ["time.end: until then a wave crosses only 0.052 of block"]),  # 0.1 m at 5172 m/s
        (100.0, ["time.end: waves cross block 5.17e+06 times until then"]),
    ],
)
def test_durations(end, expected):
    texts = said(block(end=end, **SI))
    assert len(texts) == 1
    assert texts[0].startswith(expected[0])


@pytest.mark.parametrize(("dt", "fewer"), [(1.0e-3, "300 times fewer"), (0.02, "")])
def test_step_that_is_far_too_short(dt, fewer):
    text = small_step_warning(dt, 1.0)
    assert (fewer in text) and bool(text) == bool(fewer)


@pytest.fixture
def unmeasured(monkeypatch):
    """A report without what compiles and measures."""
    monkeypatch.setattr(check, "measure", lambda *scene: (None, 0.0))
    monkeypatch.setattr(check, "pilot", lambda *case: None)
    monkeypatch.setattr(check, "report_cost", lambda *scene: None)


@pytest.mark.parametrize(("speed", "fewer"), [(0.0, 44), (1.0, 70)])
def test_the_report_says_what_chosen_steps_save(speed, fewer, capsys, unmeasured):
    """0.54 of a cell by waves in place of 0.3; half a cell, where that counts c + |v| = 2 c."""
    case = block(**SI)
    velocity = speed * (SI["young"] / SI["density"]) ** 0.5
    body = case.every_body["block"].model_copy(update={"velocity": (velocity,)})
    case = case.model_copy(update={"every_body": {"block": body}})
    check.report(case)
    assert f": {fewer} % fewer steps" in capsys.readouterr().out
    step = case.time.step.model_copy(update={"courant": "auto"})
    check.report(case.model_copy(update={"time": case.time.model_copy(update={"step": step})}))
    said = capsys.readouterr().out
    assert "chosen by pgimp" in said and "fewer steps" not in said
    assert "warning: time.step" not in said


def test_the_report_has_the_warnings(capsys, unmeasured):
    """A step of a tenth of a thousandth of what is stable, in a block with mixed units."""
    case = block(**(MM | {"density": 7850.0}), end=1.0)
    case = case.model_copy(update={"time": case.time.model_copy(update={"step": 1.0e-4})})
    check.report(case)
    warnings = [line for line in capsys.readouterr().out.splitlines() if "warning: " in line]
    about = ["time.step", "bodies.block", "materials of block: density", "materials", "time.end"]
    assert all(f"warning: {words}" in line for words, line in zip(about, warnings, strict=True))
    assert warnings[0].startswith("warning: time.step: 0.0001 is a Courant number of 5.17e-05")


def test_packaged_cases_are_not_doubted():
    for name, text in packaged().items():
        if "/" not in name:
            assert said(read_case(text, name)) == [], name


PLATE = """
format: 1
dimensions: 2
grid: {size: [10.0, 4.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles_per_cell: [2, 2]}
time: {end: 1.0, step: {courant: 0.3}}
materials: {m: {model: hooke, young: 1.0e+6, poisson: 0.0, density: 1000.0}}
bodies: {beam: {material: m, region: {box: {min: [0.0, 1.0], max: [8.0, 2.0]}}}}
"""


def plate(*more):
    return read_case(PLATE + "\n".join(more), "plate.yaml")


def test_a_constraint_that_holds_nothing_is_refused_as_by_a_run(monkeypatch):
    """Whatever the block that its particles come in, and if a later one takes them all."""
    from pgimp.solver import setup
    from pgimp.solver.simulation import Simulation

    monkeypatch.setattr(setup, "warm_up", lambda *_: pytest.fail("kernels were compiled"))
    held = "{body: beam, velocity: [0.0, 0.0], region: {box: {min: [%s, 1.0], max: [%s, 2.0]}}}"
    between = f"constraints: {{grip: {held % (0.3, 0.36)}}}"
    after = f"constraints: {{grip: {held % (0.3, 1.0)}, more: {held % (0.0, 2.0)}}}"
    said = []
    for text in (between, after):
        for build in (findings, lambda case: Simulation(case, Serial())):
            with pytest.raises(CaseError, match=r"grip\.region: holds no particle") as caught:
                build(plate(text))
            said.append(str(caught.value))
    assert said[0] == said[1] and said[2] == said[3]
    found = findings(plate(f"constraints: {{grip: {held % (0.3, 1.0)}}}"))
    assert found.held[1] == 3 * 4  # centres at 0.375, 0.625 and 0.875, in four rows


def test_facts_of_a_body_that_turns_and_is_cut():
    """A box from 0.1 into its first particle's, whose cut particles count by their volume."""
    text = "velocity: {rotation: {about: [0.0, 1.5], rate: 2.0}}, "
    case = read_case(PLATE.replace("min: [0.0, 1.0]", "min: [0.1, 1.0]").replace(
        "{material", "{" + text + "material"), "x")  # fmt: skip
    (beam,) = facts(case)
    assert (beam.low, beam.high) == ((0.1, 1.0), (8.0, 2.0))
    assert beam.sizes == pytest.approx((7.9, 1.0))
    assert beam.velocity == pytest.approx((0.0, 2.0 * 4.05))  # of the centre of mass
    assert not beam.rigid
    (rest,) = facts(plate())
    assert rest.rigid and rest.velocity == (0.0, 0.0)


def concerns(case):
    return list(case_warnings(case, findings(case)))


def test_thin_bodies_probes_without_particles_and_idle_tractions():
    assert concerns(plate()) == []
    (text,) = concerns(read_case(PLATE.replace("max: [8.0, 2.0]", "max: [8.0, 1.4]"), "x"))
    assert text.startswith("bodies.beam.region: fewer cells across it than one, 0.8 along y;")
    assert concerns(read_case(PLATE.replace("max: [8.0, 2.0]", "max: [8.0, 1.5]"), "x")) == []
    probes = "probes: {there: {place: [8.2, 1.5]}, nothing: {place: [9.5, 1.5]}}"
    (text,) = concerns(plate(probes))
    assert text.startswith("probes.nothing.place: no particle within a cell of it at the start")
    pull = "tractions: {pull: {body: beam, face: x-min, traction: [1.0, 0.0]}}"
    (text,) = concerns(plate(pull, "boundaries: {x-min: fixed}"))
    assert text.startswith("tractions.pull: the face x-min of 'beam' lies at the domain's, whose")
    assert concerns(plate(pull, "boundaries: {x-min: slip}")) == []
    assert concerns(plate(pull, "boundaries: {x-max: fixed}")) == []


def test_points_with_affine_are_doubted():
    methods = ("gimp, affine: true", "mpm, affine: false", "mpm, affine: true")
    cases = [PLATE.replace("shape: gimp", f"shape: {method}") for method in methods]
    said = [concerns(read_case(case, "x")) for case in cases]
    assert said[:2] == [[], []]
    assert said[2][0].startswith("method.affine: with points (mpm) it can make energy from nothing")


def test_contact_of_thin_bodies_and_of_points_is_doubted():
    contact = "contact: [{bodies: [beam, sheet]}]"

    def doubts(top, shape="gimp", law=contact):
        sheet = f"{{material: m, region: {{box: {{min: [0.0, 2.2], max: [8.0, {top}]}}}}}}"
        text = PLATE.replace("shape: gimp", f"shape: {shape}")
        text = text.replace("bodies: {", f"bodies: {{sheet: {sheet}, ") + law
        return [said for said in concerns(read_case(text, "x")) if said.startswith("contact: ")]

    assert doubts(3.4) == []
    (text,) = doubts(2.6)
    assert text.startswith("contact: 'sheet' has both its sides in one cell")
    assert doubts(2.6, law="contact: [{bodies: all, law: tied}]") == []
    (text,) = doubts(3.4, "mpm")
    assert text.startswith("contact: of points (mpm) the gap between bodies is known to half a")


def test_affine_on_few_cells_is_doubted():
    method = "shape: gimp, affine: true"
    for cells, number in (("max: [1.4, 2.0]", 1), ("max: [1.5, 2.0]", 0)):
        case = PLATE.replace("shape: gimp", method).replace("max: [8.0, 2.0]", cells)
        said = [text for text in concerns(read_case(case, "x")) if "method.affine" in text]
        assert len(said) == number
        assert all("'beam' is only 2.8 cells long" in text for text in said)


# rho g = 1000 x 2, E = 1e6; a beam of 8 by 1.
@pytest.mark.parametrize(
    ("held", "words", "strain"),
    [
        ("boundaries: {x-min: fixed}", "cantilever from x-min (its end sinks by about 12)", 0.384),
        ("boundaries: {x-min: fixed, x-max: slip}", "cantilever from x-min", 0.384),
        ("boundaries: {y-min: fixed}", "", 0.002),
        ("boundaries: {x-min: slip}", "", 0.002),
        ("", "", 0.002),
        (
            "constraints: {grip: {body: beam, velocity: [0, 0], "
            "region: {box: {min: [0, 1], max: [2, 2]}}}}",
            "cantilever from constraint grip (its end sinks by about 3.9)",
            0.216,
        ),
        (
            "boundaries: {x-min: fixed}\nconstraints: {grip: {body: beam, velocity: [null, 0], "
            "region: {box: {min: [7, 1], max: [8, 2]}}}}",
            "beam between x-min and constraint grip",
            0.5 * 2000.0 * 49.0 / 1e6,
        ),
        # On something that holds it along all its length it does not bend.
        (
            "boundaries: {x-min: fixed}\nconstraints: {bed: {body: beam, velocity: [0, 0], "
            "region: {box: {min: [0, 1], max: [8, 1.3]}}}}",
            "",
            0.002,
        ),
    ],
)
def test_strain_by_its_own_weight_is_that_of_what_holds_a_body(held, words, strain):
    """3 rho g l^2/(E h), a sixth of it between two clamps, or rho g h/E as a column."""
    case = plate("gravity: [0.0, -2.0]", held)
    (beam,) = facts(case)
    found = {w: x for w, x in strains(case, beam).items() if w.startswith("by its own weight")}
    first = next(iter(found))
    assert words in first and ("as a" in first) == bool(words)
    assert found[first] == pytest.approx(strain)
    if words:
        assert found["by its own weight as a column"] == pytest.approx(0.002)


@pytest.mark.parametrize(
    ("output", "expected"),
    [
        ("", None),
        ("output: {every: 0.5}", None),
        ("output: {every: 1.0}", None),
        ("output: {every: 5.0}", "output.every: 5 is beyond the end at 1; there are frames only"),
        ("output: {every: {steps: 3000}}", "output.every: 3,000 steps are more than the run takes"),
        ("output: {every: 1.0e-5}", None),
        ("history: {every: 2.0}", "history.every: 2 is beyond the end at 1; there are lines only"),
        ("checkpoint: {every: 2.0}", "checkpoint.every: 2 is beyond the end at 1; there are no"),
        ("checkpoint: {every: {wall: 9.0}}", None),
        ("probes: {p: {place: [1, 1], every: 3}}", "probes.p.every: 3 is beyond the end at 1"),
    ],
)
def test_output_that_never_falls_due(output, expected):
    found = list(forecast.warnings(plate(output), 2000.0))
    assert [text[: len(expected)] for text in found] == [expected] if expected else not found


@pytest.mark.parametrize(
    ("output", "number"),
    [
        ("", 2),
        ("output: {every: 0.3}", 5),
        ("output: {every: 0.1, at: [0.05, 1.0]}", 12),
        ("output: {every: {steps: 7}}", 4),
        ("output: {every: 1.0e-9}", 21),
        ("output: {every: 1.0}", 2),
    ],
)
def test_number_of_frames(output, number):
    """By the schedule that a run keeps to, in 20 steps."""
    case = plate(output)
    schedule = Schedule(case.output.every, case.output.at)
    steps = [n for n in range(1, 21) if schedule.due(n / 20, n, 0.05)]
    assert len({0, 20, *steps}) == number == forecast.frames(case, 20.0)


@pytest.mark.parametrize(
    ("poisson", "method", "expected"),
    [
        (0.499, "shape: gimp", "0.499 is nearly incompressible"),
        (0.499, "shape: mpm", "with boxes (shape: gimp)"),
        (0.499, "shape: gimp, volumetric: mean", ""),
        (0.499, "shape: fuzzy-constant", ""),
        (0.4, "shape: gimp", ""),
    ],
)
def test_locking_is_foreseen(poisson, method, expected):
    case = read_case(
        f"""
format: 1
dimensions: 2
grid: {{size: [4.0, 4.0], cell: [1.0, 1.0]}}
method: {{{method}, particles_per_cell: [1, 1]}}
time: {{end: 1.0, step: {{courant: 0.3}}}}
materials: {{rubber: {{model: neo-hookean, young: 1.0, poisson: {poisson}, density: 1.0}}}}
bodies: {{block: {{material: rubber, region: {{box: {{min: [1.0, 1.0], max: [3.0, 3.0]}}}}}}}}
"""
    )
    texts = [text for text in said(case) if "poisson" in text]
    assert len(texts) == bool(expected)
    assert all(expected in text and "volumetric: mean" in text for text in texts)


def test_stages_are_listed_with_their_steps_and_changes(capsys):
    case = block(**SI)
    first = case.stages[0]
    data = case.model_dump(by_alias=True)
    data["time"]["stages"] = [
        {"name": "hot", "end": 2.0e-3, "materials": {"steel": {"young": 8.4e11}}},
        {"name": "loose", "end": 2.5e-3, "step": 1.0e-7, "boundaries": {"x-min": None}},
        {"name": "same", "end": 3.0e-3, "output": {"every": 1.0e-4}},
    ]
    staged = type(case).model_validate(data)
    (body,) = facts(first)
    steps = report_stages(staged, [Scene(each) for each in staged.stages], 1.0, {})
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    # Twice the wave speed takes twice the steps: 0.3 cells each.
    hot = 2.0 * body.wave_speed * 1.0e-3 / (0.3 * 0.01)
    assert steps == pytest.approx(hot + 5000 + 5000, abs=1.0)
    first, second, third = lines
    mentions(first, "stage 2", "hot", "0.002", "about", "steps", "materials.steel.young")
    mentions(second, "stage 3", "loose", "0.0025", "5,000 steps", "boundaries.x-min")
    mentions(third, "stage 4", "same", "0.003", "5,000 steps", "output.every")
    assert "young" not in second and "boundaries" not in third
    # At the start, at the end of each stage, and four times in the last one.
    assert forecast.frames(staged, 15_000.0) == 5 + 4
