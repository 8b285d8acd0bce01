"""Every pair of features: those that the table lists are refused, all others are accepted."""

from itertools import combinations

import numpy as np
import pytest
from mentioned import mentions
from tiers import wide

import pgimp
from pgimp.case.checks.exclusions import features as f
from pgimp.case.checks.exclusions import loads as g
from pgimp.case.checks.exclusions.feature import Place
from pgimp.case.checks.exclusions.table import EXCLUSIONS, FEATURES
from pgimp.case.load import load
from pgimp.errors import CaseError
from pgimp.physics.functions.registry import FUNCTIONS
from pgimp.scene.scene import Scene

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
BOX = {"box": {"min": [2.0, 2.0], "max": [5.0, 5.0]}}
STAMP = {"box": {"min": [2.0, 7.0], "max": [5.0, 7.5]}}
CASE = {
    "format": 1, "dimensions": 2, "grid": {"size": [8.0, 8.0], "cell": [1.0, 1.0]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
    "time": {"end": 0.02, "step": 0.01},
    "materials": {"hard": {"model": "hooke", "young": 100.0, "poisson": 0.3, "density": 2.0}},
    "bodies": {
        "block": {"material": "hard", "region": BOX},
        "other": {"material": "hard", "region": {"box": {"min": [6.0, 2.0], "max": [7.0, 4.0]}}},
    },
}  # fmt: skip
B = "bodies.block."


def of(**material):
    """Values by which the block is of another material."""
    return {"bodies.block.material": "new", "materials.new": material}


INITIAL = {B + "formulation": "total-lagrangian", "bodies.other.formulation": "initial"}
FACE = {"body": "block", "face": "y-max", "pressure": 0.1}
REGION = {"body": "block", "region": {"box": {"min": [1, 4.5], "max": [6, 6]}}, "pressure": 0.1}
LATER = [{"name": "later", "end": 0.04}]
COMES = [{"name": "later", "end": 0.04, "add": ["block"]}]
PERIODIC = {"boundaries.x-min": "periodic", "boundaries.x-max": "periodic"}
SINK = {"region": {"box": {"min": [0.0, 0.0], "max": [8.0, 0.5]}}}
WALL = {"boundaries.y-min": "unilateral"}

# Values by key paths that give a case the feature, and nothing else that some feature excludes.
ASKED = {
    f.axisymmetric: {"geometry": "axisymmetric"},
    f.plane_stress: {"geometry": "plane-stress"},
    f.without_rings: {"method.shape": "fuzzy-nearest"},
    f.no_boxes: {"method.shape": "mpm"},
    f.not_separable: {"method.shape": "cpdi-corners"},
    f.initial_volume: {"method.volume": "initial"},
    f.mean: {"method.volumetric": "b-bar"},
    f.one_particle: {"method.particles-per-cell": [1, 1]},
    f.initial: INITIAL,
    f.averaged: {**INITIAL, B + "mass": "averaged"},
    f.of_points: {"method.shape": "mpm"},
    f.initial_with_memory: {**INITIAL, **of(**SOFT)},
    f.initial_not_uniform: {**INITIAL, B + "velocity": {"function": "swirl"}},
    f.mixed: {B + "formulation": "total-lagrangian"},
    f.liquid: of(model="newtonian", **{"bulk": 100.0, "shear-viscosity": 0.01}, density=1.0),
    f.varying: of(**SOFT | {"young": {"table": [[0.0, 100.0], [8.0, 120.0]], "over": "y"}}),
    f.varying_density: of(**SOFT | {"density": {"table": [[0.0, 1.0], [8.0, 1.1]], "over": "y"}}),
    f.points: {B + "region": {"points": {"file": "points.csv"}}},
    f.no_box: {B + "region": {"ball": {"centre": [3.5, 3.5], "radius": 1.5}}},
    f.begins_moving: {B + "velocity": [0.0, 0.1]},
    f.not_across: of(**SOFT | {"model": "drucker-prager", "cohesion": 1.0, "friction-angle": 30.0}),
    f.rigid: {"bodies.block": {"rigid": {}, "region": BOX}},
    f.free_rigid: {"bodies.stamp": {"rigid": {"density": 1.0}, "region": STAMP}},
    f.motions: {B + "velocity": [0.1, 0.0]},
    f.forces: {"gravity": [-0.1, 0.0]},
    f.meetings: {"contact": [{"bodies": "all"}]},
    g.absorbing: {"boundaries.x-max": "absorbing"},
    g.periodic: PERIODIC,
    g.conditions: WALL,
    g.on_axis: {"boundaries.x-min": "fixed"},
    g.outlet: {"outflow.y-min": "remove"},
    g.outflow: {"outflow.bin": SINK},
    g.body_force: {"body-force": {"rotating-frame": {"about": [0.0, 0.0], "rate": 0.1}}},
    g.any_body_force: {"body-force": {"function": "push"}},
    g.tractions: {"tractions.press": FACE},
    g.region_tractions: {"tractions.press": REGION},
    g.at_ends: {
        B + "region": {"box": {"min": [0.0, 2.0], "max": [5.0, 5.0]}},
        "tractions.press": {**FACE, "face": "x-min"},
    },
    g.profiles: {
        "tractions.press": {**REGION, "profile": {"along": [1.0, 0.0], "table": [[0, 0], [9, 1]]}}
    },
    g.turning: {
        "constraints.turn": {
            "body": "block", "region": {"box": {"min": [2.0, 2.0], "max": [5.0, 2.5]}},
            "rotation": {"about": [3.5, 3.5], "rate": 0.1},
        }
    },
    g.entering: {"inflow.block": {"velocity": [0.1, 0.0]}},
    g.inflow: {"inflow.block": {"velocity": [0.1, 0.0]}},
    g.water: {"water": {"level": 1.0, "density": 0.5}, "gravity": [-0.1, 0.0]},
    g.exact: {"exact": {"function": "rest"}},
    g.damping: {"damping": {"mass": 1.0}},
    g.local_damping: {"damping": {"local": 0.5}},
    g.mass_scaling: {"time.mass-scaling": 4.0},
    g.settling: {"start.equilibrate": {}},
    g.weight: {"start.stress": {"k0": 0.5}, "gravity": [0.0, -0.1]},
    g.stages: {"time.stages": LATER},
    g.added: {"time.stages": COMES},
    g.constraints: {"constraints.hold": {"body": "block", "region": BOX, "velocity": [0.0, None]}},
    g.moving: {B + "velocity": [0.0, 0.1]},
    g.met_by_initial: {B + "formulation": "total-lagrangian", **WALL},
    g.contact_forces: {"output.grid": ["contact"]},
    g.wall_gauges: {"boundaries.y-min": "unilateral", "gauges.wall": {"wall": "y-min"}},
    g.level_gauges: {"gauges.level": {"level": [3.0]}},
    g.recovered: {"output.fields": ["recovered-stress"], **INITIAL},
    g.probes: {"probes.tip": {"body": "block", "at": [3.5, 3.5]}},
}  # fmt: skip


@pytest.fixture(autouse=True, scope="module")
def own(tmp_path_factory):
    """Functions of one's own and a file of particles, in the working directory."""
    before, patch = dict(FUNCTIONS), pytest.MonkeyPatch()
    patch.chdir(tmp_path_factory.mktemp("exclusions"))
    with open("points.csv", "w") as file:
        file.write("x,y,volume\n")
        ticks = [2.25 + 0.5 * i for i in range(6)]
        file.writelines(f"{x},{y},0.25\n" for x in ticks for y in ticks)

    @pgimp.velocity
    def swirl(x):
        return 0.0, 0.01 * x[0]

    @pgimp.body_force
    def push(x, t):
        return 0.0, -0.01 * x[1]

    @pgimp.exact_solution
    def rest(X, x, t):
        return (0.0, 0.0), (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)

    yield
    FUNCTIONS.clear()
    FUNCTIONS.update(before)
    patch.undo()


LISTED = {frozenset((each.a, each.b)) for each in EXCLUSIONS}


SHAPES = (f.without_rings, f.not_separable)


def features_of(values):
    """Features of the case with the values."""
    case = load(CASE, values)
    names = {*type(case).model_fields, "bodies", "rigid_bodies"}
    parts = {"began": 0.0, "gone": ()} | {name: getattr(case, name) for name in names}
    return {each for each in FEATURES if each.places(parts)}


def pairs():
    """Pairs of features that ask for different keys, with the values of both."""
    for a, b in combinations(ASKED, 2):
        one, other = ASKED[a], ASKED[b]
        both = one | other
        clash = any(one[key] != other[key] for key in one.keys() & other.keys())
        if clash or any(key.startswith(f"{part}.") for key in both for part in both):
            continue
        if not (f.initial_volume in (a, b) and {a, b} & {*SHAPES}):  # these have no such key
            yield a, b, both


def refusal(values):
    """The message about a case with the values; empty if it is accepted."""
    try:
        Scene(load(CASE, values))
    except CaseError as error:
        return str(error)
    return ""


def test_each_feature_is_found_where_it_is_asked_for_and_is_accepted_alone():
    plain = features_of({})
    for feature, values in ASKED.items():
        assert feature in features_of(values) - plain, feature.words


def test_pairs_are_refused_if_and_only_if_the_table_lists_them():
    """A refused pair is listed, or two features are that its keys ask for by themselves."""
    found = {feature: features_of(values) for feature, values in ASKED.items()}
    wrong, refused = [], 0
    for a, b, both in pairs():
        asked = [found[each] for each in ASKED if ASKED[each].items() <= both.items()]
        there = set().union(*asked)
        listed = any(pair <= there for pair in LISTED)
        text = refusal(both)
        refused += bool(text)
        if (frozenset((a, b)) in LISTED) > bool(text) or bool(text) > listed:
            wrong.append(f"{a.words} and {b.words}: {text or 'accepted'}")
    assert not wrong, "\n".join(wrong)
    assert refused > 100


def test_every_message_has_a_reason_and_a_remedy():
    place = Place(("bodies", "block"), "it", "block", "x")
    for each in EXCLUSIONS:
        text = each.text(place, place)
        assert text[0].islower() or text[0] == "'", text
        assert each.remedy or f.not_plane in each, text


@pytest.mark.parametrize("geometry", ["axisymmetric", "plane-stress"])
def test_what_is_of_a_plane_is_for_two_dimensions(geometry):
    one = {"format": 1, "dimensions": 1, "geometry": geometry, "grid": {"size": [8.0], "cell": [1]},
           "method": {"shape": "gimp", "particles-per-cell": [2]}, "time": {"end": 1, "step": 0.1},
           "materials": {"soft": SOFT},
           "bodies": {"bar": {"material": "soft", "region": {"box": {"min": [1], "max": [4]}}}},
    }  # fmt: skip
    with pytest.raises(CaseError, match=f"^case: geometry: {geometry} is for 2 .* has 1$"):
        load(one)


def test_features_of_other_bodies_and_directions_do_not_exclude_each_other():
    moved = {key.replace("block", "other"): value for key, value in ASKED[g.inflow].items()}
    assert not refusal(moved | ASKED[f.no_box])
    up = {"inflow.block": {"velocity": [0.0, 0.1]}}
    assert not refusal(up | PERIODIC)
    mentions(refusal(ASKED[g.inflow] | PERIODIC), "inflow.block.velocity", "along x", "periodic")


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (g.settling, g.added),
        wide(f.initial, g.water),
        wide(f.axisymmetric, f.varying),
        wide(f.plane_stress, g.inflow),
        wide(f.axisymmetric, g.region_tractions),
        wide(g.exact, g.outlet),
    ],
    ids=lambda feature: feature.words,
)
def test_what_is_accepted_runs(one, other):
    simulation = pgimp.Simulation(load(CASE, ASKED[one] | ASKED[other]))
    for _ in range(2):
        simulation.step()
    assert np.isfinite(simulation.particles["position"]).all()
