"""What a case leaves out of its method: chosen by body, from the case alone, and written down."""

import json

import pytest
from scenes import box, scene
from schema_checker import Checker
from two_blocks import CASE

import pgimp
from pgimp.case.choices.beyond import beyond
from pgimp.case.choices.body_rules import MASS, OF_BODIES
from pgimp.case.choices.choose import lines
from pgimp.case.choices.facts import FLOWING
from pgimp.case.choices.kept import kept
from pgimp.case.choices.scene_rules import OF_SCENES
from pgimp.case.choices.written import written
from pgimp.case.reader import read_case
from pgimp.case.writer import dump_case
from pgimp.errors import CaseError
from pgimp.schema.pages import TITLES
from pgimp.utilities.reference.jsonschema import json_schema

WATER = {"model": "newtonian", "bulk": 6.0e5, "density": 1000.0, "shear-viscosity": 1.0e-3}
STEEL = {"model": "von-mises", "young": 2.0e11, "poisson": 0.3, "density": 7800.0,
         "yield-stress": 4.0e8}  # fmt: skip
CLAY = {"model": "mohr-coulomb", "young": 1.0e6, "poisson": 0.3, "density": 1500.0,
        "cohesion": 1.0e3, "friction-angle": 20.0}  # fmt: skip


def bare(dimension, bodies, material=None, **parts):
    """A scene without a method, a step or contact."""
    data = scene(dimension, bodies, cells=[12] * dimension, **parts)
    del data["method"], data["time"]["step"]
    if material:
        data["materials"]["soft"] = material
    return data


def configurations(case):
    return {name: body.formulation for name, body in case.bodies.items()}


def block(velocity=None):
    return box([2.0, 2.0], [5.0, 5.0], velocity)


def test_an_elastic_body_is_in_the_initial_configuration():
    case = pgimp.load(bare(2, block()))
    assert configurations(case) == {"body": "total-lagrangian"}
    assert case.method.shape == "gimp" and case.method.particles_per_cell == (2, 2)
    assert case.bodies["body"].mass == "averaged"  # nothing meets
    assert case.watched and not case.method.affine
    walled = pgimp.load(bare(2, block(), boundaries={"y-min": "unilateral"}))
    assert walled.bodies["body"].mass is None and walled.watched
    assert pgimp.load(bare(1, box([2.0], [5.0]))).method.particles_per_cell == (1,)
    thrown = pgimp.load(bare(1, box([2.0], [5.0]), boundaries={"x-min": "unilateral"}))
    assert thrown.bodies["body"].mass == "averaged" and thrown.watched  # waves in bars


@pytest.mark.parametrize("material", [WATER, CLAY])
def test_what_flows_is_in_the_current_configuration(material):
    case = pgimp.load(bare(2, block(), material))
    assert configurations(case) == {"body": "updated-lagrangian"} and case.method.affine
    assert case.method.volumetric == ("b-bar" if material is CLAY else "pointwise")


def test_liquids_on_walls_without_slip_go_without_affine():
    """Their particles there would be without gradients: Poiseuille's flow is ten times worse."""
    for face, affine in (("fixed", False), ("slip", True)):
        lies = box([0.0, 0.0], [5.0, 5.0])
        assert pgimp.load(bare(2, lies, WATER, boundaries={"y-min": face})).method.affine == affine
        clay = pgimp.load(bare(2, lies, CLAY, boundaries={"y-min": face}))
        assert clay.method.affine


def test_a_metal_is_judged_by_its_strain():
    """At 20 m/s Johnson's damage number is 0.008, at 200 m/s it is 0.8; alone nothing hits it."""
    wall = {"boundaries": {"x-max": "unilateral"}, "end": 1.0}
    slow, fast = (pgimp.load(bare(2, block([v, 0.0]), STEEL, **wall)) for v in (20.0, 200.0))
    assert (
        configurations(slow) == {"body": "total-lagrangian"} and slow.method.volumetric == "b-bar"
    )
    assert configurations(fast) == {"body": "updated-lagrangian"} and fast.method.affine
    assert configurations(pgimp.load(bare(2, block([200.0, 0.0]), STEEL))) == {
        "body": "total-lagrangian"
    }


