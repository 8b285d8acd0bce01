"""Materials from outside the package: the same bits, no stale kernel, where they come from."""

import os
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from scenes import SOFT, box, scene, write_case
from written_laws import law, write_law

import pgimp
from pgimp.errors import UsageError
from pgimp.jit import outside
from pgimp.physics.materials import NeoHookean, registry

pytestmark = pytest.mark.slow(30)

# The speed of a particle at rest, asked of a kernel of the package, and how often it was cached.
ASK = """
import sys
import numpy as np
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.sums.sums import fastest_rate
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.parameters.outside import parameters_of
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import Particles


def ask():
    law = parameters_of(MATERIALS["law"](model="law", density=1.0), 1)
    frame = Frame((0.0,), (1.0,), (1.0,), (4,), 1)
    p = Particles.empty(1, Carried(1))
    rows, zero = np.zeros(1, np.int32), np.zeros(1, np.int64)
    rate = fastest_rate(KernelScene((), frame, (1.0,), (law,), zero), p, rows, True)
    print(rate, sum(fastest_rate.stats.cache_hits.values()))
"""


IMPORTED = (
    f"{ASK}\nfrom pgimp.physics.materials.registry import import_file\nimport_file('law.py')\nask()"
)


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
            for name in set(own) - {"VTKHDF"}:  # links to these
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
