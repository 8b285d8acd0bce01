"""Derived fields in frames, probes, tables and plots of a run; their values: test_output.py."""

import numpy as np
import pytest
from two_blocks import flying

import pgimp
from pgimp.errors import UsageError
from pgimp.physics.derived import DERIVED, OF_STRESS
from pgimp.physics.fields import components_of
from pgimp.utilities.plot.quantity import quantity

PROBES = {
    "point": {"body": "a", "at": [4.0, 2.0], "fields": [*DERIVED]},
    "place": {"place": [3.0, 2.0], "fields": [*OF_STRESS]},
}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    output = {"every": {"steps": 50}, "fields": ["stress", "velocity", *DERIVED]}
    case = flying(output=output, probes=PROBES, history={"every": {"steps": 50}})
    return pgimp.run(case, output=tmp_path_factory.mktemp("derived") / "out", quiet=True)


def test_energies_of_particles_add_up_to_those_of_the_history(run):
    for frame, line in zip(run.frames, run.history, strict=True):
        initial = frame["volume"] / frame["volume-ratio"]
        strain, kinetic = frame["strain-energy-density"], frame["kinetic-energy-density"]
        assert strain @ initial == pytest.approx(line["strain-energy"], rel=1e-12)
        assert kinetic @ frame["volume"] == pytest.approx(line["kinetic-energy"], rel=1e-12)
    assert run.history["strain-energy"][-1] > 0.1


def test_a_point_has_the_fields_of_its_particle(run):
    probe, first = run.probes["point"], run.frame(0)
    away = ((first["position"][:, :2] - [4.0, 2.0]) ** 2).sum(axis=1)
    row = int(np.flatnonzero((away == away.min()) & (first["body"] == 0))[0])
    for frame, line in zip(run.frames, probe, strict=True):
        for name in DERIVED:
            values = np.atleast_1d(frame[name][row])
            parts = components_of(name, len(values)) or [""]
            parts = parts[:4] if name == "log-strain" else parts
            found = [line[f"{name}-{part}" if part else name] for part in parts]
            assert np.array_equal(found, values[: len(found)])


def test_a_place_has_what_follows_from_its_stress(run):
    line = run.probes["place"][-1]
    stress = np.array([[line[f"stress-{part}"] for part in ("xx", "yy", "zz", "xy")]])
    for name, function in OF_STRESS.items():
        values = np.atleast_1d(function(stress)[0])
        parts = components_of(name, len(values)) or [""]
        found = [line[f"{name}-{part}" if part else name] for part in parts]
        np.testing.assert_allclose(found, values, rtol=1e-12)


def test_plots_take_them_from_the_stress_too(run):
    """`max-shear` without the field, and one principal stress of three."""
    frame = run.frame(-1)
    shear = quantity("max-shear", frame, 2).rows(frame, 0, len(frame))
    np.testing.assert_array_equal(shear, frame["max-shear"])

    class Bare:
        """The frame with its stress only."""

        path, fields = frame.path, ["stress"]
        __contains__ = staticmethod(["stress"].__contains__)
        rows = staticmethod(frame.rows)

    least = quantity("principal-stress.3", Bare(), 2).rows(Bare(), 0, len(frame))
    np.testing.assert_array_equal(least, frame["principal-stress"][:, 2])
    with pytest.raises(UsageError, match="principal-stress has 3 components"):
        quantity("principal-stress", frame, 2)


def test_a_probe_keeps_its_columns(run):
    case = flying(probes={"place": {"place": [3.0, 2.0], "fields": ["max-shear"]}})
    case["time"]["end"] = 2.1
    with pytest.raises(UsageError, match=r"probes.place.fields: the run began with other"):
        pgimp.run(case, output=run.path, resume=True, quiet=True)


@pytest.mark.parametrize(
    ("probe", "text"),
    [
        ({"body": "a", "at": [2.0, 2.0], "fields": ["stress"]}, "unknown derived field 'stress'"),
        ({"place": [2.0, 2.0], "fields": ["volume-ratio"]}, "unknown derived field 'volume-ratio'"),
    ],
)
def test_fields_that_a_probe_cannot_have(probe, text):
    with pytest.raises(pgimp.CaseError, match=text):
        pgimp.load(flying(probes={"one": probe}))


def test_tables_have_units(run):
    """In the case's own, or in length, mass and time where it names none."""
    units = run.history.units
    assert set(units) == set(run.history.dtype.names)
    assert units["strain-energy"] == "energy" and units["body.a.centre-x"] == "length"
    assert units["step"] == "" and run.history[-1:].units == units
    assert run.probes["point"].units["principal-stress-1"] == "stress"
    run.case.__dict__["units"] = "m, kg, s"
    try:
        assert run.history.units["momentum-y"] == "kg m/s / m"
        assert run.probes["place"].units["max-shear"] == "Pa"
        assert run.probes["point"].units["velocity-x"] == "m/s"
        assert run.history.units["strain-energy"] == "J/m"
    finally:
        run.case.__dict__["units"] = "none"
