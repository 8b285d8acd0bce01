"""Stages as a case has them: each is a case of its own, checked before the first step."""

import re

import pytest
from scenes import SOFT, box, scene

import pgimp
from pgimp.case.reader import dump_case, read_case
from pgimp.case.staging.arrange import changes_of, steps_in
from pgimp.errors import CaseError, UsageError

SOIL = {
    "model": "mohr-coulomb", "young": 100.0, "poisson": 0.3, "density": 1.0, "cohesion": 1.0,
    "friction_angle": 20.0,
}  # fmt: skip
LOW, HIGH = [0.0, 0.0], [3.0, 3.0]
GRIP = {"body": "rest", "region": {"box": {"min": [0.0, 0.0], "max": [1.0, 3.0]}}}


def staged(*stages, **parts):
    """A case of two boxes, of soil and of a soft solid, with all that a stage may change."""
    bodies = {
        "rest": box(LOW, HIGH, material="soil"),
        "block": box([3.0, 0.0], [5.0, 3.0]),
        "tool": {"rigid": {}, "region": {"box": {"min": [0.0, 4.0], "max": [6.0, 6.0]}}},
    }
    case = scene(
        2,
        bodies,
        **{
            "materials": {"soil": SOIL, "soft": SOFT},
            "gravity": [0.0, -1.0],
            "boundaries": {"x-min": "slip", "y-min": "fixed"},
            "tractions": {"push": {"body": "block", "face": "y-max", "pressure": 1.0}},
            "constraints": {"grip": {**GRIP, "velocity": [0.0, None]}},
            "contact": [{"bodies": ["block", "tool"]}, {"bodies": "all", "friction": 0.2}],
            "output": {"every": 0.5, "at": [0.3, 1.5]},
        }
        | parts,
    )
    case["time"]["stages"] = list(stages)
    return case


def stage(name="next", end=2.0, **changes):
    return {"name": name, "end": end, **changes}


def test_a_stage_is_the_case_before_it_with_the_changes():
    first, second, third = pgimp.load(
        staged(
            stage(
                materials={"soil": {"friction-angle": 25.0}},
                tractions={"push": {"pressure": 2.0}},
                constraints={"grip": {"velocity": [1.0, 0.5]}, "more": GRIP | {"velocity": [0, 0]}},
                boundaries={"x-min": None, "y-min": {"unilateral": {"friction": 0.3}}},
                method={"relaxation": 3.0},
                output={"every": None},
                remove=["tool"],
            ),
            stage("last", 3.0, gravity=None, step={"courant": 0.2}, tractions={"push": None}),
        )
    ).stages
    assert (first.time.end, second.time.end, third.time.end) == (1.0, 2.0, 3.0)
    assert second.materials["soil"].friction_angle == 25.0  # whichever way it is spelled
    assert second.materials["soil"].cohesion == third.materials["soil"].cohesion == 1.0
    push = second.tractions["push"]
    assert (push.body, push.pressure) == ("block", 2.0) and third.tractions == {}
    assert second.constraints["grip"].region == first.constraints["grip"].region
    assert set(second.boundaries) == {"y-min"} and second.boundaries["y-min"].friction == 0.3
    assert (first.method.relaxation, third.method.relaxation) == ("auto", 3.0)
    assert (first.output.every, second.output.every) == (0.5, None)
    assert second.rigid_bodies == {} and [entry.bodies for entry in second.contact] == ["all"]
    assert (second.gravity, third.gravity) == ((0.0, -1.0), None)
    assert (second.time.step, third.courant) == (0.01, 0.2)
    assert [each.output.at for each in (first, second, third)] == [(0.3,), (1.5,), ()]
    # What constraints have prescribed so far: none along y, 0 and 1 along x.
    assert third.staged.displacements["grip"] == (-1.0, -0.5)


def test_a_case_without_stages_is_its_own_only_stage():
    case = pgimp.load(scene(2, box(LOW, HIGH)))
    assert case.stages == (case,) and case.stages[0] is case
    assert case.staged.number == 0 and case.time.last == case.time.end == 1.0


