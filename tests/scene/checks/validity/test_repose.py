"""Loose soil is said to rest where its law shears, and what gives the angle that is wanted."""

from math import atan, cos, degrees, radians, sin, sqrt, tan

import numpy as np
import pytest
from checked import facts
from mentioned import mentions

from pgimp.case.reader import read_case
from pgimp.scene.checks.validity.repose import notes, rest_slope

HEAP = """
format: 1
dimensions: 2
grid: {{size: [12.0, 6.0], cell: [1.0, 1.0]}}
method: {{shape: gimp, particles-per-cell: [2, 2]}}
time: {{end: 1.0, step: {{courant: 0.3}}}}
materials: {{sand: {law}}}
bodies: {{heap: {{material: sand, region: {{box: {{min: [4.0, 0.0], max: [8.0, 3.0]}}}}}}}}
gravity: [0.0, {gravity}]
boundaries: {{y-min: {floor}}}
"""
ELASTIC = "young: 1.0e6, poisson: 0.25, density: 1500.0"


def case(law="mohr-coulomb", more="", phi=35.0, psi=0.0, c=0.0, floor="slip", gravity=-9.81):
    angles = f"cohesion: {c}, friction-angle: {phi}, dilation-angle: {psi}"
    law = f"{{model: {law}, {ELASTIC}, {angles}{more}}}"
    return read_case(HEAP.format(law=law, floor=floor, gravity=gravity), "heap.yaml")


def told(*args, **kwargs):
    found = case(*args, **kwargs)
    return list(notes(found, facts(found)))


def sheared(gradients, pressure=1.0):
    """Shear over normal stress at last, sheared under a normal stress with nothing stretched.

    Small strains, explicit steps; `gradients` gives yield function, its gradient and the flow of a
    stress (xx, yy, zz, xy), tension positive.
    """
    G, K = 100.0, 500.0 / 3.0
    elastic = np.diag([2.0 * G] * 3 + [G])
    elastic[:3, :3] += K - 2.0 / 3.0 * G
    sigma = -pressure * np.array([0.8, 1.0, 0.8, 0.0])
    for _ in range(20000):
        f, n, m = gradients(sigma)
        slip, rise = elastic @ [0.0, 0.0, 0.0, 1.0], elastic @ [0.0, 1.0, 0.0, 0.0]
        # A shear of 2e-6; the normal strain and the multiplier keep sigma_yy and the strength.
        if f < 0.0:
            sigma = sigma + 2e-6 * (slip - rise * slip[1] / rise[1])
            continue
        flow = elastic @ m
        left = np.array([[rise[1], -flow[1]], [n @ rise, -n @ flow]])
        part = np.linalg.solve(left, -2e-6 * np.array([slip[1], n @ slip + f / 1e-2]))
        sigma = sigma + 2e-6 * slip + part[0] * rise - part[1] * flow
    return sigma[3] / -sigma[1]


def pyramid(phi, psi):
    """Mohr and Coulomb in the plane, the stress across it between the others."""

    def gradients(sigma):
        half, across = 0.5 * (sigma[0] - sigma[1]), sigma[3]
        radius = sqrt(half**2 + across**2)
        turn = np.array([0.5 * half, -0.5 * half, 0.0, across]) / max(radius, 1e-12)
        even = np.array([0.5, 0.5, 0.0, 0.0])
        f = radius + 0.5 * (sigma[0] + sigma[1]) * sin(radians(phi))
        return f, turn + sin(radians(phi)) * even, turn + sin(radians(psi)) * even

    return gradients


def cone(alpha, flow):
    """Drucker and Prager."""

    def gradients(sigma):
        mean = sigma[:3].mean()
        s = sigma - mean * np.array([1.0, 1.0, 1.0, 0.0])
        tau = sqrt(0.5 * (s[:3] @ s[:3]) + s[3] ** 2)
        turn = np.array([*(0.5 * s[:3]), s[3]]) / max(tau, 1e-12)
        even = np.array([1.0, 1.0, 1.0, 0.0]) / 3.0
        return tau + alpha * mean, turn + alpha * even, turn + flow * even

    return gradients


@pytest.mark.parametrize(("phi", "psi"), [(35.0, 0.0), (30.0, 10.0), (25.0, 25.0)])
@pytest.mark.parametrize("law", ["mohr-coulomb", "plane-strain", "plane-strain-flow"])
def test_the_slope_is_that_of_shear_without_stretch(law, phi, psi):
    if law == "mohr-coulomb":
        soil, gradients = case(phi=phi, psi=psi), pyramid(phi, psi)
    else:
        soil = case("drucker-prager", f", match: {law}", phi, psi)
        parameters = soil.materials["sand"].parameters()
        gradients = cone(parameters.alpha, parameters.flow)
    assert rest_slope(soil.materials["sand"]) == pytest.approx(sheared(gradients), rel=6e-3)


def test_sand_with_its_angle_of_repose_rests_flatter():
    (line,) = told()
    mentions(line, "materials.sand", f"{degrees(atan(sin(radians(35.0)))):.3g} degrees", "44.4")
    assert "match" not in line
    (line,) = told("drucker-prager")
    mentions(line, "materials.sand", "match: plane-strain-flow", "friction-angle: 44.4")
    # What is proposed does rest there.
    law = case("drucker-prager", ", match: plane-strain-flow", phi=44.43).materials["sand"]
    assert rest_slope(law) == pytest.approx(tan(radians(35.0)), rel=1e-3)


def test_what_rests_where_it_should_is_only_told():
    (line,) = told(phi=35.0, psi=35.0)
    assert "rest at 35 degrees" in line and "dilation-angle" not in line
    assert cos(radians(50.0)) > 0.0 and "take" not in told(phi=50.0)[0]  # no sine is its tangent


def test_nothing_of_soil_that_stands_or_has_no_weight():
    assert told(c=1.0e3) == [] and told(gravity=0.0) == []


@pytest.mark.parametrize(("floor", "said"), [("fixed", 2), ("{unilateral: {friction: 0.6}}", 1)])
def test_a_fixed_floor(floor, said):
    lines = told(floor=floor)
    assert len(lines) == said
    if said == 2:
        mentions(lines[1], "boundaries.y-min", "unilateral", "friction", "'sand'")


def test_grains_creep():
    law = f"{{model: mu-i, {ELASTIC}, mu-s: 0.4, mu-2: 0.7, i0: 0.3, grain: 0.01"
    law += ", grain-density: 2500.0}"
    found = read_case(HEAP.format(law=law, floor="slip", gravity=-9.81), "heap.yaml")
    (line,) = notes(found, facts(found))
    mentions(line, "materials.sand", "21.8 degrees", "creep")
