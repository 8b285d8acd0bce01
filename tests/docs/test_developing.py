"""docs/developing.md keeps its word: what it adds to the package works as printed, in a copy."""

import shutil
import sys

import numpy as np
import pytest
from pages import ENVIRONMENT, ROOT, apply, block_of, blocks
from processes import run
from two_blocks import CASE

pytestmark = pytest.mark.slow(30)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A folder with the package and its tests, to which every example of the page is added."""
    source = tmp_path_factory.mktemp("developing")
    for name in ("pgimp", "tests"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    (source / "cases").symlink_to(ROOT / "cases")
    shutil.copy(ROOT / "pyproject.toml", source)
    (source / "case.yaml").write_text(CASE)
    physics = source / "pgimp" / "physics"
    for beginning, path in {
        '"""Slightly compressible': "materials/fluid.py",
        '"""Quadratic B-splines': "shapes/quadratic_spline.py",
        '"""A rough wall': "boundaries/rough.py",
        '"""Coulomb friction up': "contact/limited.py",
        '"""Drag: a force': "loads/drag.py",
    }.items():
        (physics / path).write_text(block_of(beginning))
    (source / "tests/physics/materials/test_fluid.py").write_text(block_of('"""The fluid'))
    changed = {
        "Fluid": physics / "materials/__init__.py",
        "QuadraticSpline": physics / "shapes/__init__.py",
        "Rough": physics / "boundaries/__init__.py",
        "Limited": physics / "contact/__init__.py",
        "Drag": physics / "loads/__init__.py",
        "jacobian": physics / "fields.py",
        "centre of mass": source / "pgimp/solver/history/columns.py",
    }
    differences = blocks("diff")
    for word, path in changed.items():
        mine = [each for each in differences if word in each]
        assert mine, word
        for difference in mine:
            differences.remove(difference)
            apply(difference, path)
    assert not differences
    return source


def python(source, *words):
    """Run Python with the copy of the package; return what it prints.

    Kernels of the copy are kept where all others are, in a folder that is named after what they are
    made of: they are compiled again when the page or the package changes. Those of its tests stand
    for the place of the file, which is another each time, so they are not kept.
    """
    env = ENVIRONMENT | {"PYTHONPATH": str(source)}
    if "pytest" in words:
        env |= {"PGIMP_CACHE_DIR": str(source / "cache")}
    done = run([sys.executable, *words], 500, source, env)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_what_is_added_is_in_the_style_of_the_package(source):
    python(source, "-m", "ruff", "check", "pgimp", "tests/physics/materials/test_fluid.py")


def test_the_reference_has_what_is_added(source):
    page = python(source, "-m", "pgimp", "schema", "--markdown")
    for text in ("`fluid`", "`quadratic-spline`", "`centre-AXIS`", "`jacobian`"):
        assert text in page
    assert "| `body-force.drag.rate` | of decay of a uniform velocity | 1/time |" in page


def test_material(source):
    """It passes its test, and disks of it run."""
    tested = python(source, "-m", "pytest", "-q", "--all", "tests/physics/materials/test_fluid.py")
    assert "....." in tested
    water = "materials.jelly={model: fluid, bulk: 1.0e3, shear_viscosity: 1.0, density: 1.0e3}"
    words = ["-m", "pgimp", "cases/disks.yaml", "-o", "water.out"]
    python(source, *words, "--set", water, "--set", "contact=[]", "--set", "time.end=0.05")


#: Each prints what the package of the page computes, and what it is compared with.
COLLISION = """
import pgimp

for each in (1, 2):
    found = []
    for shape in ("quadratic-spline", "gimp"):
        method = {"shape": shape, "particles-per-cell": [each, each]}
        sim = pgimp.Simulation("case.yaml", overrides={"method": method})
        sim.advance()
        line = sim.diagnostics()
        found.append(line["strain-energy"])
    print(*found, line["kinetic-energy"])
"""


@pytest.mark.wide
def test_shape(source):
    """Its weights are those of quadrature; with one particle a cell it is gimp."""
    words = ["tests/physics/shapes/test_shapes.py", "-k", "quadratic-spline"]
    assert "passed" in python(source, "-m", "pytest", *words)
    one, two = (
        [float(word) for word in line.split()]
        for line in python(source, "-c", COLLISION).splitlines()
    )
    assert one[0] == pytest.approx(one[1], rel=1e-9) and one[0] > 0.01 * one[2]
    assert two[0] != pytest.approx(two[1], rel=1e-3)


