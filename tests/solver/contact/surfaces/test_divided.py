"""Facets of bodies whose surfaces several ranks have measured: the same bits."""

import numpy as np
import pytest

from pgimp.geometry.regions import Ball, Box
from pgimp.scene.bodies.elements import Elements
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surface_patches import facets_of
from pgimp.solver.contact.surfaces.divided import planes_by_rank


@pytest.mark.parametrize("ranks", [2, 5])
@pytest.mark.parametrize("D", [1, 2, 3])
def test_facets_do_not_depend_on_who_measures(D, ranks):
    edges = [np.arange(25) * 0.5] * D
    ball = Ball(centre=[3.1, 4.2, 3.9][:D], radius=2.53)
    box = Box(min=[6.13, 2.21, 1.5][:D], max=[9.5, 5.91, 5.33][:D])
    bodies = [
        LatticeBody(region, edges, [e[:-1] + 0.25 for e in edges], True, True)
        for region in (ball, box)
    ]
    planes = planes_by_rank(bodies, ranks)
    assert sorted({rank for each in planes for rank in each}) == [*range(ranks)]
    for body, parts in zip(bodies, planes, strict=True):
        found = [find_elements(body, None, part, ()) for part in parts.values()]
        joined = Elements(*map(np.concatenate, zip(*found, strict=True)))
        own, whole = (
            facets_of(body, np.zeros(D), np.ones(D), elements=some) for some in (joined, None)
        )
        for one, other in zip(own, whole, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.filterwarnings("error")
def test_a_scene_whose_bodies_are_all_gone_has_no_planes():
    assert planes_by_rank([], 3) == []
