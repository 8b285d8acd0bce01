"""Problems with exact answers: cases, and what is known of their quantities."""

from math import cos, exp, log, pi, radians, sin, sqrt

from studies.harness import CASES
from studies.scenes import case_of, filled

#: Of a soft bar: Young's modulus, density, wave speed, length.
E, RHO, C, L = 4.0e5, 1000.0, 20.0, 1.0
G = 9.81
RUBBER = {"model": "linear-1d", "young": E, "density": RHO}
#: Of blocks in 2D.
SOFT = {"model": "neo-hookean", "young": 1.0e6, "poisson": 0.3, "density": 1000.0}
#: Few steps between lines, as in a case that is to be looked at.
OFTEN = {"every": {"steps": 5}}
STEEL = 7800.0 * sqrt(200.0e9 / 7800.0)  # impedance of the bars of Hopkinson


def bar(cell, configuration="current", shape="gimp"):
    """A bar that hangs, and whose weight sets in at once."""
    body = {"bar": {"material": "rubber", **filled([0.0], [L]), "formulation": configuration}}
    return case_of(
        [L + 0.08], cell, {"rubber": RUBBER}, body, 0.3, courant=0.2, gravity=[G],
        boundaries={"x-min": "fixed"}, history=OFTEN, probes={"tip": {"body": "bar", "at": [L]}},
        method={"shape": shape},
    )  # fmt: skip


#: What is exact of it: quantity, when, value.
HANGING = (
    ("probe.tip.displacement-x", "max", G * L**2 / C**2),
    ("body.bar.centre-x", 0.1, 0.5 * L + 2.0 * RHO * G * L**2 / (3.0 * E)),
    ("strain-energy", "max", 4.0 * (RHO * G) ** 2 * L**3 / (6.0 * E)),
    ("kinetic-energy", 0.05, RHO * G**2 * L**3 / (6.0 * C**2)),
    ("momentum-x", "max", -RHO * G * L**2 / (2.0 * C)),
    ("reaction.x-min-x", {"mean": [1.0e-9, 0.2]}, -RHO * G * L),
)


def thrown(cell, configuration="current"):
    """A bar that is thrown at a wall, which lets it go again."""
    body = {"material": "rubber", **filled([0.0], [L]), "velocity": [-0.2]}
    return case_of(
        [L + 0.4], cell, {"rubber": RUBBER}, {"bar": body | {"formulation": configuration}},
        0.15, courant=0.2, boundaries={"x-min": "unilateral"}, history=OFTEN,
        probes={"end": {"body": "bar", "at": [L]}},
    )  # fmt: skip


THROWN = (
    ("strain-energy", "max", 0.5 * RHO * L * 0.2**2),
    ("momentum-x", "end", 0.2 * RHO * L),
    ("kinetic-energy", "end", 0.5 * RHO * L * 0.2**2),
    ("reaction.x-min-x", {"mean": [0.02, 0.08]}, RHO * C * 0.2),
    ("probe.end.displacement-x", "max", -0.2 * L / C),
)


def struck(cell, configuration="current"):
    """Two equal bars that meet and part."""

    def one(low, velocity):
        part = {"material": "rubber", **filled([low], [low + L]), "velocity": [velocity]}
        return part | {"formulation": configuration}

    return case_of(
        [2.4], cell, {"rubber": RUBBER}, {"left": one(0.2, 0.1), "right": one(1.2, -0.1)}, 0.15,
        courant=0.2, contact=[{"bodies": "all"}], history=OFTEN,
    )  # fmt: skip


STRUCK = (
    ("body.left.momentum-x", "end", -0.1 * RHO * L),
    ("strain-energy", "max", RHO * L * 0.1**2),
    ("kinetic-energy", "end", RHO * L * 0.1**2),
    ("contact.all.normal-impulse", "end", 2.0 * 0.1 * RHO * L),
)


