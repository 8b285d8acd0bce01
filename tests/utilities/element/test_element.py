"""``pgimp element``: rubber along paths against the formulas of its stress; what it refuses."""

import argparse
import csv

import numpy as np
import pytest
from scenes import SOFT, box, scene, write_case

import pgimp
from pgimp.commands import element
from pgimp.errors import UsageError
from pgimp.physics.materials.base import lame
from pgimp.utilities.element.table import curve, draw

LAM, MU = lame(SOFT["young"], SOFT["poisson"])


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.yaml"
    write_case(path, scene(2, box([2.0, 2.0], [5.0, 5.0])))
    return path


def call(case, *options):
    parser = argparse.ArgumentParser()
    element.add_arguments(parser)
    return element.execute(parser.parse_args([str(case), "soft", *options]))


def table(case, tmp_path, *options):
    """Columns of the file that the command writes."""
    call(case, *options, "-o", str(tmp_path / "path.csv"))
    with (tmp_path / "path.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def test_strain_along_one_direction(case, tmp_path):
    found = table(case, tmp_path, "--path", "uniaxial-strain", "--to=-0.4,0.3", "--steps", "7")
    J = np.exp(found["value"])
    assert len(J) == 15 and J.min() == pytest.approx(np.exp(-0.4))
    along = MU / J * (J**2 - 1.0) + LAM * np.log(J) / J
    across = LAM * np.log(J) / J
    assert found["stress-xx"] == pytest.approx(along, rel=1e-12, abs=1e-12 * SOFT["young"])
    assert found["stress-zz"] == pytest.approx(across, rel=1e-12, abs=1e-12 * SOFT["young"])
    assert found["det-F"] == pytest.approx(J, rel=1e-12)


def test_stress_along_one_direction_leaves_none_across(case, tmp_path):
    """In small strain Young's modulus; what is second order in 1e-4 is left."""
    found = table(case, tmp_path, "--path", "uniaxial-stress", "--to", "1e-4", "--steps", "3")
    slope = found["stress-xx"][-1] / found["value"][-1]
    assert slope == pytest.approx(SOFT["young"], rel=1e-3)
    assert np.abs(found["stress-yy"]).max() < 1e-9 * found["stress-xx"].max()


def test_shear_in_python_is_the_same_as_in_the_command(case, tmp_path):
    found = table(case, tmp_path, "--path", "simple-shear", "--to", "1.5", "--steps", "5")
    assert found["stress-xy"] == pytest.approx(MU * found["value"], rel=1e-12)
    F = np.tile(np.eye(3), (5, 1, 1))
    F[:, 0, 1] = 0.3 * np.arange(1, 6)
    result = pgimp.element(pgimp.load(str(case)).materials["soft"], F, 0.1)
    assert result["stress"].shape == (5, 6)
    assert result["stress"][:, 3] == pytest.approx(found["stress-xy"][1:], rel=1e-12)


def test_a_picture_is_drawn(case, tmp_path):
    picture = tmp_path / "path.png"
    assert call(case, "--path", "isotropic", "--to=-0.1", "-o", str(picture)) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("entry", "shown"),
    [
        ({"model": "mohr-coulomb", "cohesion": 1.0, "friction-angle": 0.0},
         ["q", "plastic-shear", "plastic-work"]),
        ({"model": "johnson-cook", "a": 1.0, "specific-heat": 1.0, "temperature": 0.0,
          "melting": 9.0, "damage": {"d1": 5.0}},
         ["q", "plastic-strain", "temperature", "plastic-work", "damage"]),
    ],
)  # fmt: skip
def test_the_picture_has_every_scalar_that_changes(case, entry, shown):
    soft = {"young": 100.0, "poisson": 0.3, "density": 1.0} | entry
    material = pgimp.load(str(case), {"materials.soft": soft}).materials["soft"]
    figure = draw(curve(material, "undrained", [-0.1], 20), "undrained", "soft")
    assert [axes.get_ylabel().replace(" ", "-") for axes in figure.axes] == shown


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--path", "sideways", "--to", "1"], ["sideways", "simple-shear"]),
        (["--path", "isotropic", "--to", "a"], ["--to a", "numbers"]),
        (["--path", "isotropic", "--to", "nan"], ["--to nan"]),
        (["--path", "isotropic", "--to", "1", "--steps", "0"], ["--steps 0"]),
        (["--path", "triaxial", "--to", "1", "--confine", "-1"], ["--confine -1"]),
        (["--path", "isotropic", "--to", "1", "-o", "path.txt"], ["path.txt", ".csv"]),
    ],
)
def test_what_is_wrong_is_said(case, options, words):
    with pytest.raises(UsageError) as caught:
        call(case, *options)
    assert all(word in str(caught.value) for word in words)


def test_an_unknown_material_is_named(case):
    parser = argparse.ArgumentParser()
    element.add_arguments(parser)
    words = [str(case), "sofd", "--path", "isotropic", "--to", "1"]
    with pytest.raises(UsageError, match="soft"):
        element.execute(parser.parse_args(words))
