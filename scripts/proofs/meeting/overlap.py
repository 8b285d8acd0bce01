"""What must hold in every step of a scene whose bodies meet by their surfaces.

Momentum along directions without a load or a wall, and with no rigid body that is moved, is kept to
rounding; so is angular momentum in free scenes. Energy is at most what was put in. No surface is
deeper in another body than a part of a cell, unless the run says so.
"""

import numpy as np

import pgimp
from pgimp.errors import PgimpError
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

#: Cells that a surface may be deep; part of the energy that steps of finite length may add.
DEEP, CREATED = 0.05, 0.03


def check(path):
    """How a case ends on one rank, and what is wrong with it."""
    try:
        case = pgimp.load(path)
        sim = Simulation(case, Serial())
        lines, deep = [sim.diagnostics()], (0.0, 0.0)
    except PgimpError as error:
        return f"refused: {str(error).split(': ', 1)[-1][:90]}", []
    said = []
    try:
        while not sim.finished:
            if sim.stage_done:
                sim.next_stage()
            sim.advance()
            lines.append(sim.diagnostics())
            deep = min(deep, _depth(sim))
            said += sim.diagnostic_sums.said
    except PgimpError as error:
        return "failed", [str(error)]
    wrong = [*_momenta(case, lines), *_energy(case, lines)]
    if -deep[0] > DEEP and not said:
        wrong.append(f"a surface is {-deep[0]:.3g} cells deep at time {deep[1]:.4g}")
    return "overrun" if said else "done", wrong


def _depth(sim):
    """The least gap of a patch that touches, in cells, and the time."""
    contact = sim.rank.contact
    gaps = contact.proximity.candidates["gap"] if hasattr(contact, "proximity") else np.zeros(0)
    return float(gaps.min(initial=0.0)) / min(sim.scene.domain.frame.cell), sim.time


def _total(line, name):
    return line[name] + sum(line.get(f"{how}.{name}", 0.0) for how in ("outflow", "removed"))


def _momenta(case, lines):
    """Directions along which momentum changes though nothing acts."""
    moved = any(not body.free for body in case.rigid_bodies.values())
    scale = sum(line for name, line in lines[0].items() if name == "mass") * 10.0
    for d in range(case.dimensions):
        axis = "xyz"[d]
        faces = [face for face, kind in case.boundaries.items()
                 if getattr(kind, "approaches", False) or hasattr(kind, "velocity")
                 or type(kind).__name__ == "Slip"]  # fmt: skip
        rough = any(getattr(case.boundaries[face], "friction", None) for face in faces)
        held = rough or any(face.startswith(axis) for face in faces)
        loaded = case.gravity is not None and d == case.dimensions - 1
        if moved or held or loaded or (case.axisymmetric and d == 0):
            continue
        name = f"momentum-{axis}"
        values = np.array([_everything(line, name, case) for line in lines])
        off = np.ptp(values) / scale
        if off > 1e-11:
            yield f"momentum along {axis} changes by {off:.3g} of mass times wave speed"


def _everything(line, name, case):
    """A momentum with that of free rigid bodies."""
    tools = (f"rigid.{body}.{name}" for body in case.rigid_bodies)
    return _total(line, name) + sum(line.get(tool, 0.0) for tool in tools)


def _energy(case, lines):
    """Energy that comes from nothing."""
    free = [body for body in case.rigid_bodies.values() if body.free]
    if any(case.gravity is not None or body.rigid.force or body.rigid.spring for body in free):
        return  # the work of their weight, of given forces and of springs is in no book
    E = np.array([_total(line, "kinetic-energy") + _total(line, "strain-energy") for line in lines])
    for body, entry in case.rigid_bodies.items():
        if entry.free:
            E += np.array([line[f"rigid.{body}.kinetic-energy"] + line[f"rigid.{body}.work"]
                           for line in lines])  # fmt: skip
    W = np.array([line["external-work"] for line in lines])
    heat = np.array([sum(v for n, v in line.items() if n.endswith("friction-heat"))
                     for line in lines])  # fmt: skip
    most = E.max() + np.abs(W).max()
    gained = float((E + np.maximum(heat, 0.0) - W - E[0]).max()) / max(most, 1e-300)
    if gained > CREATED:
        yield f"{gained:.3g} of the energy comes from nothing"
