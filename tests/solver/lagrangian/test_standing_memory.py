"""Elastic particles of a lattice have no state: what they need in memory, and that bits stay."""

import json
import shutil

import numpy as np
import pytest
from processes import clean_env
from rank_scenes import SCENES
from run_files import digests
from scenes import box, finish, scene, start, write_case

import pgimp
from pgimp.decomposition.population import Population
from pgimp.solver.callbacks.particles import Particles
from pgimp.solver.lagrangian import pieces
from pgimp.solver.state.state import Ordered

pytestmark = pytest.mark.slow(60)

CASE = SCENES["initial_lattice"]
DISPLACED = ("x", "v", "F", "sigma", "V")

#: ``python -c PROGRAM CASE FOLDER``: anonymous bytes after some steps (`standing`), then the most
#: in a step, a line of the history, a frame and a checkpoint.
PROGRAM = """
import json
import sys
from pathlib import Path

from pgimp.case.load import load
from pgimp.mpi.comm import Serial
from pgimp.running.checkpoints import Checkpoints
from pgimp.running.frames import Frames
from pgimp.solver.simulation import Simulation


def memory(name):
    status = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return int(status[name].split()[0]) * 1024


def most(do):
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    do()
    return memory("VmHWM") - memory("RssFile")


case, folder = load(sys.argv[1]), Path(sys.argv[2])
sim = Simulation(case, Serial())
for _ in range(20):
    sim.advance()
for name in ("frames", "checkpoints"):
    (folder / name).mkdir(exist_ok=True)
frames, checkpoints = Frames(folder, case, sim), Checkpoints(folder, case, sim)
grid = sim.rank.grid
found = {
    "particles": sim.rank.count,
    "grid": grid.G.nbytes + grid.motion.values.nbytes,
    "standing": memory("RssAnon"),
    "steps": most(sim.advance),
    "lines": most(sim.diagnostics),
    "frames": most(lambda: frames.write(sim)),
    "checkpoints": most(lambda: checkpoints.write(sim, 1, 0)),
}
frames.finish()
(folder / "found.json").write_text(json.dumps(found))
"""


def block(cells, **parts):
    """A cube of so many cells along each direction, elastic, in the initial configuration."""
    body = box([1.0] * 3, [cells + 1.0] * 3, [0.1, 0.0, 0.0]) | {"formulation": "total-lagrangian"}
    return scene(3, body, cells=[cells + 2] * 3, step=1e-4, gravity=[0.0, 0.0, -1.0],
                 boundaries={"z-min": "fixed"}, **parts)  # fmt: skip


def test_a_particle_takes_a_hundred_bytes(tmp_path, python):
    """From one size of a cube to the next, without the grid's vertices: also where something asks.

    A frame has the order of its rows besides. Arrays have pages of their own, as large ones have.
    """
    found = []
    for n in (24, 24, 50):  # the first one may compile
        folder = tmp_path / str(n)
        folder.mkdir(exist_ok=True)
        write_case(folder / "case.yaml", block(n))
        shutil.rmtree(folder / "frames", ignore_errors=True)
        run = python(
            ["-c", PROGRAM, folder / "case.yaml", folder],
            env=clean_env() | {"MALLOC_MMAP_THRESHOLD_": "131072"},
        )
        assert run.returncode == 0, run.stderr
        found.append(json.loads((folder / "found.json").read_text()))
    small, large = found[1:]
    more = {name: large[name] - small[name] for name in large}
    each = {name: (more[name] - more["grid"]) / more["particles"] for name in more}
    assert more["particles"] == 8 * (50**3 - 24**3)
    # V0, m, id, cell, layer, body, origin; order; volume, row, order and flag of cells.
    assert 80.0 < each["standing"] < 100.0, each
    for name in ("steps", "lines", "checkpoints"):
        assert each[name] < 115.0, each
    assert each["frames"] < 150.0, each


def test_whoever_holds_particles_sees_them_when_somebody_asks():
    """The arrays stay the same ones, and are zero meanwhile; scenes that ask in each step keep."""
    sim = start(block(9, end=9.0))
    p = sim.particles
    sim.advance()
    assert not sim.population.released
    sim.advance()
    assert sim.population.released
    assert not p.F[1000:2000].any()
    assert sim.particles.F is p.F and not sim.population.released
    assert (np.abs(p.F[:, 0] - 1.0) < 0.1).all()
    for _ in range(3):
        sim.advance()
        sim.particles.x.any()
        assert not sim.population.released


@pytest.mark.parametrize("most", [1 << 18, 7])
def test_pieces_have_the_same_bits(monkeypatch, most):
    """Lines, columns and fields, of layers of which several are a piece, or one is many."""
    monkeypatch.setattr(pieces, "_FEW", most)
    monkeypatch.setattr(pieces, "_MAX_PARTICLES", most)
    case = CASE | {"time": {"end": 0.3, "step": 0.01}}
    ours = finish(start(case))
    with monkeypatch.context() as patch:
        patch.setattr(Population, "outdate", lambda self, _: setattr(self, "outdated", True))
        theirs = finish(start(case))
    assert ours.population.released and not theirs.population.released
    assert ours.diagnostics() == theirs.diagnostics()
    assert ours.population.released
    mine, rows = Ordered(ours.rank), theirs.live()
    for name in DISPLACED:
        assert mine[name].tobytes() == getattr(theirs.particles, name)[rows].tobytes(), name
    chosen = np.random.default_rng(1).permutation(rows)[:50]
    one, other = (pieces.source_at(sim.rank, chosen) for sim in (ours, theirs))
    for name in Particles(theirs):
        values = ours.scene.fields[name].values
        assert values(one).tobytes() == values(other).tobytes(), name
    assert ours.population.released


def test_runs_leave_the_same_bytes(tmp_path, monkeypatch):
    """Compressed frames, history, probes: as with columns that stand all the time."""
    pgimp.run(CASE, output=tmp_path / "pieces", quiet=True)
    monkeypatch.setattr(Population, "outdate", lambda self, _: setattr(self, "outdated", True))
    pgimp.run(CASE, output=tmp_path / "standing", quiet=True)
    assert digests(tmp_path / "pieces") == digests(tmp_path / "standing")


def test_particles_with_a_state_keep_their_columns():
    """A traction's particles are summed one by one: all columns stay, with what they remember."""
    load = {"push": {"body": "body", "face": "x-max", "pressure": 1.0}}
    sim = start(block(5, end=9.0, tractions=load))
    for _ in range(3):
        sim.advance()
    assert len(sim.rank.lattice_cells().off_lattice.rows) and not sim.population.released
    assert sim.population.columns.F[:, 0].all()
