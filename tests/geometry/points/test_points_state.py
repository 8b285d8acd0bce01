"""State variables of particles from a file: what it gives is what the run begins with."""

import shutil

import numpy as np
import pytest
from meshes import case
from outside_materials import SOFTENING, registered
from point_files import write_csv, write_hdf5
from run_files import go_back
from scenes import write_case

import pgimp
from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.physics.materials.registry import import_file
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.bodies.populate import populate
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene

SOFT = {"model": "softening", "young": 100.0, "poisson": 0.3, "density": 1.0} | {
    "damage": 0.9, "toughness": 1.0,
}  # fmt: skip
HARDENING = """
from typing import ClassVar, Literal, NamedTuple

import pgimp
from pgimp.jit.algebra import isotropic, symmetric
from pgimp.physics.materials import Material, State


class HardeningParameters(NamedTuple):
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        return isotropic(0.0, symmetric(L), J - 1.0), state

    @staticmethod
    def energy(material, F, J, sigma, state):
        return 0.0

    @staticmethod
    def speed(material, F, J, state):
        return 1.0


@pgimp.register_material
class Hardening(Material):
    STATE: ClassVar = (
        State("temperature", "1", "of the particle", initial=300.0),
        State("back-stress", "stress", "centre of the yield surface", tensor=True),
        State("plastic-strain", "1", "sum of its rate"),
    )
    model: Literal["hardening"]

    def parameters(self):
        return HardeningParameters(self.density)
"""
PAIRS = ("xx", "yy", "zz", "xy", "yz", "xz")


@pytest.fixture(scope="module", autouse=True)
def materials(tmp_path_factory):
    path = tmp_path_factory.mktemp("hardening") / "hardening.py"
    path.write_text(HARDENING)
    with registered(SOFTENING):
        import_file(str(path))
        yield


def cloud(D, n=40):
    """Particles in one corner of the domain, at any place."""
    rng = np.random.default_rng(D)
    x = rng.uniform(-1.9, -0.3, (n, D))
    return {"position": x, "volume": rng.uniform(0.01, 0.03, n)}


def cloud_case(path, D, law, **parts):
    model = case({"points": {"file": str(path)}}, dimension=D, **parts)
    model["materials"] = {"soft": law}
    return model


def populated(model):
    """The particles of a case by id, before any step."""
    model = Case.model_validate(model)
    share(model, Serial())
    scene = Scene(model)
    lattice, counts, _ = count_particles(scene, Serial())
    particles = populate(scene, lattice, counts, (0, lattice.planes))
    return particles, np.argsort(particles.id)


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("D", [1, 2, 3])
def test_states_are_those_of_the_file_and_the_others_the_materials(tmp_path, D, ending):
    """A number and a tensor of three variables; the first keeps what the material says."""
    data, width = cloud(D), (3, 4, 6)[D - 1]
    tensor = np.random.default_rng(1).normal(size=(40, width))
    strain = np.linspace(0.0, 0.5, 40)
    path = tmp_path / f"p.{ending}"
    if ending == "csv":
        columns = {f"back-stress-{pair}": tensor[:, i] for i, pair in enumerate(PAIRS[:width])}
        write_csv(path, data, **columns, **{"plastic-strain": strain})
    else:
        padded = np.zeros((40, 6))
        padded[:, :width] = tensor
        write_hdf5(path, data | {"back-stress": padded, "plastic-strain": strain})
    p, order = populated(cloud_case(path, D, {"model": "hardening", "density": 1.0}))
    np.testing.assert_array_equal(p.state[order, 0], 300.0)
    np.testing.assert_array_equal(p.state[order, 1 : 1 + width], tensor)
    np.testing.assert_array_equal(p.state[order, 1 + width], strain)


HEAD = "x,y,volume,damage\n0,0,0.1,0.5\n"
TENSOR_HEAD = "x,y,volume," + ",".join(f"back-stress-{pair}" for pair in PAIRS[:4])


