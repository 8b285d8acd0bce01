"""Materials that are registered: what they lack or return wrongly is said, by name and number."""

import sys
from pathlib import Path

import numpy as np
import outside_materials
import pytest
from scenes import box, scene, write_case
from written_laws import law, write_law

import pgimp
from pgimp.errors import CaseError, UsageError
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.sums.sums import fastest_rate
from pgimp.physics.materials import NeoHookean, registry
from pgimp.physics.materials.parameters.outside import parameters_of

pytestmark = pytest.mark.slow(30)

CASES = Path(__file__).resolve().parents[3] / "cases"
#: Components of a stress in 1D, 2D and 3D.
COUNTS = (3, 4, 6)


@pytest.fixture
def registered():
    """Register what is written in a file's text; forgotten after the test."""

    def register(text, **names):
        space = {"__name__": "elsewhere", **names}
        exec(text, space)
        return space

    with outside_materials.registered():
        yield register


def ask(entry, dimensions=1):
    parameters = parameters_of(entry, dimensions)
    D = dimensions
    frame = Frame((0.0,) * D, (1.0,) * D, (1.0,) * D, (4,) * D, 1)
    one = tuple(np.eye(D).ravel())
    rows, zero = np.zeros(1, np.int32), np.zeros(1, np.int64)
    setting = KernelScene((), frame, one, (parameters,), zero)
    return fastest_rate(setting, Particles.empty(1, Carried(D)), rows, True)


def test_two_classes_of_one_name_are_two_materials(registered):
    """Numba tells NamedTuples apart by their name."""
    for factor in (2.0, 3.0):
        space = registered(law(factor=factor))
        assert ask(space["Law"](model="law", density=1.0)) == factor


def test_whether_a_material_takes_vectors(registered):
    assert pgimp.takes_vectors(NeoHookean(model="neo-hookean", density=1, young=1, poisson=0.3), 3)
    registry.import_file(str(CASES / "fluid.py"))
    fluid = sys.modules["fluid"].Fluid(model="fluid", density=1.0, bulk=1.0, shear=1.0)
    assert all(pgimp.takes_vectors(fluid, D) for D in (1, 2, 3))
    for stress, expected in {
        "(max(F[0] - 1.0, 0.0) * sqrt(J) + log(J), 0.0, 0.0)": True,
        "(choose(F[0] > 1.0, J, 2.0 * J), 0.0, 0.0)": True,
        "(J if F[0] > 1.0 else 2.0 * J, 0.0, 0.0)": False,
        "(exp(J), 0.0, 0.0)": True,
    }.items():
        from pgimp.physics.materials import choose

        space = registered(law(stress), choose=choose)
        assert pgimp.takes_vectors(space["Law"](model="law", density=1.0), 1) is expected, stress


def test_what_a_material_lacks_is_said(registered):
    space = registered(law(speed="FACTOR * nothing"))
    with pytest.raises(UsageError, match=r"LawParameters.speed \(.*\) does not compile: .*nothing"):
        ask(space["Law"](model="law", density=1.0))
    for old, new, message in [
        ("density: float", "mass: float", "a NamedTuple with a density, got LawParameters"),
        ("def energy(", "def work(", r"needs a @staticmethod energy\(material, F, J, sigma\)"),
        ("energy(material, ", "energy(", "takes 3 arguments instead of energy"),
        ("energy(material, ", "energy(material, more, ", "takes 5 arguments instead of energy"),
        ("    @staticmethod\n", "    @staticmethod\n    @numba.njit\n", "must be a plain function"),
        ("density: float", "density: float\n    names: dict", "names of LawParameters.* type dict"),
        ("Parameters(self.density)", "Parameters(1.0 / 0.0)", r"Law.parameters\(\) of .* fails: Z"),
    ]:
        text = law().replace(old, new).replace("names: dict", "names: dict = {}")
        entry = registered(f"import numba\n{text}")["Law"](model="law", density=1.0)
        with pytest.raises(UsageError, match=f"^the material 'law'.*{message}"):
            parameters_of(entry, 1)
    for old, new, message in [
        ('model: Literal["law"]', "", 'add a field\nmodel: Literal\\["my-material"\\]'),
        ("Law(Material)", "Law", "no class derived from Material"),
        ('"law"', '"hooke"', "there is a material 'hooke' already, .*materials.hooke.Hooke"),
        ("parameters(self)", "other(self)", r"needs a method parameters\(self\)"),
    ]:
        with pytest.raises(UsageError, match=message):
            registered(law().replace(old, new))