def column(cell, **method):
    """Ground 1 m deep and 0.5 m wide whose weight sets in slowly, held at its sides."""
    ground = {"model": "hooke", "young": 1.6e7, "poisson": 0.3, "density": 1000.0}
    body = {"material": "ground", **filled([0.0, 0.0], [0.5, 1.0])}
    body["formulation"] = method.pop("formulation", "updated-lagrangian")
    turns = [[k / 10.0, [0.0, -0.5 * G * (1.0 - cos(0.1 * pi * k))]] for k in range(11)]
    return case_of(
        [0.5, 1.25], cell, {"ground": ground}, {"ground": body}, 1.2, courant=0.4, method=method,
        gravity={"table": turns}, history=OFTEN,
        probes={"top": {"body": "ground", "at": [0.25, 1.0]}},
        boundaries={"x-min": "slip", "x-max": "slip", "y-min": "slip"},
    )  # fmt: skip


_M = 1.6e7 * 0.7 / (1.3 * 0.4)  # constrained modulus
COLUMN = (
    ("probe.top.displacement-y", {"mean": [1.05, 1.2]}, -RHO * G / (2.0 * _M)),
    ("reaction.y-min-y", {"mean": [1.05, 1.2]}, 0.5 * RHO * G),
    ("strain-energy", {"mean": [1.05, 1.2]}, 0.5 * (RHO * G) ** 2 / (6.0 * _M)),
)


def flying(cell, spin=0.0, **method):
    """A block of 0.6 x 0.4 m that falls, or that turns freely."""
    body = {"material": "rubber", **filled([0.6, 0.7], [1.2, 1.1])}
    body["formulation"] = method.pop("formulation", "updated-lagrangian")
    if spin:
        body["velocity"] = {
            "translation": [0.0, 0.0],
            "rotation": {"about": [0.9, 0.9], "rate": spin},
        }
    return case_of(
        [1.8, 1.8], cell, {"rubber": SOFT}, {"block": body}, 0.3, courant=0.3, method=method,
        history=OFTEN, **({} if spin else {"gravity": [0.0, -G]}),
    )  # fmt: skip


_MASS, _INERTIA = 240.0, 240.0 * (0.6**2 + 0.4**2) / 12.0
FALLING = (
    ("body.block.centre-y", "end", 0.9 - 0.5 * G * 0.3**2),
    ("kinetic-energy", "end", 0.5 * _MASS * (0.3 * G) ** 2),
    ("momentum-y", "end", -_MASS * 0.3 * G),
)


def couette(cell):
    """Oil between plates without ends, the upper of which moves."""
    oil = {"model": "newtonian", "bulk": 5.0e4, "density": 1000.0, "shear-viscosity": 24.76136}
    return case_of(
        [4.0 * cell, 0.1], cell, {"oil": oil},
        {"oil": {"material": "oil", **filled([0.0, 0.0], [4.0 * cell, 0.1])}}, 0.5, courant=0.3,
        boundaries={"x-min": "periodic", "x-max": "periodic", "y-min": "fixed",
                    "y-max": {"velocity": [0.1, 0.0]}},
        history={"every": {"steps": 10}}, probes={"middle": {"place": [2.0 * cell, 0.05]}},
    )  # fmt: skip


def poiseuille(t):
    """Velocity in the middle, and its mean over the width, of cases/poiseuille.yaml."""
    nu, H = 24.76136e-3, 0.1
    middle, mean = G * H**2 / (8.0 * nu), G * H**2 / (12.0 * nu)
    for n in range(1, 40, 2):
        part = 4.0 * G * H**2 / (nu * (pi * n) ** 3) * exp(-((n * pi / H) ** 2) * nu * t)
        middle -= part * sin(0.5 * n * pi)
        mean -= part * 2.0 / (n * pi)
    return middle, mean


_MIDDLE, _MEAN = poiseuille(0.25)
_SLIDES = 1000.0 * 0.12 * G * (sin(radians(24.0)) - 0.3 * cos(radians(24.0)))
_BORE = 3.22215e-4


def shipped(name, quantities, *variants, **more):
    """Variants of a case of cases/, by the cells of each."""
    for cell in variants:
        changes = {"grid.cell": cell} | more
        yield f"{name}.yaml, cells {cell[0]:g}", CASES / f"{name}.yaml", changes, quantities


