"""Particles that leave through faces that let them go: what is booked, what goes on without them.

That the number of ranks and a resume change no bit of such a run: tests/proofs/test_ranks.py.
"""

import warnings

import numpy as np
import pytest
from rank_scenes import SCENES
from scenes import box, finish, scene, start
from tiers import wide

import pgimp
from pgimp.case.schema import Case
from pgimp.errors import RunError
from pgimp.mpi.comm import Serial

AXES = "xyz"


def leaving(dimension, ways):
    """A stretched block, on its way out of a corner."""
    body = box([4.0] * dimension, [7.0] * dimension, [5.0] * dimension)
    case = scene(dimension, body, cells=[9] * dimension, end=0.8, step=0.02, outflow=ways)
    sim = start(case)
    sim.particles.F[:] *= 1.05
    return sim


def sums_of(p, rows, dimension):
    """Sums over the particles in `rows`, by the definitions, as the history names them."""
    x, v = (np.zeros((len(rows), 3)) for _ in range(2))
    x[:, :dimension], v[:, :dimension] = p.x[rows], p.v[rows]
    m, V0 = p.m[rows], p.V0[rows]
    F = p.F[rows].reshape(-1, dimension, dimension)
    if dimension == 1:
        W = 0.5 * 100.0 * (F[:, 0, 0] - 1.0) ** 2
    else:  # neo-Hookean, of the soft solid
        mu, lam = 100.0 / 2.6, 100.0 * 0.3 / (1.3 * 0.4)
        ln = np.log(np.linalg.det(F))
        W = 0.5 * mu * ((F**2).sum(axis=(1, 2)) - dimension) - mu * ln + 0.5 * lam * ln**2
    sums = {"mass": m.sum()}
    sums |= {f"momentum-{a}": m @ v[:, i] for i, a in enumerate(AXES[:dimension])}
    spin = m @ np.cross(x, v)
    for i in ((), (2,), (0, 1, 2))[dimension - 1]:
        sums[f"angular-momentum-{AXES[i]}"] = spin[i]
    return sums | {"kinetic-energy": 0.5 * m @ (v**2).sum(axis=1), "strain-energy": V0 @ W}


@pytest.mark.parametrize("dimension", [1, 2, wide(3)])
def test_the_ledger_is_the_sum_of_what_left(dimension):
    faces = [f"{axis}-max" for axis in AXES[:dimension]]
    sim = leaving(dimension, dict.fromkeys(faces, "remove"))
    first, corner = sim.diagnostics(), 0
    gone = sums_of(sim.particles, sim.live()[:0], dimension)
    energy = first["kinetic-energy"] + first["strain-energy"]
    while not sim.finished:
        before = sim.live()
        sim.advance()
        left = np.setdiff1d(before, sim.live())  # rows stay where they were until they are sorted
        beyond = sim.particles.x[left] > 9.0
        assert beyond.any(axis=1).all() and (sim.particles.x[sim.live()] <= 9.0).all()
        corner += int((beyond.sum(axis=1) > 1).sum())
        gone = {n: s + gone[n] for n, s in sums_of(sim.particles, left, dimension).items()}
        present = sums_of(sim.particles, sim.live(), dimension)
        line = sim.diagnostics()
        for name, value in present.items():
            scale = energy if "energy" in name else 100.0 * first["mass"]
            assert line[name] == pytest.approx(value, abs=1e-14 * scale), name
            assert line[f"outflow.{name}"] == pytest.approx(gone[name], abs=1e-14 * scale), name
            # Nothing acts on the block: its momentum is its own and that of what left.
            if name == "mass" or name.startswith("momentum"):
                total = line[name] + line[f"outflow.{name}"]
                assert total == pytest.approx(first[name], rel=1e-14 if name == "mass" else 1e-11)
        there = sum(present[name] + gone[name] for name in ("kinetic-energy", "strain-energy"))
        assert line["dissipated-energy"] == pytest.approx(energy - there, abs=1e-13 * energy)
    assert 0 < sim.present() < 0.6 * sim.count and (dimension == 1 or corner)
    assert sim.present() == sim.rank.count and sim.rank.ledger.escaped.shape[1:] == (1, 12)


