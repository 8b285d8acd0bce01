"""Features of faces, of loads and of the course of a run, see `exclusions.table`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pgimp.case.checks.exclusions.feature import Feature, Place, named, of_key
from pgimp.case.checks.exclusions.features import some_initial
from pgimp.case.gauges import LevelGauge, WallGauge
from pgimp.case.outflow import Sink
from pgimp.geometry.regions import Points
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.derived import RECOVERED
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.loads import BODY_FORCES
from pgimp.physics.loads.own_stress import OwnStress
from pgimp.physics.loads.water import vertical_of
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import AXES, WHOLE
from pgimp.schema.tables import prescribed

# Faces, and ways out.
absorbing = named("absorbing faces", "boundaries", has=lambda entry: entry.absorbs)
periodic = named("periodic faces", "boundaries", has=lambda entry: entry.joins)
conditions = named("faces with a condition", "boundaries")
holding = named(
    "faces but unilateral ones that let go",
    "boundaries",
    has=lambda entry: (entry.approaches or entry.releases) and not hasattr(entry, "friction"),
)
on_axis = Feature(
    "a condition on the axis but slip",
    lambda boundaries, grid: (
        Place(("boundaries", face))
        for face, entry in boundaries.items()
        if face == "x-min" and grid.origin[:1] == (0.0,) and not isinstance(entry, Slip)
    ),
)
met_by_initial = Feature(
    "unilateral faces and bodies in the initial configuration",
    lambda boundaries, bodies: (
        Place(("boundaries", face), name, face)
        for face, entry in boundaries.items()
        for name in some_initial(bodies)[:1]
        if entry.approaches
    ),
)
outlet = named("`outflow` at a face", "outflow", has=lambda action: not isinstance(action, Sink))
outflow = named("`outflow`", "outflow")

# Loads.
body_force = Feature(
    "body forces of the package",
    lambda body_force: (
        Place(("body-force", name_of(body_force, BODY_FORCES)))
        for _ in range(body_force is not None and not isinstance(body_force, FunctionEntry))
    ),
)
any_body_force = of_key("body forces", "body-force", lambda body_force: body_force is not None)
tractions = named("tractions", "tractions", "body", owner=lambda entry: entry.body)
region_tractions = named(
    "tractions in a region",
    "tractions",
    "body",
    lambda entry: entry.face is None,
    lambda entry: entry.body,
)
face_tractions = named(
    "tractions on a face",
    "tractions",
    "face",
    lambda entry: entry.face is not None,
    lambda entry: entry.body,
)
constraints = named("constraints", "constraints", "body", owner=lambda entry: entry.body)
profiles = Feature(
    "profiles of tractions",
    lambda tractions: (
        Place(("tractions", name, "profile", "along"), name, axis=axis)
        for name, entry in tractions.items()
        if entry.face is None and entry.profile is not None
        for axis, part in zip(AXES, entry.profile.direction, strict=False)
        if part
    ),
)


def _at_ends(tractions: Any, bodies: Any, grid: Any) -> Iterator[Place]:
    for name, entry in tractions.items():
        body, face = bodies.get(entry.body), entry.face or ""
        axis, high = AXES.find(face[:1]), face.endswith("max")
        if body is not None and 0 <= axis < len(grid.size) and not isinstance(body.region, Points):
            end = body.region.bounds()[high][axis] - (grid.origin, grid.corner)[high][axis]
            if face and abs(end) <= WHOLE * grid.size[axis]:
                place = f"{face} of '{entry.body}'"
                yield Place(("tractions", name, "face"), place, axis=face[0])


at_ends = Feature("tractions where the domain ends", _at_ends)
turning = Feature(
    "constraints that turn about another axis",
    lambda dimensions, constraints: (
        Place(("constraints", name, "rotation"), name, axis=axis)
        for name, entry in constraints.items()
        if entry.rotation and dimensions > 1
        for axis, part in zip(AXES[:dimensions], entry.rotation.direction, strict=False)
        if abs(part) != 1.0
    ),
)
entering = named("inflow", "inflow")
inflow = Feature(
    "inflow along an axis",
    lambda inflow: (
        Place(("inflow", name, "velocity"), name, name, AXES[entry.axis])
        for name, entry in inflow.items()
    ),
)
water = Feature(
    "water in the ground",
    lambda water, gravity: (
        Place(("water",), axis=AXES[up[0]])
        for up in [vertical_of(gravity)]
        if water is not None and up is not None
    ),
)

# The course of a run, and what is looked at.
exact = of_key("exact solutions", "exact", lambda exact: exact is not None)
moving_exact = of_key(
    "exact solutions that begin with a velocity", "exact", lambda exact: exact and exact.moves
)
packaged_exact = of_key(
    "exact solutions of the package",
    "exact",
    lambda exact: exact is not None and not isinstance(exact, FunctionEntry),
)
damping = of_key("damping", "damping", lambda damping: damping is not None)
local_damping = of_key("local damping", "damping.local", lambda each: each and each.local)
mass_scaling = of_key("mass-scaling", "time.mass-scaling", lambda time: time.mass_scaling != 1.0)
settling = Feature(
    "`equilibrate`",
    lambda start, began: (
        Place(("start", "equilibrate"), f"t = {began:.15g}" if began else "time 0")
        for _ in range(start.equilibrate is not None)
    ),
)


def _moving(
    bodies: Any,
    rigid_bodies: Any,
    boundaries: Any,
    constraints: Any,
    inflow: Any,
    began: float,
    gone: Any,
) -> Iterator[Place]:
    for name, body in {} if began else bodies.items():
        if not isinstance(body.velocity, tuple) or any(body.velocity):
            yield Place(("bodies", name, "velocity"))
    for name, rigid in rigid_bodies.items():
        if not rigid.free and any(any(part) for part in rigid.rigid.velocities(began)):
            yield Place(("bodies", name, "rigid"))
    for face, entry in boundaries.items():
        ways = prescribed(getattr(entry, "velocity", ()), began, began)[1]
        if any(entry.motion(began) or ()) or any(ways):
            yield Place(("boundaries", face))
    for name, entry in constraints.items():
        if name in inflow or entry.body in gone:
            continue
        if entry.field or any(prescribed(entry.along, began, began)[1]):
            yield Place(("constraints", name, "velocity"))
        if entry.rotation and entry.rotation.speed(began):
            yield Place(("constraints", name, "rotation"))


moving = Feature("what moves before anything has happened", _moving)
stress = of_key("`start.stress`", "start.stress", lambda start: start.stress is not None)
weight = of_key(
    "the weight above",
    "start.stress",
    lambda start: start.stress is not None and not isinstance(start.stress, OwnStress),
)
stressed = Feature(
    "`start.stress`",
    lambda start, bodies: (
        Place(("start", "stress"), name, name)
        for name in bodies
        if start.stress is not None and start.stress.begins(name)
    ),
)
stages = of_key("stages", "time.stages", lambda time: time.stages)
added = Feature(
    "bodies that come in stages",
    lambda time: (
        Place(("time", "stages", i, "add", k), stage.name, name)
        for i, stage in enumerate(time.stages)
        for k, name in enumerate(stage.add)
    ),
)
contact_forces = Feature(
    "forces of contact in frames of the grid",
    lambda output: (
        Place(("output", "grid", i)) for i, name in enumerate(output.grid) if name == "contact"
    ),
)
wall_gauges = named(
    "gauges of walls",
    "gauges",
    "wall",
    lambda entry: isinstance(entry, WallGauge),
    lambda entry: entry.wall,
)
level_gauges = named(
    "gauges of levels", "gauges", "level", lambda entry: isinstance(entry, LevelGauge)
)
probes = named(
    "probes of bodies",
    "probes",
    "body",
    lambda entry: hasattr(entry, "body"),
    lambda entry: entry.body,
)
recovered = Feature(
    "`recovered-stress`",
    lambda output, probes: (
        Place((*path, i))
        for path, fields in (
            (("output", "fields"), output.fields),
            *((("probes", name, "fields"), entry.fields) for name, entry in probes.items()),
        )
        for i, field in enumerate(fields)
        if field == RECOVERED
    ),
)
