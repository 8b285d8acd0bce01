"""Loads of a case on parts of its bodies' surfaces."""

from __future__ import annotations

from collections.abc import Container, Mapping

import numpy as np

from pgimp.case.checks.exact_surfaces import exact_surfaces
from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.physics.loads.surfaces import UNIFORM, Profile, SurfaceLoad, surface_width
from pgimp.schema.tables import VectorFunction
from pgimp.schema.time_functions import TimeFunction


class SurfaceLoads:
    """Tractions, pressures and pressures of liquids on the surface in a region.

    Parameters
    ----------
    follows : dict of str to bool
        Whether the size of each body's particles follows the deformation.

    Attributes
    ----------
    entries : dict of str to TractionEntry
        Their entries by name, in the order of their columns.
    width : int
        Numbers of a particle's part of a surface.
    following : (bodies,) bool
        Bodies in the current configuration whose positions these loads follow.
    """

    def __init__(self, case: Case, follows: Mapping[str, bool]) -> None:
        self.follows = follows
        self.case, self.width = case, surface_width(case.dimensions)
        #: Names of the loads on faces that particles carry as patches.
        exact = dict(zip(case.bodies, exact_surfaces(case), strict=True))
        self.patched = [
            name
            for name, entry in case.tractions.items()
            if entry.face is not None and not exact[entry.body]
        ]
        self.entries = {
            name: entry for name, entry in case.tractions.items() if name not in self.patched
        }
        loaded = {entry.body for entry in self.entries.values() if entry.follower}
        self.following = np.array(
            [
                name in loaded and case.dimensions > 1 and body.formulation != "total-lagrangian"
                for name, body in case.bodies.items()
            ]
        )

    @property
    def closed(self) -> list[tuple[int, int]]:
        """Axis and side of the domain's faces with a condition, which hold what lies on them."""
        return [
            ("xyz".index(face[0]), -1 if face.endswith("min") else 1)
            for face in self.case.boundaries
        ]

    @property
    def varies(self) -> bool:
        """Whether the pressure of a liquid varies in time, or a profile moves."""
        if any(entry.profile and entry.profile.velocity != 0.0 for entry in self.entries.values()):
            return True
        liquids = [entry.hydrostatic for entry in self.entries.values() if entry.hydrostatic]
        levels = any(isinstance(liquid.level, TimeFunction) for liquid in liquids)
        return levels or (bool(liquids) and isinstance(self.case.gravity, VectorFunction))

    def at(self, t: float) -> tuple[SurfaceLoad, ...]:
        """Parameters of the kernels at time `t`."""
        case, gravity = self.case, self.case.gravity
        pull = gravity.value(t) if isinstance(gravity, VectorFunction) else gravity or ()
        each = zip(case.grid.cell, case.method.particles_per_cell, strict=True)
        part = 0.0 if case.method.chi == "point" else 0.5
        half = tuple(float(part * h / n) for h, n in each)
        profiled = any(entry.profile for entry in self.entries.values())
        corrected = 1.0 if self.following.any() else ()
        loads = [
            entry.surface_load(k * self.width, half, bool(self.follows.get(entry.body)), pull, t)
            for k, entry in enumerate(self.entries.values())
        ]
        if not profiled:
            return tuple(load._replace(corrected=corrected) for load in loads)
        return tuple(
            load._replace(corrected=corrected, profile=self._profile(name, t))
            for load, name in zip(loads, self.entries, strict=True)
        )

    def _profile(self, name: str, t: float) -> Profile:
        """Return the profile of a load at time `t`."""
        case, entry = self.case, self.entries[name].profile
        if entry is None:
            return UNIFORM
        each = zip(case.grid.cell, case.method.particles_per_cell, strict=True)
        half = [0.5 * h / n for h, n in each]
        return entry.parameters(half, t, case.staged.profile_offsets.get(name, 0.0))

    def require(
        self, p: Particles, n: int, comm: Communicator, bodies: Container[str] | None = None
    ) -> None:
        """Refuse loads on regions that touch no surface of their body; collective.

        The particles are the first `n`, of `bodies`, by default all that are there.

        Raises
        ------
        CaseError
            On every rank, if there is one.
        """
        if not self.entries:
            return
        loaded = np.any(comm.allgather((p.surface[:n, :: self.width] > 0.0).any(axis=0)), axis=0)
        for (name, entry), there in zip(self.entries.items(), loaded, strict=True):
            awaited = entry.body in self.case.staged.awaited
            if not there and not awaited and (bodies is None or entry.body in bodies):
                with located(self.case):
                    raise CaseError(
                        f"tractions.{name}.region: touches no surface of '{entry.body}'; let it "
                        "reach across the surface, to both sides"
                    )


def face_stretches(F: np.ndarray, axis: int, dimension: int) -> np.ndarray:
    """Current over initial area of faces normal to an axis at first, (n,), given ``particles.F``.

    It is the length of J F^-T N, by Nanson's formula.
    """
    C = np.tile(np.eye(3), (len(F), 1, 1))
    C[:, :dimension, :dimension] = F[:, : dimension**2].reshape(-1, dimension, dimension)
    if F.shape[1] == 5:
        C[:, 2, 2] = F[:, 4]
    normal = np.cross(C[:, :, (axis + 1) % 3], C[:, :, (axis + 2) % 3])
    return np.asarray(np.sqrt((normal * normal).sum(axis=1)))