def problems():
    """Name, case or its file, changes, and exact values: (quantity, when, value)."""
    for cell, way in ((0.04, "current"), (0.02, "current"), (0.04, "initial"), (0.02, "initial")):
        yield f"hanging bar, cells {cell}, {way}", bar(cell, way), {}, HANGING
        yield f"thrown bar, cells {cell}, {way}", thrown(cell, way), {}, THROWN
    yield "hanging bar, one a cell", bar(0.04), {"method.particles-per-cell": [1]}, HANGING
    yield "hanging bar, cpdi", bar(0.04, shape="cpdi"), {}, HANGING
    for cell, way in ((0.05, "current"), (0.025, "current"), (0.05, "initial")):
        yield f"bars that meet, cells {cell}, {way}", struck(cell, way), {}, STRUCK
    for cell, way in ((0.125, "current"), (0.0625, "current"), (0.0625, "initial")):
        case = column(cell, formulation=way)
        yield f"column of ground, cells {cell}, {way}", case, {}, COLUMN
    yield "falling block", flying(0.1), {}, FALLING
    turning = {
        "gimp": {},
        "affine": {"affine": True},
        "initial": {"formulation": "total-lagrangian"},
    }
    spun = (
        ("angular-momentum-z", "end", 8.0 * _INERTIA),
        ("kinetic-energy", "end", 0.5 * _INERTIA * 64.0),
    )
    for way, method in turning.items():
        for cell in (0.1, 0.05):
            yield f"turning block, cells {cell}, {way}", flying(cell, 8.0, **method), {}, spun
    dragged = (
        ("reaction.y-max-x", {"mean": [0.4, 0.5]}, 24.76136 * 0.1 / 0.1 * 0.05),
        ("probe.middle.velocity-x", "end", 0.05),
    )
    yield "Couette's flow", couette(0.0125), {}, dragged
    for cell in (0.0125, 0.00625):
        wide = {
            "grid.cell": [cell, cell],
            "grid.size": [0.05, 0.1],
            "bodies.oil.region.box.max": [0.05, 0.1],
            "probes.middle": {"place": [0.025, 0.05]},
        }
        flow = (("probe.middle.velocity-x", "end", _MIDDLE), ("momentum-x", "end", 5.0 * _MEAN))
        yield f"poiseuille.yaml, cells {cell}", CASES / "poiseuille.yaml", wide, flow
    shock = (
        ("reaction.x-min-x", {"mean": [0.02, 0.05]}, 20000.0),
        ("momentum-x", 0.04, -200.0),
        ("body.bar.centre-x", 0.04, 25.0 - 20.0 * 0.04 + 20.0 * 0.04**2 * 1000.0 / 100.0),
    )
    yield from shipped("shock", shock, [1.0], [0.5])
    hammer = tuple(
        ("rigid.hammer.velocity-x", t, -5.0 * exp(-sqrt(30.0e9 * 2400.0) * t / 15600.0))
        for t in (1.0e-3, 3.0e-3, 1.0e-2)
    )
    yield from shipped("pile", hammer, [0.4], [0.2])
    pulse = (("probe.front.stress-xx", {"mean": [1.3e-4, 2.8e-4]}, -0.5 * 10.0 * STEEL),)
    yield from shipped("hopkinson", pulse, [0.004])
    yield from shipped("blast", (("body.plate.momentum-x", "max", 0.6549 * 78.5),), [2.0e-3])
    settled = (-G * 2000.0 / 4.0e6) * (20.0 - 5.0 * log(5.0))
    ground = (
        ("probe.surface.displacement-x", {"mean": [10.2, 11.0]}, settled),
        ("reaction.x-min-x", {"mean": [10.2, 11.0]}, 20.0 * 2000.0 * G),
    )
    yield from shipped("graded", ground, [1.0], [0.5], accuracy=None)
    gas = (
        ("probe.left.density", "end", 0.426319), ("probe.left.velocity-x", "end", 0.927453),
        ("probe.right.density", "end", 0.265574), ("probe.right.pressure", "end", 0.303130),
    )  # fmt: skip
    places = {"left": {"place": [0.1]}, "right": {"place": [0.27]}}
    yield from shipped("sod", gas, [0.01], [0.005], probes=places)
    yield from shipped("incline", (("momentum-x", "end", _SLIDES),), [0.05, 0.05])
    inside = (("probe.bore.displacement-x", "end", _BORE),)
    bore = {"bore": {"body": "tube", "at": [0.5, 0.06]}}
    yield from shipped("tube", inside, [0.125, 0.125], [0.0625, 0.0625], probes=bore)
