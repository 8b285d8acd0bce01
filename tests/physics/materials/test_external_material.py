"""Materials from outside the package: the same bits, no stale kernel, messages for mistakes."""

import os
import re
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from material_driver import response
from scenes import SOFT, box, scene, write_case

import pgimp
from pgimp.errors import CaseError, UsageError
from pgimp.jit import outside
from pgimp.kernels.concepts import Setting
from pgimp.kernels.particles import Carried, Frame, Particles
from pgimp.kernels.sums import fastest_rate
from pgimp.physics.materials import MATERIALS, NeoHookean, registry
from pgimp.physics.materials.outside import parameters_of

ROOT = Path(__file__).resolve().parents[3]
CASES = ROOT / "cases"
PAGE = (ROOT / "docs" / "materials.md").read_text(encoding="utf-8")

LAW = """
from typing import Literal, NamedTuple
import pgimp
from pgimp.physics.materials import Material
from {helper} import faster

FACTOR = {factor}

class LawParameters(NamedTuple):
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        return {stress}

    @staticmethod
    def energy(material, F, J, sigma):
        return 0.0

    @staticmethod
    def speed(material, F, J):
        return {speed}

@pgimp.register_material
class Law(Material):
    model: Literal["law"]

    def parameters(self):
        return LawParameters(self.density)
"""

HELPER = """
import numba

@numba.njit
def faster(c):
    return {times} * c
"""

# The speed of a particle at rest, asked of a kernel of the package, and how often it was cached.
ASK = """
import sys
import numpy as np
from pgimp.kernels.concepts import Setting
from pgimp.kernels.sums import fastest_rate
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.outside import parameters_of
from pgimp.kernels.particles import Carried, Frame, Particles

def ask():
    law = parameters_of(MATERIALS["law"](model="law", density=1.0), 1)
    frame = Frame((0.0,), (1.0,), (1.0,), (4,), 1)
    p = Particles.empty(1, Carried(1))
    rows, zero = np.zeros(1, np.int32), np.zeros(1, np.int64)
    rate = fastest_rate(Setting((), frame, (1.0,), (law,), zero), p, rows, True)
    print(rate, sum(fastest_rate.stats.cache_hits.values()))
"""
IMPORTED = (
    f"{ASK}\nfrom pgimp.physics.materials.registry import import_file\nimport_file('law.py')\nask()"
)


def write_law(folder, factor=2.0, times=1.0, speed="faster(FACTOR)", stress="sigma", helper="aid"):
    folder.mkdir(exist_ok=True)
    text = LAW.format(factor=factor, speed=speed, stress=stress, helper=helper)
    (folder / "law.py").write_text(text)
    (folder / f"{helper}.py").write_text(HELPER.format(times=times))