@pytest.mark.parametrize(
    ("gravity", "chosen"), [(50.0, "total-lagrangian"), (1.0e5, "updated-lagrangian")]
)
def test_what_falls_is_judged_by_the_speed_at_which_it_hits(gravity, chosen):
    """Two cells deep, at 14 and 632 m/s: it is at rest at the start."""
    falls = {"boundaries": {"y-min": "unilateral"}, "gravity": [0.0, -gravity], "end": 1.0}
    case = pgimp.load(bare(2, block(), STEEL, **falls))
    assert configurations(case) == {"body": chosen}


@pytest.mark.parametrize(
    ("height", "chosen"), [(4.0, "total-lagrangian"), (1.0, "updated-lagrangian")]
)
def test_a_metal_is_judged_by_its_loads_with_bending(height, chosen):
    """A cantilever whose load is 0.02 of its strength: 3 (8/h)^2 of it at the clamp."""
    plate = {"on": {"body": "body", "face": "y-max", "traction": [0.0, -8.0e6]}}
    beam = box([0.0, 2.0], [8.0, 2.0 + height])
    case = pgimp.load(bare(2, beam, STEEL, boundaries={"x-min": "fixed"}, tractions=plate))
    assert configurations(case) == {"body": chosen}


@pytest.mark.parametrize(
    ("width", "chosen"), [(2.0, "updated-lagrangian"), (8.0, "total-lagrangian")]
)
def test_what_a_narrow_tool_sinks_into_is_strained_over_its_width(width, chosen):
    """A way of 0.4 is a fifth of a strip's width, and less than a tenth of the ground's depth."""
    ground = {**STEEL, "young": 4.0e9}  # yields at a strain of 0.1
    place = {"box": {"min": [6.0 - width / 2, 6.0], "max": [6.0 + width / 2, 7.0]}}
    tool = {"rigid": {"velocity": [0.0, -0.4]}, "region": place}
    data = bare(2, box([1.0, 1.0], [11.0, 6.0]), ground)
    data["bodies"]["strip"], data["time"]["end"] = tool, 1.0
    assert configurations(pgimp.load(data)) == {"body": chosen}


def test_a_body_that_may_come_to_a_wall_that_holds_is_in_the_current_configuration():
    walls = {"x-max": "fixed"}
    near, far = (bare(2, block([v, 0.0]), boundaries=walls, end=1.0) for v in (8.0, 1.0))
    assert configurations(pgimp.load(near)) == {"body": "updated-lagrangian"}
    assert "x-max" in "".join(lines(pgimp.load(near)))
    assert configurations(pgimp.load(far)) == {"body": "total-lagrangian"}


def test_nearly_incompressible_bodies_have_mean_dilatation():
    soft = {"model": "neo-hookean", "young": 100.0, "density": 1.0}
    found = [pgimp.load(bare(2, block(), soft | {"poisson": nu})) for nu in (0.35, 0.4)]
    assert [case.method.volumetric for case in found] == ["pointwise", "b-bar"]


def test_volumes_are_chosen_by_body():
    """The method has the mean because of one body; the other has a word of its own."""
    two = {"a": block(), "b": box([7.0, 2.0], [9.0, 5.0], material="wet")}
    data = bare(2, two)
    data["materials"]["wet"] = data["materials"]["soft"] | {"poisson": 0.49}
    case = pgimp.load(data)
    assert case.method.volumetric == "b-bar"
    assert [body.volumetric for body in case.bodies.values()] == ["pointwise", None]
    assert "volumetric b-bar (because of b)" in lines(case)[2]
    assert "volumetric pointwise" in lines(case)[0]
    data["bodies"]["b"]["volumetric"] = "pointwise"
    case = pgimp.load(data)
    assert case.method.volumetric == "pointwise" and case.bodies["a"].volumetric is None


