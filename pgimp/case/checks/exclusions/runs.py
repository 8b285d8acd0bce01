"""Exclusions of loads, of damping, of the start and of stages: what can happen to a scene."""

from __future__ import annotations

from pgimp.case.checks.exclusions import features as f
from pgimp.case.checks.exclusions import loads as g
from pgimp.case.checks.exclusions.exclusion import Exclusion

#: Begins the messages about mass scaling.
_INERTIA = "changes inertia, for quasi-static runs: "

#: What moves the solution, which an exact one does not know.
_EXACT = "changes the initial state, which `exact` gives"

_NO_PARTICLES = "'{a.name}' is rigid, and has no particles: "

RUNS = (
    # Tractions.
    Exclusion(g.tractions, f.liquid,
        "'{a.name}' flows ({b.kind}): of its deformation only the volume is known, and no face",
        "press it with a rigid body or a moving wall (boundaries)", "owner"),
    Exclusion(g.region_tractions, f.points,
        "'{a.name}' is of particles from a file, whose surface is not known",
        "load a body with a region or a mesh", "owner"),
    Exclusion(g.tractions, g.entering,
        "'{a.name}' enters by an inflow, and has no lasting face", "load another body", "owner"),
    *(
        Exclusion(feature, f.rigid, _NO_PARTICLES + why, remedy, "owner")
        for feature, why, remedy in (
            (g.tractions, "a traction pulls at a body of a material",
                "a rigid one moves as its key `rigid` says"),
            (g.constraints, "a constraint holds parts of a body of a material",
                "give a rigid one its motion by its key `rigid`"),
            (g.probes, "none can be followed", "history.csv has its motion, rigid.{a.name}"),
        )),
    Exclusion(g.face_tractions, f.no_box,
        "the region of '{a.name}' is a {b.name}, which has no such faces",
        "load the part of its surface that lies in a region: region: {{box: ..}} in place of face",
        "owner"),
    # Inflow.
    Exclusion(g.entering, f.rigid,
        "'{a.name}' is rigid", "only bodies of a material enter", "owner"),
    Exclusion(f.no_box, g.entering,
        "that of an inflow is a box, which layers of particles fill", "take box", "owner"),
    Exclusion(g.entering, f.varying,
        "material '{b.name}' varies in space, and what enters is all alike",
        "take a material that does not", "owner"),
    Exclusion(g.entering, g.exact, "brings what `exact` does not know of", "leave one of them out"),
    Exclusion(g.entering, g.settling,
        "does not come to rest, as settle looks for", "leave one of them out"),
    # Damping and mass scaling. Local damping takes a part of the force before contact.
    Exclusion(g.damping, f.free_rigid,
        "is for bodies of a material, at the vertices of the grid; '{b.name}' is rigid and moves "
        "freely, and would go on:", "leave damping out, or give it a motion, rigid: "
        "{{velocity: ..}}"),
    Exclusion(g.local_damping, f.meetings,
        "is a part of the force on a vertex before {b.name}, so that what is at rest would press "
        "with other forces:", "take {{kinetic: true}} or {{mass: RATE}}"),
    *(
        Exclusion(g.mass_scaling, feature, _INERTIA + why, remedy, "", True)
        for feature, why, remedy in (
            (f.begins_moving, "'{b.name}' begins with a velocity", "leave one of them out"),
            (f.more_than_inertia, "the density of '{b.name}' ({b.kind}) is more than inertia",
                "leave this out"),
            (f.varying_density, "give '{b.name}' one density", "layers may be bodies of their own"),
            (f.free_rigid, "'{b.name}' moves freely, by inertia", "give it a motion"),
            (g.absorbing, "waves that {b.name} absorbs have another speed", "hold the face"),
            (g.entering, "inflow would not be what it is", "leave one of them out"),
            (g.any_body_force, "body-force would not be what it is", "leave one of them out"),
            (g.exact, "exact would not be what it is", "leave one of them out"),
        )),
    # The start, and stages.
    Exclusion(g.settling, f.free_rigid,
        "is for bodies of a material; '{b.name}' is rigid and moves freely:",
        "give it a motion, rigid: {{velocity: ..}}, or leave one of the two out", "", True),
    Exclusion(g.moving, g.settling,
        "moves at {b.name}, and settle looks for rest under what acts then:",
        "let it be 0 then, by a table over time (or by the stage), or leave settle out"),
    Exclusion(f.begins_moving, g.moving_exact,
        "the exact solution gives the initial velocity", "leave this out"),
    Exclusion(g.settling, g.exact, _EXACT, "leave one out"),
    Exclusion(g.weight, g.exact, _EXACT, "leave one out"),
    Exclusion(g.weight, f.free_rigid,
        "the rigid body '{b.name}' moves freely, and its weight is not known to what is under it:",
        "prescribe its velocity, or make it a body of stiff material that a constraint with a "
        "`force` moves; or give the stress by a function of your own, in a liquid that floats it "
        "as if there were no body", "", True),
    Exclusion(g.stressed, f.points,
        "the particles of '{a.name}' come from a file, whose columns are unknown:",
        "give their stress there (stress-xx, ..), and leave start.stress out", "owner"),
    Exclusion(g.exact, g.stages,
        "is the solution of a case without stages (time.stages)", "leave one of them out"),
    Exclusion(g.added, g.entering, "'{a.owner}' enters by an inflow, which begins with the run",
        "let its velocity be 0 at first, by a function of time", "owner"),
    Exclusion(g.added, f.rigid, "'{a.owner}' is rigid, and rigid bodies are there from the start",
        "let it wait where it meets nothing, and move it by a table of velocities", "owner"),
    Exclusion(g.added, f.initial,
        "'{a.owner}' is in the initial configuration, whose grid belongs to all of its bodies as "
        "they are at the start", "a body that comes takes formulation: updated-lagrangian",
        "owner"),
    Exclusion(g.added, f.points,
        "the particles of '{a.owner}' are from a file, and come at the start only",
        "give the body a region of another kind", "owner"),
    Exclusion(g.added, f.varying,
        "the material of '{a.owner}' varies in space, and is set at the start only",
        "give the body a material that is the same everywhere", "owner"),
    Exclusion(g.probes, g.added,
        "'{a.owner}' comes in the stage '{b.name}', and a probe follows a particle from the start",
        "give {{place: ...}}", "owner"),
)  # fmt: skip