@pytest.mark.parametrize("D", [1, 2, 3])
def test_a_stress_of_the_wrong_kind_is_refused(registered, D):
    """Too short, too long, no tuple: the kernels would write whatever they are given."""
    wanted = COUNTS[D - 1]

    def refused(stress, message):
        entry = registered(law(stress))["Law"](model="law", density=1.0)
        with pytest.raises(UsageError, match=message) as caught:
            parameters_of(entry, D)
        where = "the material 'law': LawParameters.stress (<string>:12) "
        assert str(caught.value).startswith(where)

    for count in {*COUNTS, 1, 2, wanted - 1, wanted + 1, 9} - {wanted}:
        told = rf"the {wanted} components xx yy zz.* in {D}D as a tuple, but returns a tuple of"
        refused(f"({'J, ' * count})", f"{told} {count}$")
    refused("J", "as a tuple, but returns a float$")
    refused("F[0] > 1.0", "as a tuple, but returns a bool$")
    refused("None", "as a tuple, but returns None$")
    refused("[J] * 6", r"as a tuple, but returns .*list")
    more = ", J" * (wanted - 2)
    refused(f"(J, 1j * J{more})", f"{wanted} floats, but the component yy is a complex number$")
    refused(f"(J, 0{more})", "the component yy is an int; write 0.0 for 0$")
    refused(f"(J > 1.0, J{more})", "the component xx is a bool$")
    refused(f"(J, (J, J){more})", "the component yy is a tuple of 2$")


def test_an_energy_or_speed_that_is_no_float_is_refused(registered):
    for result, message in {
        "(J,)": "a tuple of 1",
        "F": "a tuple of 4",
        "J > 1.0": "a bool",
        "0": "an int; write 0.0 for 0",
        "1j * J": "a complex number",
        "np.zeros(3)": "an array",
        "None": "None",
        "np.float32(J)": "float32",
    }.items():
        for quantity in ("energy", "speed"):
            text = law(speed=result if quantity == "speed" else "J")
            if quantity == "energy":
                text = text.replace("return 0.0", f"return {result}")
            entry = registered(text, np=np)["Law"](model="law", density=1.0)
            told = rf"'law': LawParameters\.{quantity} \(<string>:\d+\) must return a float, but "
            with pytest.raises(UsageError, match=f"{told}returns {message}$"):
                parameters_of(entry, 2)


def test_a_stress_that_is_right_in_another_dimension_only(registered):
    entry = registered(law("(0.0, 0.0, 0.0)"))["Law"](model="law", density=1.0)
    parameters_of(entry, 1)
    for D in (2, 3):
        with pytest.raises(UsageError, match="returns a tuple of 3"):
            parameters_of(entry, D)


def test_a_wrong_stress_stops_a_run_before_anything_is_written(tmp_path, python, mpirun):
    """With file and line, status 2 on every rank; a corrected one runs, and is asked only once."""
    write_law(tmp_path, stress="(J, J, J, J, J)")
    case = scene(2, box([1, 1], [3, 3])) | {"materials": {"soft": {"model": "law", "density": 1.0}}}
    write_case(tmp_path / "case.yaml", case)
    words = ["-m", "pgimp", "--import", "law.py", "case.yaml", "-o", "out"]
    check = ["-m", "pgimp", "check", "--import", "law.py", "case.yaml"]
    for done in (mpirun(2, words, cwd=tmp_path), python(check, cwd=tmp_path)):
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        told = f"the material 'law': LawParameters.stress ({tmp_path}/law.py:12) must return the 4"
        assert done.stderr.count(told) == 1
    assert not (tmp_path / "out").exists()
    write_law(tmp_path)
    program = (
        "from pgimp.physics.materials import registry\n"
        "from pgimp.physics.materials.parameters import evaluate, outside\n"
        "registry.import_file('law.py')\n"
        "import law, numba\n"
        "for D in (1, 2): outside.parameters_of(law.Law(model='law', density=1.0), D)\n"
        "print(evaluate.compiled.cache_info())"
    )
    env = {"PGIMP_CACHE_DIR": str(tmp_path / "cache")}
    for misses in (3, 0):
        done = python(["-c", program], cwd=tmp_path, env=env)
        assert f"misses={misses}," in done.stdout, done.stderr


def test_parameters_may_be_tuples_and_arrays(registered):
    text = law(speed="material.pair[1] * material.table[2]").replace(
        "density: float", "density: float\n    pair: tuple\n    table: np.ndarray"
    )
    text = text.replace("(self.density)", "(self.density, (1.0, 2.0), np.arange(3.0))")
    assert ask(registered(text, np=np)["Law"](model="law", density=1.0)) == 4.0


def test_a_wrong_entry_of_a_material_from_outside(registered):
    registered(law())
    case = scene(1, box([1], [3])) | {"materials": {"soft": {"model": "law", "density": -1.0}}}
    with pytest.raises(CaseError, match=r"case: materials\.soft\.density: must be above 0"):
        pgimp.load(case)
