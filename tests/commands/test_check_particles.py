"""``pgimp check`` refuses what a run refuses once its particles are there, in the same words."""

import numpy as np
import pytest
from checked import plate
from mentioned import mentions
from point_files import write_csv

from pgimp.case.locations import located
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.solver import setup
from pgimp.solver.simulation import Simulation
from pgimp.utilities.check import particles
from pgimp.utilities.check.prepare import prepare

FILL = (
    "tractions: {fill: {body: beam, pressure: 1.0, region: {box: {min: [1.0, %s], max: [2, %s]}}}}"
)
INSIDE, ON_TOP = FILL % (1.2, 1.8), FILL % (1.8, 2.2)


def refusals(case):
    """What check says, and the run."""
    texts = []
    for build in (prepare, lambda case: Simulation(case, Serial())):
        with pytest.raises(CaseError) as caught, located(case):
            build(case)
        texts.append(str(caught.value))
    return texts


def test_a_traction_that_touches_no_surface():
    said = refusals(plate(INSIDE))
    assert said[0] == said[1]
    mentions(said[0], "tractions.fill.region", "touches no surface of 'beam'")
    assert prepare(plate(ON_TOP)).notes == []


def test_a_stress_that_the_law_does_not_have():
    """Rubber as soft as that has no deformation which bears it."""
    case = plate("gravity: [0.0, -1.0e+5]", "start: {stress: {k0: 50.0}}")
    soft = case.model_dump(by_alias=True)
    soft["materials"]["m"] = {"model": "neo-hookean", "young": 1e4, "poisson": 0.45, "density": 1e3}
    said = refusals(type(case).model_validate(soft))
    assert said[0] == said[1]
    mentions(said[0], "start.stress", "no deformation")


def test_particles_of_a_file_that_weigh_too_much(tmp_path):
    file = tmp_path / "points.csv"
    at = np.array([[1.0 + 0.25 * i, 1.5] for i in range(8)])
    write_csv(file, {"position": at, "volume": np.full(8, 1.0e4)})
    case = plate().model_dump(by_alias=True)
    case["bodies"]["beam"]["region"] = {"points": {"file": str(file)}}
    said = refusals(type(plate()).model_validate(case))
    assert said[0] == said[1]
    mentions(said[0], "bodies", "particles weigh")


def test_too_many_particles_are_not_made_and_it_says_so(monkeypatch):
    monkeypatch.setattr(particles, "MAX_PARTICLES", 100)
    monkeypatch.setattr(particles, "populate", lambda *_: pytest.fail("they were made"))
    (note,) = prepare(plate(INSIDE)).notes
    mentions(note, "tractions.fill.region", "not looked at", "100 particles")
    assert prepare(plate()).notes == []


def test_a_deformation_is_not_searched_for_many_particles(monkeypatch):
    monkeypatch.setattr(particles, "MOST_STRESSED", 100)
    case = plate("gravity: [0.0, -1.0]", "start: {stress: {k0: 0.5}}", ON_TOP)
    assert prepare(case).notes == []  # the law has the stress itself
    data = case.model_dump(by_alias=True)
    data["materials"]["m"]["model"] = "neo-hookean"
    (note,) = prepare(type(case).model_validate(data)).notes
    mentions(note, "start.stress", "not looked at", "100 particles")


def test_the_run_asks_the_same_functions():
    assert setup.require_particles is particles.require_particles
    assert setup.require_light is particles.require_light
