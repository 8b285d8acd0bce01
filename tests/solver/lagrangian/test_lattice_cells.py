"""Particles of a lattice cell by cell: as one by one, to rounding, and what asks for them."""

from copy import deepcopy

import numpy as np
import pytest
from scenes import SOFT, box, finish, scene, start

from pgimp.errors import RunError
from pgimp.kernels.data.motion import KEPT_MASS
from pgimp.scene.scene import Scene

pytestmark = pytest.mark.slow(60)

COLUMNS = ("x", "v", "F", "V", "sigma")


def initial(body):
    return body | {"formulation": "total-lagrangian"}


def disks(**parts):
    """Two balls cut by their surfaces, of two materials, that spin into each other."""
    spin = {"rotation": {"about": [3.1, 3.0], "rate": 0.3}, "translation": [0.4, 0.0]}
    bodies = {
        "a": initial({"material": "soft", "region": {"ball": {"centre": [3.1, 3.0], "radius": 2.0}},
                      "velocity": spin}),
        "b": initial({"material": "hard", "region": {"ball": {"centre": [7.3, 3.2], "radius": 1.9}},
                      "velocity": [-0.4, 0.1]}),
    }  # fmt: skip
    two = {"soft": SOFT, "hard": SOFT | {"young": 300.0, "density": 2.0}}
    return scene(2, bodies, cells=[21, 12], cell=0.5, end=1.5, step=0.005,
                 materials=two, **parts)  # fmt: skip


def space(per_cell, **parts):
    """A block between a slip wall and a fixed one, with a free corner, under gravity."""
    body = initial(box([0.0, 0.7, 0.0], [3.0, 3.1, 2.4], [0.1, 0.0, -0.2]))
    return scene(3, body, cells=[4, 4, 4], per_cell=per_cell, step=0.01, end=0.3,
                 boundaries={"x-min": "fixed", "z-min": "slip"}, gravity=[0.1, 0.2, -0.3],
                 **parts)  # fmt: skip


CASES = {
    "contact": disks(contact=[{"bodies": "all", "friction": 0.3}]),
    "bonded": disks(shape="mpm", per_cell=3),
    "space": space(2),
    "planes of six": space([1, 2, 3], shape="cpdi"),
    "held": scene(
        2,
        initial(box([1.0, 1.0], [5.0, 3.0])),
        per_cell=4,
        cell=0.9,
        cells=[8, 6],
        end=0.5,
        step=0.01,
        tractions={"push": {"body": "body", "face": "y-max", "pressure": 5.0}},
        constraints={
            side: {
                "body": "body",
                "velocity": [v, 0.0],
                "region": {"box": {"min": [a, 0.0], "max": [a + 1.0, 5.0]}},
            }
            for side, a, v in (("low", 0.9, -0.3), ("high", 4.1, 0.3))
        },
    ),
}

METAL = {"model": "von-mises", "young": 300.0, "poisson": 0.3, "yield-stress": 3.0,
         "hardening": 20.0, "density": 2.0}  # fmt: skip
VISCOUS = SOFT | {"viscosity": {"linear": 0.2, "quadratic": 1.0}}


def remade(case, **materials):
    """The case with other materials by name, and `volumetric: b-bar` if that is asked for."""
    case = deepcopy(case)
    if materials.pop("mean", False):
        case["method"]["volumetric"] = "b-bar"
    case["materials"] |= materials
    return case


def whole(case):
    """The case with bodies of whole particles, which fill parts of cells."""
    case = deepcopy(case)
    for body in case["bodies"].values():
        body["surface"] = "whole-particles"
    return case


CASES |= {
    "metal": remade(CASES["contact"], soft=VISCOUS, hard=METAL, mean=True),
    "metal in space": remade(CASES["planes of six"], soft=METAL | {"yield-stress": 0.3}, mean=True),
}
CASES |= {"whole": whole(disks()), "whole in space": whole(CASES["space"])}
#: Those with kernels of three dimensions.
IN_SPACE = ("space", "planes of six", "metal in space", "whole in space")
#: Those with loads on particles, or means over cut cells, which are summed one by one.
SINGLE = ("held", "metal", "metal in space")


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.wide] * (n in IN_SPACE)) for n in CASES]
)
def test_cells_have_what_particles_have_one_by_one(name, monkeypatch):
    """Sums in another order, and F from displacements in place of its increments: to rounding."""
    cells = finish(start(CASES[name]))
    others = len(cells.rank.lattice_cells().off_lattice.rows)
    assert cells.scene.by_cells and (others > 0) == (name in SINGLE)
    monkeypatch.setattr(Scene, "_by_cells", lambda scene: False)
    single = finish(start(CASES[name]))
    assert cells.step == single.step > 20
    rows, all_rows = cells.live(), single.live()
    for column in COLUMNS:
        mine, theirs = (getattr(sim.particles, column)[at] for sim, at in
                        ((cells, rows), (single, all_rows)))  # fmt: skip
        # Thousands of roundings, of stresses of the size of the modulus.
        size = 300.0 if column == "sigma" else 1.0
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * size, err_msg=column)
    one, other = cells.diagnostics(), single.diagnostics()
    for key in ("kinetic-energy", "strain-energy", "external-work", "momentum-x"):
        assert one[key] == pytest.approx(other[key], rel=1e-8, abs=1e-10), key


