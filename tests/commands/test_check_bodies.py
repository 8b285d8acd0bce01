"""``pgimp check`` on what bodies, constraints, probes and methods of a case make doubtful."""

import pytest
from checked import PLATE, facts, findings, plate, said
from mentioned import mentions

from pgimp.case.reader import read_case
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.checks.locking import locking, stripes
from pgimp.scene.checks.sanity import body_warnings, case_warnings, strains


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
            with pytest.raises(CaseError, match=r"grip\.region: contains no particle") as caught:
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
    mentions(text, "bodies.beam.region: ", "fewer cells across", "0.8 along y")
    assert concerns(read_case(PLATE.replace("max: [8.0, 2.0]", "max: [8.0, 1.5]"), "x")) == []
    probes = "probes: {there: {place: [8.2, 1.5]}, nothing: {place: [9.5, 1.5]}}"
    (text,) = concerns(plate(probes))
    mentions(text, "probes.nothing.place: ", "no particle", "at the start")
    pull = "tractions: {pull: {body: beam, face: x-min, traction: [1.0, 0.0]}}"
    (text,) = concerns(plate(pull, "boundaries: {x-min: fixed}"))
    mentions(text, "tractions.pull: ", "face x-min of 'beam'", "domain")
    assert concerns(plate(pull, "boundaries: {x-min: slip}")) == []
    assert concerns(plate(pull, "boundaries: {x-max: fixed}")) == []


def test_points_with_affine_are_doubted():
    methods = ("gimp, affine: true", "mpm, affine: false", "mpm, affine: true")
    cases = [PLATE.replace("shape: gimp", f"shape: {method}") for method in methods]
    said = [concerns(read_case(case, "x")) for case in cases]
    assert said[:2] == [[], []]
    mentions(said[2][0], "method.affine: ", "mpm", "energy")


def test_contact_of_thin_bodies_and_of_points_is_doubted():
    contact = "contact: [{bodies: [beam, sheet]}]"

    def doubts(top, shape="gimp", law=contact):
        sheet = f"{{material: m, region: {{box: {{min: [0.0, 2.2], max: [8.0, {top}]}}}}}}"
        text = PLATE.replace("shape: gimp", f"shape: {shape}")
        text = text.replace("bodies: {", f"bodies: {{sheet: {sheet}, ") + law
        return [said for said in concerns(read_case(text, "x")) if said.startswith("contact: ")]

    assert doubts(3.4) == []
    (text,) = doubts(2.6)
    mentions(text, "contact: ", "'sheet'", "both its sides")
    assert doubts(2.6, law="contact: [{bodies: all, law: tie}]") == []
    (text,) = doubts(3.4, "mpm")
    mentions(text, "contact: ", "mpm", "gap", "half")


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
    ("poisson", "method", "expected"),
    [
        (0.499, "shape: gimp", "0.499 is nearly incompressible"),
        (0.499, "shape: mpm", "with boxes (shape: gimp)"),
        (0.499, "shape: gimp, volumetric: b-bar", ""),
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
method: {{{method}, particles-per-cell: [1, 1]}}
time: {{end: 1.0, step: {{courant: 0.3}}}}
materials: {{rubber: {{model: neo-hookean, young: 1.0, poisson: {poisson}, density: 1.0}}}}
bodies: {{block: {{material: rubber, region: {{box: {{min: [1.0, 1.0], max: [3.0, 3.0]}}}}}}}}
"""
    )
    texts = [text for text in said(case) if "poisson" in text]
    assert len(texts) == bool(expected)
    assert all(expected in text and "volumetric: b-bar" in text for text in texts)


SOIL = "young: 1.0, poisson: 0.3, cohesion: 1.0, friction-angle: 30.0"
FLOWING = {
    "drucker-prager": SOIL, "mohr-coulomb": SOIL,
    "von-mises": "young: 1.0, poisson: 0.3, yield-stress: 1.0",
    "mu-i": "young: 1.0, poisson: 0.3, mu-s: 0.4, mu-2: 0.6, i0: 0.3, grain: 0.1, "
    "grain-density: 2.0",
    "newtonian": "bulk: 1.0, shear-viscosity: 0.1", "neo-hookean": "young: 1.0, poisson: 0.3",
}  # fmt: skip


@pytest.mark.parametrize("method", ["shape: gimp", "shape: gimp, volumetric: b-bar", "shape: mpm"])
@pytest.mark.parametrize("model", FLOWING)
def test_stripes_of_plastic_solids_are_foreseen(model, method):
    """Told of solids that flow plastically, without the means of cells; of no liquid or grains."""
    text = f"""
format: 1
dimensions: 2
grid: {{size: [4.0, 4.0], cell: [1.0, 1.0]}}
method: {{{method}, particles-per-cell: [2, 2]}}
time: {{end: 1.0, step: {{courant: 0.3}}}}
materials: {{ground: {{model: {model}, density: 1.0, {FLOWING[model]}}}}}
bodies: {{hill: {{material: ground, region: {{box: {{min: [1.0, 1.0], max: [3.0, 3.0]}}}}}}}}
"""
    case = read_case(text)
    found = list(stripes(case))
    assert not list(locking(case))
    plastic = model in ("drucker-prager", "mohr-coulomb", "von-mises")
    assert len(found) == (plastic and "b-bar" not in method)
    words = "checkerboard", "'hill'", "materials.ground"
    assert all(word in one for one in found for word in words)


def test_bodies_of_one_material_are_named_together():
    """Hundreds of grains give one note, not one each."""
    balls = "\n".join(
        f"  grain{n}: {{material: M, region: {{ball: {{centre: [{n + 0.5}, 1.0], radius: 0.4}}}}}}"
        for n in range(9)
    )
    text = f"""
format: 1
dimensions: 2
grid: {{size: [9.0, 2.0], cell: [0.2, 0.2]}}
method: {{shape: gimp, particles-per-cell: [2, 2]}}
time: {{end: 1.0, step: {{courant: 0.3}}}}
materials:
  metal: {{model: von-mises, young: 1.0, poisson: 0.3, yield-stress: 0.1, density: 1.0}}
  rubber: {{model: neo-hookean, young: 1.0, poisson: 0.49, density: 1.0}}
bodies:
{balls}
"""
    (note,) = stripes(read_case(text.replace("M,", "metal,")))
    assert "'grain0', 'grain1', 'grain2' and 6 more flow plastically" in note
    (warning,) = locking(read_case(text.replace("M,", "rubber,")))
    assert "and 'grain0', 'grain1', 'grain2' and 6 more will be too stiff" in warning


@pytest.mark.parametrize(("high", "all_of_it"), [(8.0, True), (7.9, False)])
def test_a_sink_that_takes_all_of_a_body_at_the_start(high, all_of_it):
    case = plate(
        f"outflow: {{drain: {{region: {{box: {{min: [0.0, 0.0], max: [{high}, 2.0]}}}}}}}}"
    )
    found = [text for text in body_warnings(case, facts(case)[0], case.time.end) if "gone" in text]
    assert len(found) == all_of_it
    for text in found:
        mentions(text, "outflow.drain: ", "all of beam")
