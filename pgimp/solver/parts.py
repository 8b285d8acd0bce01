"""What only some scenes add to a step: one table, in the order in which the parts act."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.penetration import penetration_of
from pgimp.solver.damping.absorbing import absorbing_of
from pgimp.solver.damping.damping import damping_of
from pgimp.solver.flows import flows_of
from pgimp.solver.history.crossings import crossings_of
from pgimp.solver.lagrangian.averaged_mass import averaged_mass_of
from pgimp.solver.lagrangian.mean_dilatation import mean_dilatation_of
from pgimp.solver.lagrangian.slaves import slaves_of
from pgimp.solver.loads.grips import grips_of
from pgimp.solver.loads.surface_kinematics import surface_kinematics_of
from pgimp.solver.phases.orders import phases_of
from pgimp.solver.sources.inflow import inflow_of
from pgimp.solver.sources.sinks import sinks_of
from pgimp.solver.vertices import StepPart

#: By its attribute of a rank, what makes a part from the scene, the communicator and the part of
#: the stage before, if any; it returns None for a scene without it.
PARTS: dict[str, Callable[[Scene, Communicator, Any], StepPart | None]] = {
    "surface_kinematics": surface_kinematics_of,
    "grips": grips_of,
    "slaves": slaves_of,
    "mean_dilatation": mean_dilatation_of,
    "absorbing": absorbing_of,
    "damping": damping_of,
    "averaged_mass": averaged_mass_of,
    "phases": phases_of,
    "crossings": crossings_of,
    "flows": flows_of,
    "penetration": penetration_of,
    "sinks": sinks_of,
    "inflow": inflow_of,
}


def parts_of(rank: Any) -> list[StepPart]:
    """Return the parts that a rank's scene adds to a step, in their order."""
    return [part for name in PARTS if (part := getattr(rank, name))]