def test_a_body_that_bounces_may_meet_one_behind_it():
    two = {"a": box([7.0, 6.0], [9.0, 8.0], [2.0, 0.0]), "b": box([1.0, 1.0], [2.0, 2.0])}
    assert len(pgimp.load(bare(2, two, end=8.0)).contact) == 1
    assert pgimp.load(bare(2, two, end=0.1)).contact == ()


def test_a_key_that_says_auto_is_chosen_in_any_format():
    """The others of a case that names its method stay."""
    data = scene(2, block(), cells=[12, 12], format=1)
    assert not lines(pgimp.load(data))
    whole = pgimp.load(data).model_dump(by_alias=True)
    for key, value in [("shape", "gimp"), ("particles-per-cell", (2, 2)), ("affine", True),
                       ("volumetric", "pointwise")]:  # fmt: skip
        case = pgimp.load(data, {f"method.{key}": "auto"})
        assert [*case.__dict__["chosen"]] == [("method", key)]
        whole["method"][key] = value
        assert case.model_dump(by_alias=True) == whole
        whole["method"]["affine"] = False
    body = pgimp.load(data, {"bodies.body.formulation": "auto", "bodies.body.mass": "auto"})
    assert (body.bodies["body"].formulation, body.bodies["body"].mass) == (
        "total-lagrangian", "averaged")  # fmt: skip
    assert body.time.step == pgimp.load(data).time.step and body.method.affine is False
    assert pgimp.load(data, {"time.step": "auto"}).courant == 0.3
    soft = {"materials.soft.poisson": 0.49}
    by_body = pgimp.load(data, {"bodies.body.volumetric": "auto", **soft})
    assert by_body.bodies["body"].volumetric == "b-bar"
    assert pgimp.load(data, {"method.mass": "auto"}).method.mass == "lumped"
    assert pgimp.load(data, {"contact": "auto"}).contact == ()


def test_what_says_auto_is_written_into_a_file():
    text = CASE.replace("shape: gimp", "mass: auto, shape: auto").replace("0.01", "auto")
    text = text.replace("velocity: [1.0", "mass: auto, velocity: [1.0") + "\ncontact: auto\n"
    case = read_case(text, "x")
    found = written(text, case)
    again = read_case(found, "x")
    assert "auto" not in found and not lines(again)
    assert again.model_dump() == case.model_dump()


def test_bodies_that_may_meet_do_so_without_friction():
    two = {"a": box([1.0, 1.0], [4.0, 4.0], [1.0, 0.0]), "b": box([6.0, 1.0], [9.0, 4.0])}
    (entry,) = pgimp.load(bare(2, two, end=4.0)).contact
    assert entry.bodies == "all" and entry.friction == 0.0
    touching = two | {"b": box([4.0, 1.0], [7.0, 4.0])}
    case = pgimp.load(bare(2, touching))
    assert len(case.contact) == 1
    assert "touch at the start" in lines(case)[-1] and "contact: bonded" in lines(case)[-1]
    apart = two | {"a": box([1.0, 1.0], [2.0, 4.0])}
    assert pgimp.load(bare(2, apart, end=0.1)).contact == ()


def test_bonded_says_that_bodies_stick_together():
    two = {"a": box([1.0, 1.0], [4.0, 4.0]), "b": box([4.0, 1.0], [7.0, 4.0])}
    (entry,) = pgimp.load(bare(2, two, contact="bonded")).contact
    assert entry.law.kind == pgimp.load(bare(2, two, contact=[
        {"bodies": ["a", "b"], "law": "tie"}])).contact[0].law.kind  # fmt: skip
    whole = scene(2, two, cells=[12, 12], contact="bonded")
    assert pgimp.load(whole).contact == ()  # they share one field


