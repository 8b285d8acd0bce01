"""What `auto` means for liquids, beside solids and with friction."""

import pytest
from scenes import box, scene

import pgimp
from pgimp.scene.liquids import reflects, relaxation_rate
from pgimp.scene.scene import Scene

OIL = {"model": "newtonian", "bulk": 100.0, "shear-viscosity": 0.5, "density": 2.0}
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
    floor = {"separating": {"friction": friction}}
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
    assert reflects(made(OIL, MUD, wall="auto"))
    assert not reflects(made(OIL)) and reflects(made(SOFT, wall="mirror"))
    assert not reflects(made(OIL, shape="mpm"))


def test_beside_a_solid():
    case = made(OIL, SOFT, wall="auto")
    assert relaxation_rate(case) == 0.0 and not reflects(case)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_faces_with_friction_do_not_reflect(friction):
    for method in ({"wall": "auto"}, {"shape": "bspline-quadratic"}):
        case = made(OIL, friction=friction, **method)
        assert len(Scene(case).domain.mirrors) == (friction == 0.0)