@pytest.mark.parametrize(
    ("model", "text", "message"),
    [
        ("softening", HEAD + "1,0,0.1,half\n", "line 3, column damage: 'half' is no number"),
        ("softening", HEAD + "1,0,0.1,nan\n", "p.csv: line 3: the damage is not finite"),
        (
            "softening",
            HEAD.replace("damage", "damge"),
            "line 1, .*: unknown 'damge'. Expected x,y,volume and, if wanted, .*; "
            "peak-energy; damage$",
        ),
        ("softening", HEAD.replace("damage", "temperature"), "unknown 'temperature'"),
        ("neo-hookean", HEAD, "unknown 'damage'"),
        (
            "hardening",
            TENSOR_HEAD.replace(",back-stress-xy", "") + "\n0,0,0.1,0,0,0\n",
            "missing back-stress-xy",
        ),
        (
            "hardening",
            TENSOR_HEAD + ",back-stress-xz\n0,0,0.1,0,0,0,0,0\n",
            "back-stress-xz, which a case in 2D does not have",
        ),
        (
            "hardening",
            TENSOR_HEAD + "\n0,0,0.1,0,0,0,inf\n",
            "line 2: the back-stress-xy is not finite",
        ),
    ],
)
def test_columns_that_are_wrong_are_named(tmp_path, model, text, message):
    (tmp_path / "p.csv").write_text(text)
    laws = {
        "softening": SOFT,
        "neo-hookean": {"model": "neo-hookean", "young": 1.0, "poisson": 0.3, "density": 1.0},
        "hardening": {"model": "hardening", "density": 1.0},
    }
    with pytest.raises(CaseError, match=message) as refused:
        populated(cloud_case(tmp_path / "p.csv", 2, laws[model]))
    assert "bodies.body.region" in str(refused.value)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"damage": np.full(40, np.nan)}, r"row 0 \(from 0\): the damage is not finite"),
        ({"damage": np.zeros((40, 2))}, r"'damage' has the shape \(40, 2\); expected \(n,\)"),
        ({"damage": np.zeros(39)}, "39 rows of damage, but 40 of position"),
    ],
)
def test_datasets_that_are_wrong_are_named(tmp_path, data, message):
    write_hdf5(tmp_path / "p.h5", cloud(2) | data)
    with pytest.raises(CaseError, match=message):
        populated(cloud_case(tmp_path / "p.h5", 2, SOFT))


def test_check_says_which_states_a_file_gives(tmp_path, capsys):
    write_csv(tmp_path / "p.csv", cloud(2), damage=np.zeros(40))
    write_case(tmp_path / "p.yaml", cloud_case(tmp_path / "p.csv", 2, SOFT))
    assert main(["check", "-v", str(tmp_path / "p.yaml")]) == 0
    assert "; with damage" in capsys.readouterr().out


def test_a_run_begins_with_them_on_any_ranks_and_resumes(tmp_path, mpirun):
    """Stress follows from them, by NumPy; frames on 1, on 3 and resumed on 2 ranks are the same."""
    axis = np.arange(-1.375, 1.5, 0.25)
    x = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    n = len(x)
    # Peaks that nothing in the run exceeds: the damage stays what the peaks make of it.
    peak = np.linspace(50.0, 90.0, n)
    data = {"position": x, "volume": np.full(n, 0.0625), "velocity": 0.3 * x[:, ::-1]}
    write_csv(tmp_path / "p.csv", data, damage=0.9 * peak / (peak + 1.0), **{"peak-energy": peak})
    model = cloud_case("p.csv", 2, SOFT, end=0.2, step=0.01)
    fields = ["stress", "deformation", "damage", "peak-energy"]
    model["output"] = {"every": 0.1, "fields": fields}
    model["checkpoint"] = {"every": {"steps": 5}, "keep": 50}
    write_case(tmp_path / "p.yaml", model)
    program = ["-m", "pgimp", "--import", SOFTENING, "p.yaml", "--quiet", "-o"]
    for ranks in (1, 3):
        done = mpirun(ranks, [*program, str(ranks)], cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    shutil.copytree(tmp_path / "3", tmp_path / "resumed")
    go_back(tmp_path / "resumed", 0.5)
    done = mpirun(2, [*program, "resumed", "--resume"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    run = pgimp.open(tmp_path / "1")
    np.testing.assert_array_equal(run.frame(0)["peak-energy"], peak)
    last = run.frame(-1)
    np.testing.assert_array_equal(last["peak-energy"], peak)
    F = last["deformation"].reshape(-1, 3, 3)
    J = np.linalg.det(F)[:, None, None]
    lam, mu = 100.0 * 0.3 / (1.3 * 0.4), 100.0 / 2.6
    sound = (mu * (F @ F.transpose(0, 2, 1) - np.eye(3)) + lam * np.log(J) * np.eye(3)) / J
    left = 1.0 - 0.9 * peak / (peak + 1.0)
    for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1))):
        wanted = left * sound[:, i, j]
        np.testing.assert_allclose(last["stress"][:, column], wanted, 1e-10, 1e-12)
    assert np.abs(last["stress"]).max() > 0.01
    for name in ("3", "resumed"):
        files = [*(tmp_path / "1/frames").iterdir(), tmp_path / "1/history.csv"]
        assert len(files) > 3
        for path in files:
            other = tmp_path / name / path.relative_to(tmp_path / "1")
            assert path.read_bytes() == other.read_bytes(), other