def test_an_edited_material_is_compiled_anew(tmp_path, python):
    """Function, constant, helper; another project's of the same names; and in `__main__`."""
    env = {"PGIMP_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}

    def ask(program=IMPORTED, folder=tmp_path / "one"):
        done = python(["-c", program], cwd=folder, env=env)
        assert done.returncode == 0, done.stderr
        return [tuple(map(float, line.split())) for line in done.stdout.splitlines()]

    write_law(tmp_path / "one")
    assert [ask(), ask()] == [[(2.0, 0)], [(2.0, 1)]]
    write_law(tmp_path / "one", speed="faster(2.0 * FACTOR)")
    assert ask() == [(4.0, 0)]
    write_law(tmp_path / "one", factor=3.0)
    assert ask() == [(3.0, 0)]
    write_law(tmp_path / "one", factor=3.0, times=0.5)
    assert ask() == [(1.5, 0)]
    write_law(tmp_path / "two", factor=7.0)
    assert ask(folder=tmp_path / "two") == [(7.0, 0)]
    write_law(tmp_path / "one")
    assert ask() == [(2.0, 1)]
    # In a notebook: edited and imported again; and cells, which Numba cannot cache, run again.
    again = "\nimport importlib, law, pathlib\np = pathlib.Path('law.py')\n"
    again += "p.write_text(p.read_text().replace('FACTOR = 2.0', 'FACTOR = 5.5'))\n"
    assert ask(IMPORTED + again + "importlib.reload(law)\nask()\n") == [(2.0, 1), (5.5, 1)]
    cells = f"{ASK}\nexec({(tmp_path / 'two/law.py').read_text()!r})\nask()\n"
    cells += cells.replace("FACTOR = 7.0", "FACTOR = 8.0")
    assert ask(cells, tmp_path / "two") == [(7.0, 0), (8.0, 0)]


def neo_hookean(folder):
    """The package's neo-Hookean solid as a file of one's own."""
    text = Path(sys.modules[NeoHookean.__module__].__file__).read_text()
    text = text.replace('"neo-hookean"', '"rubber"').replace("NeoHookean", "Rubber")
    text = text.replace(
        "\nclass Rubber(", "\nimport pgimp\n\n@pgimp.register_material\nclass Rubber("
    )
    (folder / "rubber.py").write_text(text)


@pytest.fixture(scope="module")
def rubber(tmp_path_factory, mpirun):
    """Folder with a run of the solid from outside, on two ranks, and one of the package's."""
    folder = tmp_path_factory.mktemp("rubber")
    neo_hookean(folder)
    case = scene(2, box([2, 1], [5, 4], [0.3, -0.2]), gravity=[0.0, -5.0], end=0.2)
    case |= {"boundaries": {"y-min": "slip"}, "output": {"every": 0.1, "fields": ["stress"]}}
    pgimp.run(case, output=folder / "own", quiet=True)
    write_case(folder / "case.yaml", case | {"materials": {"soft": SOFT | {"model": "rubber"}}})
    words = ["-m", "pgimp", "--import", "rubber.py", "case.yaml", "-o", "outside", "--quiet"]
    done = mpirun(2, words, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_a_material_from_outside_gives_the_bits_of_the_same_one_inside(rubber):
    paths = sorted((rubber / "own/frames").iterdir())
    assert len(paths) == 3
    for path in paths:
        with h5py.File(path) as own, h5py.File(rubber / "outside/frames" / path.name) as other:
            assert set(own) == set(other)
            for name in own:
                assert np.array_equal(own[name][()], other[name][()]), name
    assert np.abs(h5py.File(paths[-1])["stress"][()]).max() > 1.0
    known = pgimp.open(rubber / "outside").info["materials"]
    assert list(known) == ["rubber.RubberParameters"] and len(next(iter(known.values()))) == 16
    assert "materials" not in pgimp.open(rubber / "own").info


def test_the_case_alone_does_not_name_code(rubber, python):
    done = python(["-m", "pgimp", "case.yaml", "-o", "none"], cwd=rubber)
    assert done.returncode == 2
    assert "unknown model 'rubber'" in done.stderr and "--import FILE.py" in done.stderr
    assert not (rubber / "none").exists()


def test_studies_and_batch_jobs_import_it_too(rubber, python):
    study = {"format": 1, "case": "case.yaml", "sweep": [{"materials.soft.young": [50.0]}]}
    write_case(rubber / "study.yaml", study | {"error": {"column": "mass", "reference": 9.0}})
    words = "study study.yaml --import rubber.py --list".split()
    done = python(["-m", "pgimp", *words], cwd=rubber)
    assert f"--import {rubber / 'rubber.py'} -o" in done.stdout, done.stderr
    words = "batch case.yaml --import rubber.py --ranks 2 --wall-time 1:00:00 --script -".split()
    done = python(["-m", "pgimp", *words], cwd=rubber)
    assert f"--import={rubber / 'rubber.py'} </dev/null" in done.stdout, done.stderr


def test_an_installed_package_brings_materials(rubber, tmp_path, python):
    neo_hookean(tmp_path)
    about = tmp_path / "plug-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: plug\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[pgimp.materials]\nrubber = rubber:Rubber\n")
    program = "import pgimp; print(pgimp.load('case.yaml').materials['soft'].model)"
    paths = {"PYTHONPATH": os.pathsep.join([str(tmp_path)])}
    assert python(["-c", program], cwd=rubber, env=paths).stdout == "rubber\n"
    (about / "entry_points.txt").write_text("[pgimp.materials]\nrubber = gone:Rubber\n")
    done = python(["-m", "pgimp", "case.yaml"], cwd=rubber, env=paths)
    assert done.returncode == 2 and "'rubber' of plug (gone:Rubber) cannot be loaded" in done.stderr


@pytest.fixture
def registered(monkeypatch):
    """Register what is written in a file's text; forgotten after the test."""
    monkeypatch.setattr("pgimp.physics.materials.MATERIALS", registry.Registry(dict(MATERIALS)))

    def register(text, **names):
        space = {"__name__": "elsewhere", **names}
        exec(text, space)
        return space

    return register


def law(stress="sigma", speed="FACTOR", factor=2.0):
    text = LAW.format(factor=factor, speed=speed, stress=stress, helper="math")
    return text.replace("from math import faster", "from math import sqrt, log, exp")


def ask(entry, dimensions=1):
    parameters = parameters_of(entry, dimensions)
    D = dimensions
    frame = Frame((0.0,) * D, (1.0,) * D, (1.0,) * D, (4,) * D, 1)
    one = tuple(np.eye(D).ravel())
    rows, zero = np.zeros(1, np.int32), np.zeros(1, np.int64)
    setting = Setting((), frame, one, (parameters,), zero)
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


#: What a stress in 1D, 2D and 3D has.
COUNTS = (3, 4, 6)


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
        "from pgimp.physics.materials import evaluate, outside, registry\n"
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


@pytest.fixture(scope="module")
def maxwell(tmp_path_factory):
    """The material that docs/materials.md shows, as a file that is imported."""
    (text,) = re.findall(r'^```python\n("""Maxwell.*?)^```$', PAGE, re.MULTILINE | re.DOTALL)
    path = tmp_path_factory.mktemp("maxwell") / "maxwell.py"
    path.write_text(text)
    registry.import_file(str(path))
    yield {"model": "maxwell", "young": 100.0, "poisson": 0.3, "time": 0.05, "density": 1.0}
    del MATERIALS["maxwell"]


def test_an_initial_stress_relaxes_in_the_material_of_the_page(maxwell, tmp_path):
    """A bar at rest between two walls, from `points`: the deviator falls by 1/(1 + dt/T) a step."""
    x = np.arange(0.25, 8.0, 0.5)
    given = np.array([-3.0, 1.5, 6.0])
    names = ["x", "volume", *(f"stress-{part}" for part in ("xx", "yy", "zz"))]
    rows = [[place, 0.5, *given] for place in x]
    lines = [",".join(map(repr, row)) for row in np.array(rows).tolist()]
    (tmp_path / "bar.csv").write_text("\n".join([",".join(names), *lines, ""]))
    region = {"points": {"file": str(tmp_path / "bar.csv")}}
    case = scene(1, {"material": "soft", "region": region}, step=0.005, end=0.05)
    case |= {"materials": {"soft": maxwell}, "boundaries": {"x-min": "slip", "x-max": "slip"}}
    sim = pgimp.Simulation(case)
    assert sim.particles["stress"][:, :3] == pytest.approx(np.tile(given, (16, 1)))
    sim.advance()
    mean, kept = given.mean(), (1.0 + 0.005 / 0.05) ** -sim.steps
    assert sim.steps == 10
    found = sim.particles["stress"][:, :3]
    assert found == pytest.approx(np.tile(mean + kept * (given - mean), (16, 1)), rel=1e-12)


@pytest.mark.parametrize("D", [2, 3])
def test_the_stress_of_the_pages_material_turns_with_the_body(maxwell, D):
    """In a step of pure rotation it is Q S Q^T, with the rotation by Cayley's formula."""
    parameters = parameters_of(MATERIALS["maxwell"](**maxwell | {"time": 1e12}), D)
    rng = np.random.default_rng(5)
    W = rng.normal(size=(D, D))
    W -= W.T
    before = np.zeros((3, 3))
    before[:D, :D] = rng.normal(size=(D, D))
    before = before + before.T + np.diag([0.0, 0.0, 1.0])
    one = np.eye(D)
    Q = np.eye(3)
    Q[:D, :D] = np.linalg.solve(one - 0.05 * W, one + 0.05 * W)
    given = before[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]][: COUNTS[D - 1]]
    stress, energy, speed = response((parameters,), one, given, W, dt=0.1)
    assert stress == pytest.approx(Q @ before @ Q.T, rel=1e-9)
    lam, mu = parameters.lam, parameters.mu
    strain = (before - lam / (3 * lam + 2 * mu) * np.trace(before) * np.eye(3)) / (2 * mu)
    assert energy == pytest.approx(0.5 * np.sum(before * strain))
    assert speed == pytest.approx(np.sqrt(lam + 2 * mu))


