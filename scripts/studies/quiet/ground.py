"""Ground that begins under its own weight: how far from rest it is."""

import numpy as np
from studies.scenes import box, case_of, core

HOOKE = {"model": "hooke", "young": 1000.0, "poisson": 0.3, "density": 1.0}
LAYERS = {"soft": HOOKE, "stiff": HOOKE | {"young": 3000.0, "density": 2.0}}
WIDE, HIGH = 6.0, 5.0


def ground(*, dimension=2, materials=None, bodies=None, k0=0.6, side="slip", stress=(), **parts):
    """Ground of unit density under unit gravity, on cells of unit size."""
    upward = dimension - 1
    top = [WIDE] * upward + [HIGH]
    bodies = bodies or {"b": {"material": "m", "region": box([0.0] * dimension, top)}}
    faces = {f"{axis}-{end}": "slip" for axis in "xyz"[:upward] for end in ("min", "max")}
    if upward:
        faces["x-max"] = side
    faces = {face: what for face, what in faces.items() if what}
    return case_of(
        [WIDE] * upward + [HIGH + 5.0], 1.0, materials or {"m": HOOKE}, bodies, 1e9,
        gravity=[0.0] * upward + [-1.0], start={"stress": {"k0": k0, **dict(stress)}},
        boundaries=faces | {f"{'xyz'[upward]}-min": "slip"} | parts.pop("boundaries", {}), **parts,
    )  # fmt: skip


def cut(*region):
    """The region below planes, as a body of the material m."""
    whole = box([0.0, 0.0], [WIDE, HIGH + 4.0])
    return {"b": {"material": "m", "region": {"intersection": [whole, *region]}}}


def below(height, rise=0.0):
    """A half-space below a plane through a height at x = 0."""
    return {"half-space": {"point": [0.0, height], "normal": [-rise, 1.0]}}


def layers(**parts):
    """Two layers, the lower one stiffer and heavier."""
    bodies = {
        "low": {"material": "stiff", "region": box([0.0, 0.0], [WIDE, 2.0])},
        "high": {"material": "soft", "region": box([0.0, 2.0], [WIDE, HIGH])},
    }
    return ground(materials=LAYERS, bodies=bodies, k0={"low": 1.0, "high": 0.6}, **parts)


def fluid(model):
    """Level ground of a material that flows."""
    laws = {
        "newtonian": {"bulk": 1000.0, "shear-viscosity": 0.1},
        "mu-i": {
            "young": 1000.0,
            "poisson": 0.3,
            "mu-s": 0.4,
            "mu-2": 0.6,
            "i0": 0.3,
            "grain": 0.05,
            "grain-density": 1.7,
        },
    }
    return ground(materials={"m": {"model": model, "density": 1.0} | laws[model]})


#: Name in the table, and cases of which the worst counts.
SCENES = {
    "level, on the lines of the grid": [lambda: ground()],
    "the same in 1D and 3D": [lambda: ground(dimension=1), lambda: ground(dimension=3)],
    "the same, two layers; under `contact`": [
        layers, lambda: layers(contact=[{"bodies": "all", "friction": 0.5}]),
    ],
    "the same, of rings": [lambda: ground(geometry="axisymmetric")],
    "the same, on an absorbing face": [lambda: ground(boundaries={"y-min": "absorbing"})],
    "the same, in water under a surcharge on a face": [
        lambda law=law: ground(
            materials={"m": HOOKE | {"model": law}}, water={"level": 3.0, "density": 0.4},
            tractions={"fill": {"body": "b", "face": "y-max", "pressure": 2.0}},
            stress={"surcharge": ["fill"]},
        ) for law in ("hooke", "neo-hookean")
    ],
    "the same, of `newtonian`; of `mu-i`": [lambda: fluid("newtonian"), lambda: fluid("mu-i")],
    "the same, with `bspline-quadratic`; with `fuzzy-constant`": [
        lambda: ground(method={"shape": "bspline-quadratic"}),
        lambda: ground(method={"shape": "fuzzy-constant"}),
    ],
    "level, its surface within a cell": [lambda: ground(bodies=cut(below(4.3)))],
    "a slope of 1 in 10": [lambda: ground(bodies=cut(below(4.3, 0.1)))],
    "a slope of 1 in 5": [lambda: ground(bodies=cut(below(4.3, 0.2)))],
    "a slope of 1 in 2.5": [lambda: ground(bodies=cut(below(4.3, 0.4)))],
    "level, its side open": [
        lambda: ground(side=None, bodies={
            "b": {"material": "m", "region": box([0.0, 0.0], [WIDE - 1.0, HIGH])},
        }),
    ],
}  # fmt: skip


def unrest(case, steps):
    """Greatest velocity of a particle in some steps, over the wave speed, once it has settled."""
    sim, most = core(case), 0.0
    while sim.settling:
        sim.advance()
    speed = sim.rate * case["grid"]["cell"][0]
    for _ in range(steps):
        sim.advance()
        most = max(most, np.abs(sim.particles.v[sim.live()]).max())
    return most / speed
