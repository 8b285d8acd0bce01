"""State variables as they are declared: tensors, starts, refusals, kernels of their own."""

from pathlib import Path

import numpy as np
import pytest
from material_driver import COMPONENTS
from outside_materials import SOFTENING as SOFTENING_FILE
from outside_materials import registered
from remembering import RUBBER, SOFTENING, two_blocks
from scenes import field

import pgimp
from pgimp.errors import CaseError, UsageError
from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import kernel
from pgimp.jit.outside import digest
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import COLUMNS, Particles, shape_of
from pgimp.physics.materials.base import state_width
from pgimp.physics.materials.parameters.evaluate import evaluate
from pgimp.physics.materials.parameters.outside import parameters_of
from pgimp.physics.materials.registry import import_file


@pytest.fixture(scope="module", autouse=True)
def softening():
    with registered(SOFTENING_FILE) as (module,):
        yield module


TENSORIAL = """
from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import pgimp
from pgimp.jit.algebra import isotropic, symmetric
from pgimp.physics.materials import Material, Positive, State


class Parameters(NamedTuple):
    stiffness: float
    start: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        D = isotropic(dt, symmetric(L), 0.0)
        p = material.stiffness * (J - 1.0)
        return isotropic(0.0, D, p), (state[0] + 1.0, *isotropic(1.0, {sum}, 0.0))

    @staticmethod
    def energy(material, F, J, sigma, state):
        return 0.5 * material.stiffness * (J - 1.0) * (J - 1.0)

    @staticmethod
    def speed(material, F, J, state):
        return sqrt(material.stiffness / material.density)


@pgimp.register_material
class {name}(Material):
    STATE: ClassVar = (
        State("steps", "1", "steps done, and one", initial="start"),
        State("strain-sum", "1", "sum of dt D", tensor=True),
    )
    model: Literal["{model}"]
    stiffness: Positive
    start: float = 1.0

    def parameters(self):
        return Parameters(self.stiffness, self.start, self.density)
"""


SUMS = {
    1: "(state[1] + D[0], state[2] + D[1], state[3] + D[2])",
    2: "(state[1] + D[0], state[2] + D[1], state[3] + D[2], state[4] + D[3])",
    3: "(state[1] + D[0], state[2] + D[1], state[3] + D[2], state[4] + D[3], state[5] + D[4],"
    " state[6] + D[5])",
}


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_tensor_and_a_start_from_the_parameters(dimension, tmp_path):
    """The wider of two materials; its tensor is the sum of what each step's frames tell."""
    path = tmp_path / f"tensorial{dimension}.py"
    text = TENSORIAL.replace("{sum}", SUMS[dimension]).replace("{name}", f"Sum{dimension}")
    path.write_text(text.replace("{model}", f"sum-{dimension}"))
    import_file(str(path))
    case = two_blocks(dimension)
    law = {"model": f"sum-{dimension}", "stiffness": 100.0, "start": 5.0, "density": 1.0}
    case["materials"] = {"hard": SOFTENING, "soft": law}
    case["time"] = {"end": 0.04, "step": 0.002}
    case["output"]["fields"] = ["steps", "strain-sum", "damage"]
    sim = pgimp.Simulation(case)
    core = sim.core
    wanted = np.zeros((len(sim.particles["id"]), 6))
    mine = sim.particles["body"] == 0

    def deformation():
        return field(core, "F").reshape(-1, dimension, dimension)

    for _ in range(10):
        before = deformation()
        core.advance()
        step = np.zeros((len(before), 3, 3))  # dt L, as F becomes (1 + dt L) F
        grown = deformation() @ np.linalg.inv(before)
        step[:, :dimension, :dimension] = grown - np.eye(dimension)
        for i, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))):
            wanted[:, i] += 0.5 * (step[:, a, b] + step[:, b, a])
    assert (sim.particles["steps"][mine] == 15.0).all()
    assert np.isnan(sim.particles["steps"][~mine]).all()
    assert np.isfinite(sim.particles["damage"][~mine]).all()
    np.testing.assert_allclose(sim.particles["strain-sum"][mine], wanted[mine], 0, 1e-14)
    core.particles.state[core.live()[3], 0] = np.nan
    with pytest.raises(pgimp.RunError, match="not a finite number"):
        for _ in range(3):
            core.advance()


@kernel
def stress_of(materials, F, sigma, state):
    args = (F, determinant(F), sigma, F, 0.1)
    own = evaluate("stress", materials, 0, args, state)
    return own, evaluate("stress", materials, 1, args, state)


def test_a_material_sees_its_own_state_alone(softening):
    """With one that remembers more: it gets the first places, the others stay as they are."""
    soft = parameters_of(pgimp.load(two_blocks()).materials["soft"], 2)
    rubber = pgimp.load(two_blocks()).materials["hard"].parameters()
    assert state_width(type(soft), 2) == 2 and state_width(type(rubber), 2) == 0
    F, sigma, state = (1.2, 0.0, 0.0, 1.0), (0.0,) * COMPONENTS[2], (0.5, 0.1, 7.0)
    own, other = stress_of((soft, rubber), F, sigma, state)
    assert len(own) == len(other) == COMPONENTS[2] + 3
    assert own[4] > 0.5 and own[5] == pytest.approx(0.9 * own[4] / (own[4] + 1.0)) and own[6] == 7.0
    assert other[4:] == state


