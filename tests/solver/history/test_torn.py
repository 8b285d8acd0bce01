"""A run says, once, that particles of a solid are too far apart along their stretch."""

import json

import numpy as np
import pytest
from mentioned import mentions
from scenes import start
from two_blocks import CASE, flying

import pgimp
from pgimp.case.load import load
from pgimp.scene.scene import Scene
from pgimp.solver.history.tearing import TearingWatch, greatest_stretches


@pytest.mark.parametrize(("dimension", "width"), [(1, 1), (2, 4), (2, 5), (3, 9)])
def test_the_greatest_stretch_is_the_greatest_singular_value(dimension, width):
    F = np.random.default_rng(3).normal(size=(200, width))
    exact = np.linalg.norm(
        F[:, : dimension**2].reshape(-1, dimension, dimension), ord=2, axis=(1, 2)
    )
    found = greatest_stretches(F, dimension, 1.0)
    far = found > 1.0
    np.testing.assert_allclose(found[far], exact[far], rtol=1e-12)
    assert (exact[~far] <= 1.0).all() and far.any()


def stretch(sim, name, by, part=1.0):
    """Stretch a part of a body's particles along y, as they would be by the grid."""
    p = sim.rank.population.columns
    rows = np.flatnonzero(p.body == sim.scene.body_names.index(name))
    p.F[rows[: round(part * len(rows))]] = (1.0, 0.0, 0.0, by)


def said(sim, steps=0, **stretched):
    """What is said after some steps, with the bodies stretched at last."""
    for _ in range(steps):
        sim.advance()
    for name, by in stretched.items():
        stretch(sim, name, *np.atleast_1d(by))
    sim.diagnostics()
    texts, sim.diagnostic_sums.said[:] = list(sim.diagnostic_sums.said), []
    return texts


def test_a_stretched_body_is_named_once():
    sim = start(flying())
    assert said(sim, b=1.4) == []
    assert said(sim, 10, b=1.7) == []  # too soon for another look
    (text,) = said(sim, 40, b=1.7)
    mentions(
        text, "'b'", "0.85 cells apart", "1.7", "gimp and 2 particles", "cpdi", "total-lagrangian"
    )
    assert said(sim, 50, b=1.8, a=(1.7, 0.001)) == []


def test_nothing_is_looked_at_in_the_initial_configuration_or_of_cpdi_before_it_tears():
    for changes in ({"shape": "cpdi"}, {"per_cell": 4}):
        sim = start(flying(**changes))
        assert said(sim, a=1.75) == []


def test_metal_is_told_at_a_cell_if_a_grip_may_pull_it():
    metal = {"model": "von-mises", "young": 100.0, "poisson": 0.3, "density": 1.0}
    materials = {"soft": metal | {"yield-stress": 1.0}}
    region = {"box": {"min": [3.0, 1.0], "max": [4.0, 4.0]}}
    grip = {"body": "a", "region": region, "velocity": [1.0, None]}
    watched = [
        TearingWatch().limits(Scene(load(flying() | parts)))
        for parts in (
            {"materials": materials},
            {"materials": materials, "constraints": {"g": grip}},
        )
    ]
    assert watched == [{}, {0: 2.0}]


def test_the_warning_is_in_the_log_and_in_run_json(tmp_path):
    """A block whose right half flies off at once."""
    text = CASE.replace("right: {material: soft, region: {box: {min: [6.0, 1.0]",
                        "right: {material: soft, region: {box: {min: [4.0, 1.0]")  # fmt: skip
    text = text.replace("velocity: [1.0, 0.0]", "velocity: [-9.0, 0.0]")
    text = text.replace("velocity: [-1.0, 0.0]", "velocity: [9.0, 0.0]")
    text = text.replace("end: 2.0", "end: 0.6").replace("every: {steps: 30}", "every: {steps: 5}")
    text = text.replace("at: [0.5, 1.0]", "at: [0.5]")
    (tmp_path / "case.yaml").write_text(text)
    run = pgimp.run(tmp_path / "case.yaml", output=tmp_path / "out", quiet=True)
    (start_,) = json.loads((run.path / "run.json").read_text())["starts"]
    found = [line for line in start_["warnings"] if "cells apart along their stretch" in line]
    assert found and all(f"warning: {line}" in (run.path / "log.txt").read_text() for line in found)
