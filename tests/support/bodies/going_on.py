"""A run, and another case that goes on from its last frame or checkpoint."""

from copy import deepcopy

import numpy as np

import pgimp
from pgimp.mpi.comm import Serial

#: Fields of a frame from which a case can go on, besides the states of its materials.
FIELDS = ["velocity", "stress", "deformation", "mass", "initial-volume"]


def until(case, end, step=0.01, **parts):
    """A case with steps of one length, to another time."""
    found = deepcopy(case)
    for key in ("history", "probes"):
        found.pop(key, None)
    return found | {"time": {"end": end, "step": step}, "output": {"fields": FIELDS}} | parts


def last(folder, kind="checkpoints"):
    """The last checkpoint, or frame, of a run."""
    ending = "step-*.h5" if kind == "checkpoints" else "particles-*.h5"
    return str(sorted((folder / kind).glob(ending))[-1])


def going_on(case, file):
    """A case whose bodies, except the rigid ones, go on from a file."""
    found = deepcopy(case)
    for body in found["bodies"].values():
        if "rigid" not in body:
            body["region"] = {"points": {"file": str(file)}}
            body.pop("velocity", None)
    return found


def columns(sim):
    """Columns of a simulation's particles by id, up to date."""
    rank = sim.core.rank
    p, rows = rank.up_to_date(), rank.live()
    rows = rows[np.argsort(p.id[rows])]
    return {name: getattr(p, name)[rows] for name in p._fields}


def run_to(case, folder):
    """Run a case into a folder; returns the folder."""
    pgimp.run(case, comm=Serial(), output=folder, quiet=True)
    return folder


def at_end(case):
    """A simulation at its end."""
    sim = pgimp.Simulation(case, comm=Serial())
    sim.advance()
    return sim