REFUSED = {
    "a list": ("[State('a', '1', 'x')]", "must be a tuple"),
    "no name": ("(State('A b', '1', 'x'),)", "small letters"),
    "a field": ("(State('stress', '1', 'x'),)", "taken"),
    "twice": ("(State('a', '1', 'x'), State('a', '1', 'y'))", "taken"),
    "no parameter": ("(State('a', '1', 'x', initial='none'),)", "none of the parameters"),
    "no number": ("(State('a', '1', 'x', initial=float('inf')),)", "finite number"),
    "more": ("(State('a', '1', 'x'), State('b', '1', 'x'))", "tuple of 2 floats"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_declared_wrongly_is_refused_by_name(name, tmp_path):
    declared, words = REFUSED[name]
    text = TENSORIAL.replace("(state[0] + 1.0, *isotropic(1.0, {sum}, 0.0))", "(1.0,)")
    first, last = text.index("    STATE"), text.index("    model:")
    text = f"{text[:first]}    STATE: ClassVar = {declared}\n{text[last:]}"
    module = f"wrong_{name.replace(' ', '_')}"
    text = text.replace("{name}", "Wrong").replace("{model}", module)
    (tmp_path / f"{module}.py").write_text(text)
    import_file(str(tmp_path / f"{module}.py"))
    case = two_blocks()
    case["materials"]["soft"] = {"model": module, "stiffness": 1.0, "density": 1.0}
    case["output"]["fields"] = []
    with pytest.raises(UsageError, match=words) as refused:
        pgimp.Simulation(case)
    assert module in str(refused.value)


@pytest.mark.parametrize(
    ("returned", "words"),
    [("isotropic(0.0, D, p)", "a pair"), ("(isotropic(0.0, D, p), 1.0)", "but returns a float")],
)
def test_a_stress_without_its_state_is_refused(returned, words, tmp_path):
    text = TENSORIAL.replace(
        "isotropic(0.0, D, p), (state[0] + 1.0, *isotropic(1.0, {sum}, 0.0))", returned
    )
    module = f"without_{len(words)}"
    (tmp_path / f"{module}.py").write_text(
        text.replace("{name}", "Without").replace("{model}", module)
    )
    import_file(str(tmp_path / f"{module}.py"))
    case = two_blocks()
    case["materials"]["soft"] = {"model": module, "stiffness": 1.0, "density": 1.0}
    case["output"]["fields"] = []
    with pytest.raises(UsageError, match=words):
        pgimp.Simulation(case)


def test_an_initial_state_that_is_no_state_is_refused(tmp_path):
    start = "    @staticmethod\n    def initial_state(material, F, J, sigma, state):\n"
    text = TENSORIAL.replace("{sum}", SUMS[2]).replace("{name}", "Start")
    text = text.replace("    @staticmethod\n    def energy", f"{start}        return sigma\n\n"
                        "    @staticmethod\n    def energy")  # fmt: skip
    (tmp_path / "start.py").write_text(text.replace("{model}", "start"))
    import_file(str(tmp_path / "start.py"))
    case = two_blocks()
    case["materials"]["soft"] = {"model": "start", "stiffness": 1.0, "density": 1.0}
    case["output"]["fields"] = []
    with pytest.raises(UsageError, match=r"initial_state .* a tuple of 5 floats, .* tuple of 4"):
        pgimp.Simulation(case)


def test_a_field_that_no_material_has_is_unknown():
    case = two_blocks()
    case["output"]["fields"] = ["damge"]
    with pytest.raises(CaseError, match="did you mean 'damage'"):
        pgimp.load(case)
    case["materials"] = {"hard": RUBBER, "soft": RUBBER}
    case["output"]["fields"] = ["damage"]
    with pytest.raises(CaseError, match="no material of the case has it"):
        pgimp.load(case)


def test_other_state_variables_are_other_kernels(softening, monkeypatch):
    """Wherever they are declared: a kernel for fewer would write past what it knows of."""
    kind = type(parameters_of(pgimp.load(two_blocks()).materials["soft"], 2))
    before = digest(kind)
    assert before and digest(kind) == before
    monkeypatch.setattr(kind, "STATE", kind.STATE[:1])
    assert digest(kind) not in ("", before)


def test_columns_are_declared_once():
    """Each array is of its column's type and width, and the page of symbols has them all."""
    carried = Carried(3, True, True, True, 2, 5, needed=frozenset(COLUMNS))
    page = (Path(__file__).parents[3] / "docs/symbols.md").read_text()
    particles = Particles.empty(4, carried)
    for name, array in particles._asdict().items():
        column = COLUMNS[name]
        assert array.dtype == column.dtype
        assert array.shape[1:] == shape_of(name, carried)
        line = next(line for line in page.splitlines() if f"`{name}`" in line)
        assert column.meaning in line or name in ("V", "V0")
        assert column.unit in line