def test_a_case_with_stages_is_written_as_it_is_read():
    case = pgimp.load(staged(stage(remove=["block"]), stage("last", 3.0, gravity=None)))
    text = dump_case(case)
    assert "{name: next, end: 2.0, remove: [block]}, {name: last, end: 3.0, gravity: null}" in text
    again = read_case(text)
    assert again == case and again.stages == case.stages
    assert dump_case(again) == text


def test_a_stage_that_is_what_the_one_before_is_changes_nothing():
    first, second = pgimp.load(staged(stage(), output={})).stages
    assert first.model_copy(update={"time": second.time}) == second
    assert first.staged.removed == second.staged.removed == ()


def test_removed_bodies_stay_in_the_case():
    """Numbers of bodies and materials are what they were."""
    case = pgimp.load(staged(stage(remove=["block"], tractions={"push": None})))
    assert [*case.stages[1].bodies] == ["rest", "block"]
    assert case.stages[1].staged.removed == ("block",)


def test_fixed_steps_of_another_length_are_counted_from_the_beginning_of_the_stage():
    case = staged(stage(end=1.9, step=0.3), stage("last", 2.2), stage("end", 2.25, step=0.05))
    stages = pgimp.load(case).stages
    assert [steps_in(each) for each in stages] == [100, 3, 1, 1]
    assert [each.staged.counted for each in stages] == [0.0, 1.0, 1.0, 2.2]


def test_changes_are_listed_for_people():
    change = stage(
        remove=["block"], materials={"soil": {"cohesion": 2.0}}, gravity=None,
        boundaries={"x-min": None},
    )  # fmt: skip
    case = pgimp.load(staged(change, tractions={}))
    assert list(changes_of(case.time.stages[0])) == [
        "remove block", "materials.soil.cohesion", "gravity", "boundaries.x-min",
    ]  # fmt: skip


AWAY = {"box": {"min": [9.0, 0.0], "max": [10.0, 3.0]}}
NOTHING = {"intersection": [GRIP["region"], {"box": {"min": [2.0, 0.0], "max": [3.0, 3.0]}}]}
EXACT = {"vibrating-bar": {"amplitude": 0.01}}


