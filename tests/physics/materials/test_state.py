"""Materials that remember: their state variables in kernels, runs, checkpoints, frames, probes."""

import shutil

import numpy as np
import pytest
from outside_materials import SOFTENING as SOFTENING_FILE
from outside_materials import registered
from remembering import SOFTENING, two_blocks
from scenes import start, write_case
from tiers import wide

import pgimp


@pytest.fixture(scope="module", autouse=True)
def softening():
    with registered(SOFTENING_FILE) as (module,):
        yield module


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mpirun):
    """Runs of the two blocks on 1, 3 and 7 ranks, in a folder."""
    folder = tmp_path_factory.mktemp("state")
    write_case(folder / "blocks.yaml", two_blocks())
    pgimp.run(folder / "blocks.yaml", output=folder / "1", quiet=True)
    for ranks in (3, 7):
        go(mpirun, folder, ranks, str(ranks))
    return folder


def go(mpirun, folder, ranks, output, *words):
    program = ["-m", "pgimp", "--import", SOFTENING_FILE, "blocks.yaml", "-o", output]
    done = mpirun(ranks, [*program, "--quiet", *words], cwd=folder)
    assert done.returncode == 0, done.stderr


def undamaged(F, lam, mu):
    """Energy of the neo-Hookean solid from F (n, 9), by NumPy."""
    F = F.reshape(-1, 3, 3)
    ln = np.log(np.linalg.det(F))
    return 0.5 * mu * ((F * F).sum(axis=(1, 2)) - 3.0) - mu * ln + 0.5 * lam * ln**2


def test_the_state_is_that_of_the_history_of_each_particle(runs):
    """Its peak energy is the greatest that its deformations had, from frame to frame."""
    run = pgimp.open(runs / "1")
    lam, mu = 100.0 * 0.3 / (1.3 * 0.4), 100.0 / 2.6
    peak = np.zeros(len(run.frame(0)))
    for frame in run:
        peak = np.maximum(peak, undamaged(frame["deformation"], lam, mu))
        soft = np.array(frame.materials)[frame["material"]] == "soft"
        assert soft.any() and not soft.all()
        # Sums of squares and logarithms lose what is below 1e-16 of the moduli.
        np.testing.assert_allclose(frame["peak-energy"][soft], peak[soft], 1e-12, 1e-13)
        damage = 0.9 * peak[soft] / (peak[soft] + 1.0)
        np.testing.assert_allclose(frame["damage"][soft], damage, 1e-12, 1e-13)
        assert np.isnan(frame["damage"][~soft]).all()
    assert damage.max() > 0.5 and np.ptp(damage) > 0.3


@pytest.mark.parametrize("ranks", [3, 7])
def test_any_number_of_ranks_leaves_the_same_bytes(runs, ranks):
    same(runs / "1", runs / str(ranks))


def same(one, other):
    files = [*(one / "frames").iterdir(), *(one / "probes").iterdir(), one / "history.csv"]
    assert len(files) > 20
    for path in files:
        assert path.read_bytes() == (other / path.relative_to(one)).read_bytes(), path


@pytest.mark.parametrize(("began", "ranks"), [(1, 3), (3, 2)])
def test_a_killed_run_goes_on_with_its_state(runs, mpirun, began, ranks):
    name = f"{began}-then-{ranks}"
    shutil.copytree(runs / str(began), runs / name)
    for path in sorted((runs / name / "checkpoints").iterdir())[3:]:
        path.unlink()
    info = runs / name / "run.json"
    info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))
    go(mpirun, runs, ranks, name, "--resume")
    same(runs / "1", runs / name)


def test_probes_tables_and_pictures_show_it(runs, tmp_path, capsys):
    run = pgimp.open(runs / "1")
    own, none = run.probes["own"], run.probes["none"]
    number = int(run.info["steps"])
    assert len(own["damage"]) == number + 1
    assert (np.diff(own["damage"]) >= 0.0).all() and own["damage"][-1] > 0.1
    assert np.isnan(none["damage"]).all()
    table = run.frame(-1).to_pandas()
    assert {"damage", "peak-energy"} <= set(table.columns)
    from pgimp.cli import main

    out = tmp_path / "damage.csv"
    words = ["plot", str(runs / "1"), "--field", "damage", "--frame", "-1", "-o", str(out)]
    assert main(words) == 0, capsys.readouterr().err
    drawn = np.genfromtxt(out, delimiter=",", names=True)
    assert np.nanmax(drawn["damage"]) == pytest.approx(np.nanmax(run.frame(-1)["damage"]), rel=1e-6)
    sim = pgimp.Simulation(two_blocks())
    assert (sim.particles["damage"][np.isfinite(sim.particles["damage"])] == 0.0).all()


@pytest.mark.parametrize(("dimension", "shape"), [(1, "fuzzy-constant"), wide(3, "mpm")])
def test_it_goes_with_other_shapes_affine_and_viscosity(dimension, shape):
    case = two_blocks(dimension, shape=shape)
    case["method"]["affine"] = True
    case["materials"]["soft"] = SOFTENING | {"viscosity": {"linear": 0.1, "quadratic": 1.0}}
    case["time"] = {"end": 0.1, "step": {"courant": 0.1}}
    sim = start(case)
    while not sim.finished:
        sim.advance()
    soft = sim.particles.body[sim.live()] == 0
    state = sim.particles.state[sim.live()]
    assert state[soft, 1].max() > 1e-3 and not state[~soft].any()