def test_files_that_cannot_be_imported(tmp_path):
    (tmp_path / "wrong.py").write_text("x = 1\ny = x / 0\n")
    (tmp_path / "no-name.py").write_text("")
    (tmp_path / "syntax_error.py").write_text("def f(:\n")
    (tmp_path / "json.py").write_text("")
    for name, message in {
        "wrong.py": "wrong.py: line 2: ZeroDivisionError",
        "no-name.py": "'no-name' cannot be the name of a module",
        "syntax_error.py": "line 1: SyntaxError",
        "json.py": "another module of the name json; rename the file",
        "gone.py": "there is no such file",
    }.items():
        with pytest.raises(UsageError, match=message):
            registry.import_file(str(tmp_path / name))
    with pytest.raises(UsageError, match="No module named 'no_such_package'"):
        registry.import_file("no_such_package.laws")


def test_folders_are_not_imported(tmp_path, monkeypatch):
    """Python would take one for an empty package; one with ``__init__.py`` is a package."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(registry, "imported", [])
    (tmp_path / "some_laws").mkdir()
    for name in ("some_laws", "./some_laws/", str(tmp_path / "some_laws")):
        with pytest.raises(UsageError, match=r"it is a folder; name .*some_laws/FILE\.py$"):
            registry.import_file(name)
    assert registry.imported == []
    (tmp_path / "whole_laws").mkdir()
    (tmp_path / "whole_laws" / "__init__.py").write_text("")
    for name in ("whole_laws", "sys"):
        registry.import_file(name)


def test_the_digest_sees_what_functions_refer_to():
    """Another value, another helper, a longer table: another digest; the same again: the same."""
    digests = set()
    for factor, table in [(1.0, [1.0]), (2.0, [1.0]), (2.0, [1.0, 2.0]), (2.0, [1.0, 2.0])]:
        space = {"__name__": __name__, "TABLE": np.array(table)}
        exec(law(speed="FACTOR * TABLE[0]", factor=factor).partition("@pgimp")[0], space)
        kind = space["LawParameters"]
        kind.__qualname__ = "found_again"
        globals()["found_again"] = kind
        digests.add(outside.digest(kind))
    assert len(digests) == 3 and "" not in digests
    kind.__qualname__ = "f.<locals>.LawParameters"
    assert outside.digest(kind) == ""


def test_a_wrong_entry_of_a_material_from_outside(registered):
    registered(law())
    case = scene(1, box([1], [3])) | {"materials": {"soft": {"model": "law", "density": -1.0}}}
    with pytest.raises(CaseError, match=r"case: materials\.soft\.density: must be above 0"):
        pgimp.load(case)
