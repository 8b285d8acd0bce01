"""Samples of a case, from which the performance model has its costs."""

import numpy as np
import pytest
from scenes import box, scene, write_case
from two_blocks import flying

from pgimp.case.schema import Case
from pgimp.errors import RunError
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation
from pgimp.utilities.model.measure import costs_of, run_in_turn
from pgimp.utilities.model.sample import samples_of
from pgimp.utilities.model.sample_cases import resized


def test_a_resized_case_is_the_same_case():
    case = Case.model_validate(flying())
    coarse, fine = resized(case, 2.0), resized(case, 0.5)
    assert coarse.grid.cells == (6, 3) and fine.grid.cells == (24, 12)
    # The Courant number stays, and the end is far away.
    assert coarse.time.step == pytest.approx(0.02) and fine.time.step == pytest.approx(0.005)
    assert fine.time.steps > 100_000
    assert fine.materials == case.materials and fine.boundaries == case.boundaries
    # Where coarse cells leave a body nothing, or there is no room, another scene stands in.
    small = box([1.0, 1.0], [1.5, 1.5]) | {"surface": "whole-particles"}
    case = Case.model_validate(
        flying() | {"bodies": {"a": box([1.0, 1.0], [11.0, 5.0]), "b": small}}
    )
    (sample,) = samples_of(case, 164, [10])
    assert list(sample.sim.case.bodies) == ["sample"]


@pytest.mark.parametrize("bodies", [None, {"a": box([1.0, 1.0], [1.5, 1.5])}])
def test_samples_of_a_case_of_very_many_steps(bodies):
    """1e11 of them are no reason to refuse it, neither resized nor as a plain block."""
    case = flying() | {"time": {"end": 1e10, "step": {"courant": 0.3}}}
    if bodies:
        case["bodies"] = {"a": bodies["a"] | {"surface": "whole-particles"}}
    (sample,) = samples_of(Case.model_validate(case), 72, [10], 1e11)
    assert 1e10 <= sample.sim.case.time.end < 1e12 and not sample.sim.finished


SCATTER = """
import sys
import numpy as np
from pgimp import load
from pgimp.utilities.model.sample import Scattered
from pgimp.mpi.comm import world

sim = Scattered(load(sys.argv[1]), world())
for step in range(20):
    p, rows = sim.particles, sim.live()
    state = np.column_stack([p.id[rows], p.layer[rows], p.x[rows], p.v[rows], p.F[rows]])
    if step == 0:
        first = state
    sim.advance()
for states in (first, state):
    parts = world().gather(states)
    if parts:
        print(np.concatenate(parts).tobytes().hex())
"""


def test_a_scattered_sample_is_the_same_on_any_number_of_ranks(tmp_path, mpirun):
    """None lost or made twice where they cross a boundary, and the 20 steps work."""
    write_case(tmp_path / "flying.yaml", flying())
    said = []
    for ranks in (1, 3):
        job = mpirun(ranks, ["-c", SCATTER, tmp_path / "flying.yaml"], 120)
        assert job.returncode == 0, job.stderr
        said.append(job.stdout.split())
    assert said[0] == said[1]
    begin, later = (np.frombuffer(bytes.fromhex(text)).reshape(72, -1) for text in said[0])
    assert sorted(begin[:, 0]) == list(range(72))
    plain = Simulation(Case.model_validate(flying()), Serial())
    layers = plain.particles.layer[plain.live()]
    assert (np.sort(begin[:, 1]) != np.sort(layers)).any()  # some lie in other layers
    # Half of them fly a hundredth of a cell a step already, so that no drift is added.
    assert begin[:, 4].mean() == pytest.approx(0.5)
    assert (later[:, 2] != begin[:, 2]).any()


def test_a_sample_at_rest_drifts_and_loses_nobody_to_an_error():
    """A body beside an open face: coarse samples of it reach beyond, and that ends nothing."""
    body = box([6.0, 1.0], [11.9, 4.0])
    case = Case.model_validate(scene(2, {"a": body}, cells=[12, 6], end=2.0, step=0.01))
    for size in (20, 72):
        (sample,) = samples_of(case, 72, [size])
        sim = sample.sim
        way = sim.dt * sim.particles.v[sim.live(), 0].mean() / sim.scene.domain.frame.cell[0]
        assert way == pytest.approx(0.005, rel=0.1)
        for _ in range(300):
            sim.advance()


def test_a_sample_that_empties_begins_anew():
    """A body as fast as sound, at the open end of its grid: no block has lost many particles."""
    body = box([5.0, 1.0], [9.0, 4.0], [10.0, 0.0])
    case = Case.model_validate(scene(2, {"a": body}, cells=[12, 6], end=0.2, step=0.01))
    (sample,) = samples_of(case, 48, [48])
    counts = []
    for _ in range(40):
        sample.run()
        counts.append(sample.sim.present())
    assert min(counts) >= 47  # 98 of 100
    assert sample._steps < 60 and len(sample._blocks) >= 20
    without = Simulation(resized(case, 1.0), Serial())
    for _ in range(60):
        without.advance()
    assert without.present() < 47  # as it would be


def test_samples_of_a_case_whose_walls_let_the_material_out_are_timed():
    """A box full of water that falls out at a face which holds it along the face only."""
    water = {"model": "newtonian", "bulk": 1e3, "shear_viscosity": 0.1, "density": 1.0}
    free = {"velocity": [None, 0.0]}
    case = Case.model_validate(
        scene(2, {"a": box([0.0, 0.0], [12.0, 6.0])}, cells=[12, 6], end=0.2, step=0.001)
        | {"materials": {"soft": water}, "gravity": [0.1, 0.0]}
        | {"boundaries": {"x-min": free, "x-max": free, "y-min": "fixed", "y-max": "fixed"}}
    )
    samples = samples_of(case, 288, [200, 1000])
    run_in_turn(samples, 0.05)
    assert all(sample.timed for sample in samples)
    assert [*samples[0].sim.case.bodies] == ["a"] and costs_of(samples).fixed > 0.0
    samples[0]._blocks, samples[0].failure = [], "nothing goes"
    with pytest.raises(RunError, match="no step of a sample could be timed: nothing goes"):
        costs_of(samples)


def test_particles_of_lattice_cells_stay_there():
    """The step of a case whose bodies go cell by cell is timed as that, several times faster."""
    block = box([1.0, 1.0], [5.0, 3.0]) | {"formulation": "total-lagrangian"}
    case = Case.model_validate(scene(2, block, step=0.001))
    (sample,) = samples_of(case, 32, [100])
    assert sample.sim.rank.by_cells_alone() and sample.sim.rank.count > 64