def test_who_lets_nothing_go_pays_nothing():
    sim = leaving(2, {"x-max": "stop"})
    assert sim.rank.ledger.escaped.size == 0 and sim.scene.domain.exits == 0
    assert not [name for name in sim.diagnostics() if name.startswith("outflow")]


@pytest.mark.parametrize(
    ("ways", "face"),
    [
        ({"x-max": "remove", "y-min": "remove"}, "y-max"),
        ({"y-max": "remove", "x-max": "stop"}, "x-max"),
        ({"x-max": "remove", "y-max": "stop"}, "y-max"),
    ],
)
def test_other_faces_still_stop_the_run(ways, face):
    """Also where a particle has crossed one of each kind at once."""
    sim = leaving(2, ways)
    with pytest.raises(RunError, match=f"left the domain through {face}"):
        finish(sim)
    rows = sim.rank.errors[: sim.rank.failed, 0]
    axis = AXES.index(face[0])
    assert (sim.particles.x[rows, axis] > 9.0).all() and set(rows) <= set(sim.live())
    assert (sim.particles.x[rows, 1 - axis] > 9.0).any()
    with pytest.raises(RunError, match=f"left the domain through {face}"):
        sim.advance()  # there is no way on


@pytest.mark.parametrize(
    ("field", "value", "text"),
    [("v", 60.0, "moved by more than a cell"), ("F", np.nan, "not a finite number")],
)
def test_who_leaves_with_a_fault_is_at_fault(field, value, text):
    sim = leaving(2, {"x-max": "remove", "y-max": "remove"})
    sim.advance()
    victim = sim.live()[sim.particles.x[sim.live(), 0].argmax()]
    sim.particles.x[victim, 0] = 8.95
    getattr(sim.particles, field)[victim, 0] = value
    sim.population.sort()
    number = int(sim.particles.id[sim.particles.x[:, 0].argmax()])
    with pytest.raises(RunError, match=f"particle {number} of body 'body' .*{text}"):
        sim.advance()
    assert sim.particles.x[sim.rank.errors[0, 0], 0] > 9.0


@pytest.fixture(scope="module")
def emptied(tmp_path_factory):
    """The run of a scene that all particles leave, and the same under Courant control."""
    folder = tmp_path_factory.mktemp("emptied")
    case = SCENES["line_leaves"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = pgimp.run(Case.model_validate(case), Serial(), folder / "one", quiet=True)
        case = case | {"time": {"end": 1.8, "step": {"courant": 0.2}}}
        other = pgimp.run(Case.model_validate(case), Serial(), folder / "other", quiet=True)
    return run, other


def test_a_run_goes_on_when_all_have_left(emptied):
    for run in emptied:
        assert run.state == "done" and len(run.frame(0)) == 12 and len(run.frame(-1)) == 0
        last = run.history[-1]
        assert last["time"] == 1.8 and last["mass"] == last["kinetic-energy"] == 0.0
        assert last["outflow.mass"] == 9.0
        assert last["outflow.momentum-x"] == pytest.approx(99.0, rel=1e-13)
        assert np.isnan(last["body.ahead.centre-x"]) and np.isnan(last["body.behind.centre-x"])
        assert run.frame(-1)["stress"].shape == (0, 6)
        log = (run.path / "log.txt").read_text()
        assert "12 of 12 particles left through x-max" in log
    assert emptied[1].info["steps"] < 160  # where nothing is, one step leads to the next stop


def test_a_particle_is_followed_until_it_left(emptied):
    run, _ = emptied
    numbers = [frame["id"].tolist() for frame in run]
    assert 0 < len(numbers[4]) < 6 and numbers[4] == sorted(numbers[4])
    for number in (0, 5, 6, 11):
        path = run.follow(number)
        assert len(path["time"]) == sum(number in ids for ids in numbers) < len(run)
        assert (np.diff(path["position"][:, 0]) > 0.0).all() and path["position"].max() < 20.0
    with pytest.raises(KeyError, match="no particle 12"):
        run.follow(12)
