"""cases/fluid/dam-break.yaml, coarsened: walls hold a fluid in, with every shape, to the end."""

from pathlib import Path

import numpy as np
import pytest
from tiers import wide

import pgimp
from pgimp.cli import main
from pgimp.physics.materials import registry

pytestmark = pytest.mark.slow(30)

CASES = Path(__file__).resolve().parents[2] / "cases"
CASE, FLUID = CASES / "fluid/dam-break.yaml", CASES / "fluid.py"
COARSER = {"grid.cell": [0.1, 0.1], "time.end": 2.0, "time.step": 0.002}


def coarse(shape, **changes):
    registry.import_file(str(FLUID))
    return pgimp.load(CASE, COARSER | {"method.shape": shape} | changes)


def lines(sim, every=5):
    """Lines of the history, every few steps, and the number of those in which a wall held."""
    found = [sim.diagnostics()]
    while not sim.finished:
        sim.step(1)
        if sim.steps % every == 0 or sim.finished:
            found.append(sim.diagnostics())
    return found


@pytest.mark.parametrize(
    "shape",
    ["gimp", "mpm", *(wide(one)
                      for one in ("finite-gimp", "fuzzy-nearest", "fuzzy-constant"))],
)  # fmt: skip
def test_a_fluid_stays_in_its_box(shape):
    """All particles to the end; what walls do to those that pass them is in the books."""
    sim = pgimp.Simulation(coarse(shape))
    found = lines(sim)
    # Points and tents keep off by themselves here: their weights on inner vertices vanish faster.
    assert sim.core.rank.held > 0 or "gimp" not in shape
    assert len(sim.particles["id"]) == sim.core.count
    x = sim.particles["position"]
    assert ((x >= 0.0) & (x[:, :2] <= [2.0, 1.0]).all(axis=1, keepdims=True)).all()
    for axis, gravity in (("x", 0.0), ("y", -9.81)):
        walls = sum(
            np.diff([line["time"] for line in found])
            * [line[name] for line in found[1:]]
            for name in found[0]
            if name.startswith("reaction.") and name.endswith(f"-{axis}")
        ).sum()  # fmt: skip
        weight = found[0]["mass"] * gravity * found[-1]["time"]
        # As in tests/proofs/test_books.py, of the weight's impulse, 6,000 kg m/s.
        assert found[-1][f"momentum-{axis}"] == pytest.approx(walls + weight, abs=1e-8 * 6000.0)
    assert found[-1]["dissipated-energy"] > 0.0


def test_same_bits_on_ranks_and_resumed_while_walls_hold_particles(tmp_path, mpirun):
    """On 1 and 3 ranks, the latter stopped half-way and resumed on 2; the log counts them all."""
    one, three = tmp_path / "one", tmp_path / "three"
    pgimp.run(coarse("gimp"), output=one, quiet=True)
    words = ["-m", "pgimp", str(CASE), "--import", str(FLUID), "-o", str(three)]
    for name, value in (COARSER | {"method.shape": "gimp"}).items():
        words += ["--set", f"{name}={value}"]
    assert mpirun(3, [*words, "--set", "time.end=1.0"]).returncode == 0
    assert mpirun(2, [*words, "--resume"]).returncode == 0
    assert main(["compare", str(one), str(three)]) == 0
    notes = [
        [line for line in (run / "log.txt").read_text().splitlines() if "a wall held in" in line]
        for run in (one, three)
    ]
    assert len(notes[0]) == 1 and notes[0] == notes[1][-1:]


@pytest.mark.parametrize(
    ("speed", "advice"), [(0.3, "constraints on a part of the body"), (None, "lets it move out")]
)
def test_a_face_that_draws_material_out_holds_nothing_in(speed, advice):
    """Prescribed to leave, or free along its normal: then the run ends, with what to do."""
    face = {"velocity": [speed, 0.0]}
    case = {
        "format": 1,
        "dimensions": 2,
        "grid": {"size": [4.0, 2.0], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 10.0, "step": 0.05},
        "materials": {
            "soft": {"model": "neo-hookean", "young": 10.0, "poisson": 0.0, "density": 1.0}
        },
        "bodies": {
            "body": {
                "material": "soft",
                "region": {"box": {"min": [2.0, 0.0], "max": [4.0, 2.0]}},
                "velocity": [0.3, 0.0],
            }
        },
        "boundaries": {"x-max": face},
    }
    sim = pgimp.Simulation(case)
    with pytest.raises(pgimp.RunError, match="left the domain through x-max") as caught:
        sim.advance()
    assert advice in str(caught.value)