@pytest.mark.parametrize(
    ("change", "key", "text"),
    [
        ({"end": 1.0}, "end", "is not after the end of the stage before, 1"),
        ({"end": 1.005}, "end", "1.005 is not a whole number of steps of 0.01"),
        ({"end": 1.5, "step": 0.3}, "end", "1.5 is not 1 and a whole number of steps of 0.3"),
        ({"remove": ["blok"]}, "remove.0", "unknown body 'blok'; did you mean 'block'?"),
        ({"remove": ["block", "rest"]}, "remove", "nothing is left"),
        ({"remove": ["block", "block"]}, "remove.1", "block is in the list already"),
        ({"materials": {"sol": {"young": 1.0}}}, "materials.sol", "did you mean 'soil'?"),
        ({"materials": {"soil": {"density": 2.0}}}, "materials.soil.density", "keep the mass"),
        ({"materials": {"soil": {"model": "hooke"}}}, "materials.soil.model", "not reached"),
        ({"materials": {"soil": {"cohesion": -1.0}}}, "materials.soil.cohesion", "at least 0"),
        ({"materials": {"soil": None}}, "materials.soil", "not a material"),
        (
            {"remove": ["block"], "tractions": {"push": {"pressure": 2.0}}},
            "tractions.push",
            "acts on 'block', which has been removed",
        ),
        (
            {"remove": ["rest"], "constraints": {"grip": {"velocity": [0, 0]}}},
            "constraints.grip",
            "acts on 'rest', which has been removed",
        ),
        (
            {"remove": ["block"], "contact": [{"bodies": ["tool", "block"]}]},
            "contact.0.bodies.1",
            "'block' has been removed",
        ),
        (
            {"constraints": {"hold": GRIP | {"velocity": [0, 0], "region": AWAY}}},
            "constraints.hold.region",
            "beyond the domain",
        ),
        (
            {"constraints": {"hold": GRIP | {"velocity": [0, 0], "region": NOTHING}}},
            "constraints.hold.region",
            "is empty",
        ),
        ({"tractions": {"pull": None}}, "tractions.pull", "there is none to end"),
        ({"outflow": {"x-mux": None}}, "outflow.x-mux", "there is none to end"),
        ({"materials": {"soil": 3.0}}, "materials.soil", "expected a mapping of the keys"),
        ({"tractions": {"pull": {"pressure": 1.0}}}, "tractions.pull", "the pressure 0"),
        ({"tractions": {"push": {"face": "x-max"}}}, "tractions.push.face", "cannot change"),
        ({"constraints": {"old": None}}, "constraints.old", "there is none to end"),
        ({"constraints": {"hold": {"velocity": [0, 0]}}}, "constraints.hold.body", "missing"),
        ({"boundaries": {"x-mid": "slip"}}, "boundaries.x-mid", "unknown face 'x-mid'"),
        ({"boundaries": {"x-mn": None}}, "boundaries.x-mn", "did you mean 'x-min'?"),
        ({"outflow": {"x-min": "remove"}}, "outflow.x-min", "has a condition"),
        ({"gravity": [1.0]}, "gravity", "expected 2 entries"),
        ({"method": {"affine": True}}, "method.affine", "only pic-damping can"),
        ({"output": {"at": [1.5]}}, "output.at", "is for all stages"),
        ({"output": {"fields": ["displacement"]}}, "output.fields", "initial positions"),
        ({"output": {"evry": 2.0}}, "output.evry", "did you mean 'every'?"),
        ({"grid": {"cell": [1.0, 1.0]}}, "grid", "unknown key"),
        ({"contact": [{"bodies": ["rest", "tol"]}]}, "contact.0.bodies.1", "unknown body 'tol'"),
    ],
)
def test_what_a_stage_cannot_be_is_said_with_its_place(change, key, text):
    case = staged({"name": "next", "end": 2.0} | change, output={"every": 0.5})
    with pytest.raises(CaseError) as caught:
        pgimp.load(case)
    (line, *_) = str(caught.value).splitlines()
    assert line.startswith(f"case: time.stages.0.{key}") and text in line, line


def test_a_material_that_varies_keeps_its_parameters():
    """Said before anything else, such as frames' fields that then would not be there."""
    soil = SOIL | {"young": {"layers": [[0.0, 50.0], [1.0, 100.0]], "over": "y"}}
    parts = {"materials": {"soil": soil, "soft": SOFT}, "output": {"fields": ["parameter-young"]}}
    case = staged(stage(materials={"soil": {"young": 3.0}}), **parts)
    with pytest.raises(CaseError, match=r"time\.stages\.0\.materials\.soil: varies in space"):
        pgimp.load(case)


def test_mistakes_name_file_line_and_stage():
    text = dump_case(pgimp.load(staged(stage(materials={"soil": {"cohesion": 2.0}}))))
    bad = text.replace("materials: {soil: {cohesion: 2.0}}", "materials: {soil: {cohesion: no}}")
    assert bad != text
    number = next(i for i, line in enumerate(bad.splitlines(), 1) if "cohesion: no" in line)
    with pytest.raises(CaseError, match=f"^dig.yaml:{number}: time.stages.0.materials.soil.coh"):
        read_case(bad, "dig.yaml")
    other = staged(stage(), stage("last", 3.0, remove=["rest"]), stage("next", 4.0))
    with pytest.raises(CaseError, match=r"time\.stages\.2\.name: another stage has this name"):
        pgimp.load(other)
    with pytest.raises(CaseError, match=r"time\.stages\.1\.remove.0: unknown body 'block'"):
        pgimp.load(staged(stage(remove=["block"]), stage("last", 3.0, remove=["block"])))