@pytest.mark.wide
@pytest.mark.parametrize("per_cell", [[2, 2, 2], [2, 2, 3], [3, 3, 3], [4, 3, 2]])
def test_cut_balls_of_two_materials(per_cell, monkeypatch):
    """Cells with missing particles, of both materials; groups in pairs, and left over."""
    ball = {
        "region": {"ball": {"centre": [2.1, 2.2, 2.0], "radius": 1.3}},
        "material": "soft",
        "velocity": {"rotation": {"about": [2.0, 2.0, 2.0], "rate": [0.3, 0.1, 0.4]}},
    }
    case = scene(
        3, {"a": initial(ball), "b": initial(box([2.1, 2.2, 3.4], [3.3, 3.4, 4.2])
                                             | {"material": "hard", "velocity": [0.2, 0.0, 0.0]})},
        cells=[9, 9, 11], cell=0.5, per_cell=per_cell, end=0.3, step=0.005,
        materials={"soft": SOFT, "hard": SOFT | {"young": 300.0, "density": 2.0}},
    )  # fmt: skip
    cells = finish(start(case))
    assert cells.rank.by_cells_alone() and (cells.rank.lattice_cells().cells.volumes == 0.0).any()
    monkeypatch.setattr(Scene, "_by_cells", lambda scene: False)
    single = finish(start(case))
    assert cells.step == single.step > 20
    for column in COLUMNS:
        mine, theirs = (getattr(sim.particles, column)[sim.live()] for sim in (cells, single))
        size = 300.0 if column == "sigma" else 1.0
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * size, err_msg=column)


@pytest.mark.parametrize("name", ["contact", "metal"])
def test_asking_for_particles_changes_nothing(name):
    """Frames, history and probes update what they show; the next step has the same bits."""
    quiet, asked = start(CASES[name]), start(CASES[name])
    while not quiet.finished:
        quiet.advance()
        asked.advance()
        assert asked.particles.x.any()
        asked.diagnostics()
    rows = quiet.live()
    for column in COLUMNS:
        mine, theirs = (getattr(sim.particles, column)[rows] for sim in (quiet, asked))
        assert mine.tobytes() == theirs.tobytes(), column
    assert quiet.rank.grid.motion.values.tobytes() == asked.rank.grid.motion.values.tobytes()


def test_a_metal_beyond_its_shape_is_named():
    """F of the step tells what is wrong, not the displacements of the next one."""
    case = remade(scene(2, initial(box([1.0, 1.0], [4.0, 3.0])), step=0.02, end=9.0), soft=METAL)
    sim = start(case)
    values = sim.rank.grid.by_vertex(sim.rank.grid.motion.values)
    values[5, ..., 5] = -60.0
    with pytest.raises(RunError, match=r"particle \d+ of body 'body' is turned inside out"):
        finish(sim)


@pytest.mark.wide
def test_momenta_of_metals_last():
    """Sums by cells and F from the same vertices: to rounding, far from the start too."""
    case = remade(disks(), soft=VISCOUS, hard=METAL, mean=True)
    case["time"]["end"] = 10_000 * case["time"]["step"]
    sim = start(case)
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    assert sim.scene.by_cells and sim.scene.cell_loads
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        assert last[name] == pytest.approx(first[name], rel=1e-10, abs=1e-10), name


@pytest.mark.parametrize("cell", [0.1, 1.0 / 6.0, 0.3])
def test_rounding_divides_no_cell(cell):
    """Boxes end on the grid's lines, where rounding would put some into the next layer."""
    body = initial(box([2 * cell] * 2, [7 * cell] * 2))
    case = scene(2, body, cells=[9, 9], cell=cell, step={"courant": 0.3})
    case["grid"]["origin"] = [-0.7, 0.3]
    region = case["bodies"]["body"]["region"]["box"]
    for end in ("min", "max"):
        region[end] = [a + b for a, b in zip(region[end], case["grid"]["origin"], strict=True)]
    lattice = start(case).rank.lattice_cells()
    assert len(lattice.cells.place) == 25
    assert not len(lattice.off_lattice.rows)


@pytest.mark.parametrize("cell", [0.1, 0.0442])
def test_vertices_that_bodies_reach_by_rounding_keep_nothing(cell):
    """Those that keep motion are the corners of the bodies' cells: no step moves others."""
    body = initial(box([4.0, 2.0], [5.0, 6.0], [0.3, -2.0]))
    case = scene(2, body, cells=[9, 9], cell=cell, step={"courant": 0.3})
    origin, region = [-0.073052, -0.15995], case["bodies"]["body"]["region"]["box"]
    case["grid"]["origin"] = origin
    for end in ("min", "max"):
        region[end] = [round(cell * a + b, 6) for a, b in zip(region[end], origin, strict=True)]
    sim = start(case)
    values = sim.rank.grid.by_vertex(sim.rank.grid.motion.values)[:, 0, :, 0]
    window, ghost = sim.rank.grid.window, sim.rank.grid.frame.ghost
    corners = np.zeros((sim.rank.grid.planes, window.extent[1]), bool)
    corners[4 + ghost : 6 + ghost, 2 + ghost - window.lower[1] :][:, :5] = True
    assert ((values[..., KEPT_MASS] > 0.0) == corners).all()
    assert (values.any(axis=-1) == corners).all()


def test_a_particle_inside_out_is_named():
    sim = start(scene(2, initial(box([1.0, 1.0], [4.0, 3.0])), step=0.02, end=9.0))
    values = sim.rank.grid.by_vertex(sim.rank.grid.motion.values)
    values[5, ..., 5] = -60.0  # a plane of vertices, thrown at the next one
    with pytest.raises(RunError, match=r"particle \d+ of body 'body' is turned inside out"):
        finish(sim)


def test_passing_a_wall_that_does_not_hold_it_stops_the_run():
    case = scene(2, initial(box([0.0, 1.0], [3.0, 3.0], [0.0, -9.0])), end=2.0, step=0.01,
                 boundaries={"x-min": "slip", "y-min": "fixed"})  # fmt: skip
    with pytest.raises(RunError, match=r"left the domain through y-min"):
        finish(start(case))
