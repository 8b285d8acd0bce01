"""What `auto` means for liquids, beside solids and with friction."""

import pytest
from scenes import box, scene

import pgimp
from pgimp.scene.liquids import reflecting, relaxation_rate
from pgimp.scene.scene import Scene

OIL = {"model": "newtonian", "bulk": 100.0, "shear-viscosity": 0.5, "density": 2.0}
GAS = {"model": "ideal-gas", "gamma": 1.4, "energy": 1.0, "density": 1.0}
MUD = {"model": "bingham", "bulk": 100.0, "shear": 50.0, "yield-stress": 0.1} | {
    "shear-viscosity": 0.1, "density": 1.0,
}  # fmt: skip


def made(*materials, friction=0.0, **method):
    """A case with a body of each material, on cells of 0.5."""
    names = [f"m{n}" for n in range(len(materials))]
    bodies = {
        name: box([2.0 * n, 0.0], [2.0 * n + 2.0, 2.0], material=name)
        for n, name in enumerate(names)
    }
    floor = {"unilateral": {"friction": friction}} if friction else "slip"
    case = scene(2, bodies, cells=[12, 12], cell=0.5, boundaries={"y-min": floor})
    case["materials"] = dict(zip(names, materials, strict=True))
    case["method"] |= method
    return pgimp.load(case)


SOFT = {"model": "hooke", "young": 10.0, "poisson": 0.3, "density": 1.0}


def test_all_liquid():
    """The least viscous one tells; what a number says stays."""
    assert relaxation_rate(made(OIL)) == pytest.approx(0.01 * 0.25 / 0.25)
    assert relaxation_rate(made(OIL, MUD)) == pytest.approx(0.01 * 0.1 / 0.25)
    assert relaxation_rate(made(OIL, relaxation=3.0)) == 3.0
    thin = OIL | {"shear-viscosity": 1e-3}  # its rate would be 1.4e-6 c/h
    assert relaxation_rate(made(OIL, thin)) == 0.0
    assert reflecting(made(OIL, MUD)) and reflecting(made(OIL, wall="auto"))
    assert not reflecting(made(OIL, wall="ghost")) and reflecting(made(SOFT, wall="mirror"))
    assert not reflecting(made(OIL, shape="mpm")) and not reflecting(made(OIL, shape="cpdi"))


def test_walls_of_gases():
    """They reflect, also of `cpdi`; beside a solid, or if the case says so, they do not."""
    assert reflecting(made(GAS)) and reflecting(made(GAS, OIL))
    assert reflecting(made(GAS, shape="cpdi")) and not reflecting(made(GAS, OIL, shape="cpdi"))
    assert not reflecting(made(GAS, SOFT)) and not reflecting(made(GAS, wall="ghost"))


def test_beside_a_solid():
    """What a solid's walls do stays, whatever liquids are there; nor is sand a liquid."""
    case = made(OIL, SOFT)
    assert relaxation_rate(case) == 0.0 and not reflecting(case)
    assert not reflecting(made(SOFT)) and reflecting(made(SOFT, shape="fuzzy-nearest"))


FACES = {
    "x-min": "periodic", "x-max": "periodic", "y-min": "fixed", "y-max": "unilateral",
    "z-min": "absorbing", "z-max": {"velocity": [0.0, 0.0, 0.0]},
}  # fmt: skip


@pytest.mark.parametrize(
    ("wall", "which"), [("auto", ["y-min"]), ("mirror", ["y-min", "y-max"]), ("ghost", [])]
)
def test_which_faces_reflect(wall, which):
    """Those that hold a liquid and stand still; that lets go only where the case says so."""
    water = {"model": "newtonian", "bulk": 100.0, "density": 1.0}
    case = scene(3, box([0.0] * 3, [4.0, 4.0, 2.0], material="water"), cells=[4] * 3)
    case |= {"materials": {"water": water}, "boundaries": FACES}
    case["method"]["wall"] = wall
    domain = Scene(pgimp.load(case)).domain
    assert [domain.faces[one.number].name for one in domain.mirrors] == which


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_faces_with_friction_do_not_reflect(friction):
    for method in ({}, {"shape": "bspline-quadratic"}):
        case = made(OIL, friction=friction, **method)
        assert len(Scene(case).domain.mirrors) == (friction == 0.0)