def test_layers_of_soil_and_liquids_flow_together():
    two = {"a": box([1.0, 1.0], [4.0, 4.0]), "b": box([4.0, 1.0], [7.0, 4.0])}
    assert pgimp.load(bare(2, two, CLAY)).contact == ()
    three = bare(2, two | {"c": box([8.0, 1.0], [9.0, 4.0], material="hard")}, CLAY)
    three["materials"]["hard"] = {"model": "neo-hookean", "young": 1e9, "poisson": 0.3,
                                  "density": 1e3}  # fmt: skip
    case = pgimp.load(three)
    assert [entry.bodies for entry in case.contact] == ["all", ("a", "b")]
    assert configurations(case) == {
        "a": "updated-lagrangian",
        "b": "updated-lagrangian",
        "c": "total-lagrangian",
    }


def test_what_is_written_stays():
    data = bare(2, block())
    data["method"] = {"shape": "cpdi", "affine": True}
    data["bodies"]["body"]["formulation"] = "updated-lagrangian"
    data["time"]["step"] = 0.01
    case = pgimp.load(data)
    assert (case.method.shape, case.method.affine, case.time.step) == ("cpdi", True, 0.01)
    assert configurations(case) == {"body": "updated-lagrangian"}
    assert pgimp.load(bare(2, block()), {"method.shape": "cpdi"}).method.shape == "cpdi"


def test_a_whole_case_of_format_1_keeps_its_defaults():
    """And of format 2 what it leaves out is chosen."""
    first, second = (read_case(CASE.replace("format: 1", f"format: {n}"), "x") for n in (1, 2))
    assert set(configurations(first).values()) == {"updated-lagrangian"} and first.contact == ()
    assert not lines(first) and not first.method.affine
    assert len(second.contact) == 1 and lines(second)
    assert second.time.step == first.time.step


def test_the_resolved_case_chooses_nothing_and_is_the_same():
    """It says what was chosen, as checkpoints do, whose case it is."""
    case = pgimp.load(bare(2, block()))
    text = dump_case(case)
    assert text.startswith("# chosen: body: formulation total-lagrangian")
    again = read_case(text, "x")
    assert again == case and not lines(again)


def test_auto_is_the_same_as_nothing():
    assert pgimp.load(bare(2, block()) | {"method": "auto"}) == pgimp.load(bare(2, block()))


def test_what_the_initial_configuration_excludes_is_in_the_current_one_with_the_reason():
    two = {"a": box([1.0, 1.0], [4.0, 4.0]), "b": box([4.0, 1.0], [7.0, 4.0])}
    case = pgimp.load(bare(2, two, output={"grid": ["contact"]}))
    assert set(configurations(case).values()) == {"updated-lagrangian"} and case.method.affine
    assert "output.grid.0" in lines(case)[0]


def test_probes_may_have_fields_of_the_initial_configuration_alone():
    """As frames may: what plain values exclude does not count before the choice."""
    probe = {"at": [3.0, 3.0], "body": "body", "fields": ["recovered-stress"]}
    case = pgimp.load(bare(2, block(), probes={"p": probe}))
    assert configurations(case) == {"body": "total-lagrangian"}
    with pytest.raises(CaseError, match=r"probes\.p\.fields\.0: .* current"):
        pgimp.load(bare(2, block(), CLAY, probes={"p": probe}))


def test_other_mistakes_are_named_as_in_any_case():
    data = bare(2, block())
    data["materials"]["soft"]["poisson"] = 0.7
    with pytest.raises(CaseError, match=r"^case: materials\.soft\.poisson: "):
        pgimp.load(data)