def test_what_particles_have_from_the_start_only_cannot_change():
    clay = {
        "model": "cam-clay", "m": 1.2, "lambda": 0.2, "kappa": 0.05, "void-ratio": 1.0,
        "density": 1.0, "shear": 30.0, "preconsolidation": 2.0,
    }  # fmt: skip
    metal = {"model": "von-mises", "young": 1.0, "poisson": 0.3, "density": 1.0}
    metal |= {"yield-stress": 0.1}
    for model, change, text in (
        (clay, {"preconsolidation": 3.0}, "preconsolidation: cannot change in a stage"),
        (metal, {"kinematic": 1.0}, r"would remember other quantities \(back-stress\)"),
        (metal | {"kinematic": 1.0}, {"kinematic": 0.0}, "would remember back-stress no more"),
    ):
        materials = {"soil": model, "soft": SOFT}
        pgimp.load(staged(stage(), materials=materials))
        with pytest.raises(CaseError, match=text):
            pgimp.load(staged(stage(materials={"soil": change}), materials=materials))
    pgimp.load(staged(stage(materials={"soil": {"m": 1.0}}), materials=materials | {"soil": clay}))


def test_contact_cannot_begin_and_exact_solutions_know_no_stages():
    case = staged(stage(contact=[{"bodies": "all"}]), contact=[])
    del case["bodies"]["tool"]
    with pytest.raises(CaseError, match=r"time\.stages\.0\.contact: surfaces of the bodies"):
        pgimp.load(case)
    bar = scene(1, box([0.0], [4.0]), boundaries={"x-min": "fixed"}, exact=EXACT)
    pgimp.load(bar)
    bar["time"]["stages"] = [stage()]
    with pytest.raises(CaseError, match="exact: is the solution of a case without stages"):
        pgimp.load(bar)


@pytest.mark.parametrize(("low", "fixed", "allowed"), [
    (-3.0, ["x", "rotation"], False), (0.0, ["x", "rotation"], True), (-3.0, ["rotation"], True),
])  # fmt: skip
def test_planes_of_symmetry_of_free_rigid_bodies_stay(low, fixed, allowed):
    """What of a body lies beyond has no mass: with another face it would begin to have one."""
    hammer = {
        "rigid": {"density": 1.0, "fixed": fixed},
        "region": {"box": {"min": [low, 5.0], "max": [3.0, 7.0]}},
    }
    slip = {"x-min": "slip"}
    for first, then in ((slip, {"x-min": None}), ({}, slip), (slip, {"x-min": "unilateral"})):
        case = scene(2, {"block": box([0.0, 0.0], [4.0, 4.0]), "hammer": hammer}, boundaries=first)
        case["time"]["stages"] = [{"name": "next", "end": 2.0, "boundaries": then}]
        if allowed:
            pgimp.load(case)
            continue
        with pytest.raises(CaseError, match=r"boundaries\.x-min: .*'hammer' reaches across"):
            pgimp.load(case)
        case["time"]["stages"][0]["remove"] = ["hammer"]
        pgimp.load(case)


def test_a_study_of_accuracy_wants_one_stage(tmp_path):
    from pgimp.utilities.study.accuracy import study_of

    path = tmp_path / "dig.yaml"
    path.write_text(dump_case(pgimp.load(staged(stage()))))
    with pytest.raises(UsageError, match="has stages"):
        study_of(path, tmp_path / "study.yaml")


def test_a_face_that_a_stage_closes_and_the_case_leaves_by_is_blamed_on_the_stage():
    text = dump_case(pgimp.load(staged(stage(boundaries={"x-max": "slip"}))))
    bad = re.sub(r"\noutflow: .*", "", text) + "outflow: {x-max: remove}\n"
    with pytest.raises(CaseError) as caught:
        read_case(bad, "dig.yaml")
    (line,) = str(caught.value).splitlines()
    assert ": time.stages.0.boundaries.x-max: outflow.x-max: x-max has a condition" in line
    assert "{x-max: slip}" in bad.splitlines()[int(line.split(":")[1]) - 1]