#: Two blocks fall and slide at the same speed.
SLIDING = """
import numpy as np
import pgimp

velocity = [1.0, -1.0]
changes = {"boundaries": {"y-min": FLOOR}, "time.end": 1.2}
changes |= {f"bodies.{name}.velocity": velocity for name in ("left", "right")}
sim = pgimp.Simulation("case.yaml", overrides=changes)
first = sim.diagnostics()
sim.advance()
last = sim.diagnostics()
J = np.linalg.det(sim.particles["deformation"].reshape(-1, 3, 3))
np.testing.assert_allclose(sim.particles["jacobian"], J, rtol=1e-12)
print(last["momentum-x"] / first["momentum-x"])
"""


@pytest.mark.wide
def test_boundary_condition_and_field(source):
    """Blocks that fall are slowed down by the rough floor alone; the field is det F by NumPy."""
    found = [
        float(python(source, "-c", SLIDING.replace("FLOOR", repr(floor))))
        for floor in ("unilateral", "rough")
    ]
    assert found[0] == pytest.approx(1.0, abs=1e-12)
    assert found[1] < 0.9


#: A block with a base of 3 slides on a rigid plate for 2 s, under a weight of 9.
ON_PLATE = """
import pgimp

bodies = {
    "block": {"material": "soft", "region": {"box": {"min": [2.0, 1.0], "max": [5.0, 4.0]}},
              "velocity": [2.0, 0.0]},
    "plate": {"rigid": {}, "region": {"box": {"min": [-2.0, -2.0], "max": [14.0, 1.0]}}},
}
changes = {"bodies": bodies, "boundaries": {}, "gravity": [0.0, -1.0]}
for law in ("friction", {"limited": {"limit": 1.0e9}}, {"limited": {"limit": 0.1}}):
    changes["contact"] = [{"bodies": "all", "friction": 0.3, "law": law}]
    sim = pgimp.Simulation("case.yaml", overrides=changes)
    first = sim.diagnostics()["momentum-x"]
    sim.advance()
    print(repr(first - sim.diagnostics()["momentum-x"]))
"""


@pytest.mark.wide
def test_law_of_contact(source):
    """Below the limit it is friction, to the bit; above it the force is limit times area."""
    friction, high, low = (float(line) for line in python(source, "-c", ON_PLATE).split())
    assert high == friction == pytest.approx(0.3 * 9.0 * 2.0, rel=0.03)
    assert low == pytest.approx(0.1 * 3.0 * 2.0, rel=0.03)  # the block leaves the plate at times


#: Blocks that fly through empty space in 100 steps of 0.01.
FLYING = """
import numpy as np
import pgimp

changes = {f"bodies.{name}.velocity": [0.8, 0.3] for name in ("left", "right")}
changes |= {"body-force": {"drag": {"rate": 2.0}}, "time.end": 1.0}
sim = pgimp.Simulation("case.yaml", overrides=changes)
first = sim.diagnostics()
sim.advance()
last = sim.diagnostics()
print(last["momentum-x"] / first["momentum-x"], last["momentum-y"] / first["momentum-y"])
print(last["kinetic-energy"] / first["kinetic-energy"], last["external-work"])
print(last["centre-x"], last["centre-y"])
particles = sim.particles
print(*np.average(particles["position"], axis=0, weights=particles["mass"])[:2])
print(*list(last)[:6])
"""


@pytest.mark.wide
def test_load_and_output(source):
    """Speed falls by 1 - rate dt a step; the new columns are what NumPy says of the particles."""
    lines = [line.split() for line in python(source, "-c", FLYING).splitlines()]
    (px, py), (kinetic, work), centre, average = np.array(lines[:4], float)
    left = (1.0 - 2.0 * 0.01) ** 100
    assert px == pytest.approx(left, rel=1e-10) and py == pytest.approx(left, rel=1e-10)
    assert kinetic == pytest.approx(left**2, rel=1e-10)
    lost = 0.5 * 18.0 * (0.8**2 + 0.3**2) * (left**2 - 1.0)
    assert work == pytest.approx(lost, rel=0.02)  # of first order in the step
    np.testing.assert_allclose(centre, average, rtol=1e-13)
    assert lines[4] == ["time", "step", "dt", "mass", "centre-x", "centre-y"]