def test_a_file_gets_what_was_chosen_and_keeps_its_comments():
    text = CASE.replace("method: {shape: gimp, particles-per-cell: [2, 2]}\n", "  # none\n")
    text = text.replace(", step: 0.01", "")
    case = read_case(text, "x")
    found = written(text, case)
    assert "# Two soft blocks" in found and "  # none\n" in found
    again = read_case(found, "x")
    assert again.model_dump() == case.model_dump() and not lines(again)
    assert len(found.splitlines()) <= len(text.splitlines()) + 3


def test_a_resumed_run_keeps_its_choices():
    """Another end, for instance, would let the body come to the wall."""
    data = bare(2, block([1.0, 0.0]), boundaries={"x-max": "fixed"}, end=1.0)
    before, longer = pgimp.load(data), pgimp.load(data, {"time.end": 20.0})
    assert configurations(longer) == {"body": "updated-lagrangian"}
    found = kept(longer, read_case(dump_case(before), "x"))
    assert configurations(found) == {"body": "total-lagrangian"} and found.time.end == 20.0
    assert found.method == before.method
    assert kept(before, before) is before


def test_the_table_names_pages_and_ends_with_what_always_fits():
    for rules in (OF_BODIES, MASS, OF_SCENES):
        for rule in rules:
            assert rule.reason and rule.figure and rule.when
            assert rule.page.partition("#")[0] in TITLES
    assert "liquid" in FLOWING


def test_choices_are_those_of_the_data_alone():
    """Read twice, from JSON and from a loaded case."""
    data = bare(3, box([2.0] * 3, [5.0] * 3))
    one, other = pgimp.load(data), pgimp.load(json.loads(json.dumps(data)))
    assert one == other and lines(one) == lines(other)


def test_editors_know_what_may_be_left_out():
    """By the JSON schema; and what is still refused."""
    sees = Checker(json_schema())
    for method in ("auto", {"affine": True}, {"shape": "cpdi"}, {"shape": "gimp", "affine": True},
                   {"shape": "auto", "particles-per-cell": "auto", "affine": "auto"},
                   {"volumetric": "auto", "mass": "auto"}):  # fmt: skip
        data = bare(2, block(), contact="bonded") | {"method": method}
        assert sees(data), method
        pgimp.load(data)
    assert sees(bare(2, block()))
    body = bare(2, block(), contact="auto")
    body["bodies"]["body"] |= {"formulation": "auto", "mass": "auto", "volumetric": "auto"}
    body["time"]["step"] = "auto"
    assert sees(body)
    pgimp.load(body)
    assert not sees(bare(2, block(), contact="glued"))
    assert not sees(bare(2, block()) | {"method": {"shape": "tent"}})


def test_strains_of_a_run_tell_where_another_method_is_better():
    """Only of what was chosen: what a case names is its own affair."""
    steel = pgimp.load(bare(2, block(), STEEL))
    assert beyond(steel, "body", 0.5) == "formulation: updated-lagrangian" and not beyond(
        steel, "body", 0.1
    )
    named = bare(2, block(), STEEL)
    named["bodies"]["body"]["formulation"] = "total-lagrangian"
    assert not beyond(pgimp.load(named), "body", 0.5)
    stiff = {"model": "neo-hookean", "young": 1e5, "poisson": 0.3, "density": 1.0}
    held = pgimp.load(bare(2, block([8.0, 0.0]), stiff, boundaries={"x-max": "fixed"}))
    assert beyond(held, "body", 0.3) == "method.shape: finite-gimp"
    assert not beyond(held, "body", 0.1)
    assert not beyond(pgimp.load(bare(2, block(), CLAY)), "body", 2.0)
    assert not beyond(pgimp.load(bare(2, block())), "body", 2.0)


def test_bodies_alike_share_a_line():
    """Three of them are named."""
    five = {f"b{n}": box([1.0 + 2.0 * n, 1.0], [2.0 + 2.0 * n, 2.0]) for n in range(5)}
    said = lines(pgimp.load(bare(2, five)))
    assert said[0].startswith("b0, b1, b2 and 2 more: formulation total-lagrangian")
    assert not said[1].startswith("b")
