"""What is at rest, or goes round, watched for long."""

import numpy as np
from studies.quiet.ground import ground
from studies.scenes import a_line, box, case_of, core, throw

import pgimp

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}


def rests():
    """Names and cases of ground that lies on absorbing faces, or is a ring."""
    return {
        "ground on an absorbing face": ground(boundaries={"y-min": "absorbing"}),
        "ground of rings": ground(geometry="axisymmetric"),
        "ground that has settled, a slope, between absorbing faces": settled(),
    }


def settled():
    """A slope that settles before its first step."""
    region = {"half-space": {"point": [0.0, 4.3], "normal": [-0.2, 1.0]}}
    whole = box([0.0, 0.0], [6.0, 9.0])
    case = ground(
        bodies={"b": {"material": "m", "region": {"intersection": [whole, region]}}},
        boundaries={face: "absorbing" for face in ("x-min", "x-max", "y-min")},
    )
    return case | {"start": {"stress": {"k0": 0.6}, "equilibrate": {"tolerance": 1e-8}}}


def rounds(steps):
    """Two blocks that meet and go round: worst change of momentum, and turns of one."""
    bodies = {
        name: {"material": "m", "velocity": [speed, 0.0], "region": box(low, high)}
        for name, speed, low, high in (
            ("slow", 0.2, [1.0, 1.0], [4.0, 4.0]), ("fast", 0.6, [6.0, 2.0], [9.0, 5.0]),
        )
    }  # fmt: skip
    faces = {f"{axis}-{end}": "periodic" for axis in "xy" for end in ("min", "max")}
    sim = pgimp.Simulation(case_of(
        [12.0, 8.0], 1.0, {"m": SOFT}, bodies, 1e9, boundaries=faces, method={"affine": True},
        contact=[{"bodies": "all", "friction": 0.3}],
    ))  # fmt: skip
    begun, worst = a_line(sim), 0.0
    for _ in range(100):
        sim.step(steps // 100)
        line = a_line(sim)
        worst = max(worst, *(abs(line[k] - begun[k]) for k in ("momentum-x", "momentum-y")))
    turns = (line["body.fast.centre-x"] - begun["body.fast.centre-x"]) / 12.0
    return worst / begun["momentum-x"], turns


def channel(steps):
    """A stream that enters at one end and leaves at the other: mass lost, and its mean speed."""
    water = {"model": "newtonian", "bulk": 400.0, "shear-viscosity": 0.05, "density": 1.0}
    sim = pgimp.Simulation(case_of(
        [8.0, 3.0], 0.5, {"m": water},
        {"jet": {"material": "m", "region": box([0.0, 0.0], [1.0, 1.0])}}, 1e9,
        inflow={"jet": {"velocity": [1.0, 0.0]}}, escape={"x-max": "remove"},
        boundaries={"y-min": "slip", "y-max": "slip"}, gravity=[0.0, -0.2],
    ))  # fmt: skip
    begun, lost = a_line(sim)["mass"], 0.0
    for _ in range(100):
        sim.step(steps // 100)
        line = a_line(sim)
        lost = max(lost, abs(line["mass"] - line["inflow.mass"] + line["outflow.mass"] - begun))
    return lost / begun, sim.particles["velocity"][:, 0].mean()


def ring(configuration, steps):
    """A tube that breathes freely: mean energy of the last tenth of steps, over the first's."""
    region = box([1.0, 0.0], [2.0, 1.0])
    body = {"material": "m", "formulation": configuration, "region": region}
    sim = core(case_of(
        [4.0, 2.0], 0.25, {"m": SOFT}, {"b": body}, 1e9, geometry="axisymmetric",
        boundaries={"y-min": "slip"}, method={"affine": configuration == "current"},
    ))  # fmt: skip
    x = sim.particles.x[sim.live()]
    v = np.stack([0.1 * x[:, 0], np.zeros(len(x))], axis=1)
    throw(sim, v, np.broadcast_to(np.diag([0.1, 0.0]), (len(x), 2, 2)))
    if configuration == "current":
        sim.particles.L[sim.live(), 4] = 0.1  # of the hoop
    found = []
    for _ in range(steps // 10):
        for _ in range(10):
            sim.advance()
        line = sim.diagnostics()
        found.append(line["kinetic-energy"] + line["strain-energy"])
    tenth = len(found) // 10
    return np.mean(found[-tenth:]) / np.mean(found[:tenth])
