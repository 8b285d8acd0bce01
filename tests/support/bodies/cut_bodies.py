"""Cases of bodies in one, two and three dimensions, and the particles that they become."""

import numpy as np
from pydantic import TypeAdapter

from pgimp.case.schema import Case
from pgimp.geometry.regions import RegionEntry
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.bodies.populate import populate
from pgimp.scene.scene import Scene

ENTRY = TypeAdapter(RegionEntry)


def region(entry):
    return ENTRY.validate_python(entry)


def box(low, high):
    return {"box": {"min": [float(x) for x in low], "max": [float(x) for x in high]}}


def ball(centre, radius):
    return {"ball": {"centre": [float(x) for x in centre], "radius": radius}}


def cylinder(start, end, radius):
    return {"cylinder": {"from": list(start), "to": list(end), "radius": radius}}


def half_space(point, normal):
    point, normal = [float(x) for x in point], [float(n) for n in normal]
    return {"half-space": {"point": point, "normal": normal}}


def body(entry, surface="cut-particles", velocity=None):
    body = {"material": "soft", "region": entry, "surface": surface}
    return body if velocity is None else body | {"velocity": velocity}


def particles(case, planes=None):
    """Particles of a case, or of a range of planes; without the rows that are none."""
    scene_ = Scene(Case.model_validate(case))
    lattice, counts, notes = count_particles(scene_, Serial())
    planes = planes or (0, lattice.planes)
    p = populate(scene_, lattice, counts, planes)
    n = int(counts[:, planes[0] : planes[1]].sum())
    return type(p)._make(array[:n] for array in p), notes


def spinning(dimension):
    """A rigid motion: its entry in a case, and the velocity that it means at a point."""
    if dimension == 1:
        return [0.7], lambda x: np.array([0.7])
    about, translation = np.array([1.5, -2.0, 0.3])[:dimension], np.array([0.4, -0.3, 0.8])
    omega = np.array([0.0, 0.0, 1.3]) if dimension == 2 else np.array([0.9, -0.4, 1.3])
    motion = {
        "rotation": {"about": about.tolist(), "rate": 1.3 if dimension == 2 else omega.tolist()},
        "translation": translation[:dimension].tolist(),
    }

    def velocity(x):
        arm = np.zeros(3)
        arm[:dimension] = x - about
        return (translation + np.cross(omega, arm))[:dimension]

    return motion, velocity
