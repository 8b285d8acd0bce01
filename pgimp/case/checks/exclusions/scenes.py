"""Exclusions of geometry, method and faces: with what a scene can be described."""

from __future__ import annotations

from pgimp.case.checks.exclusions import features as f
from pgimp.case.checks.exclusions import loads as g
from pgimp.case.checks.exclusions.exclusion import Exclusion

_PERIODIC = "{b.axis}-min and {b.axis}-max are periodic, "

SCENES = (
    # Axisymmetric scenes: x is the radius.
    Exclusion(f.axisymmetric, f.not_plane,
        "axisymmetric is for 2 dimensions, the radius x and the axis y, but the case has {b.name}"),
    Exclusion(f.without_rings, f.axisymmetric,
        "{a.name} has no axisymmetric weights", "take gimp, finite-gimp, cpdi or mpm"),
    Exclusion(g.on_axis, f.axisymmetric,
        "is the axis, across which nothing moves:", "leave it out, or take slip"),
    Exclusion(f.motions, f.axisymmetric,
        "is along the axis, y, alone, as rings move: x is the radius", "take [0.0, ...]", "axis"),
    Exclusion(f.forces, f.axisymmetric,
        "acts along the axis, y, alone: x is the radius", "take [0.0, ...]", "axis"),
    Exclusion(g.body_force, f.axisymmetric, "is not known in axisymmetry", "leave it out"),
    Exclusion(g.packaged_exact, f.axisymmetric, "is not known in axisymmetry", "leave it out"),
    # What keeps a flow's volume (`kernels/flows/filling.py`) divides the volumes summed at a vertex
    # by a cell of the plane: of rings they are 2 pi r times as great. Its shift is along gradients
    # without the hoop, and would move rings across the axis.
    Exclusion(f.loose, f.axisymmetric,
        "'{a.name}' flows, which is not known in axisymmetry yet", "take 3 dimensions"),
    Exclusion(g.periodic, f.axisymmetric,
        "x is the radius, which has no period", "only y-min and y-max may be periodic in "
        "axisymmetry", "axis"),
    Exclusion(g.absorbing, f.axisymmetric,
        "absorbing is for plane waves, and along the radius waves are none:",
        "take slip or leave it open, farther away; y-min and y-max may absorb", "axis"),
    Exclusion(g.turning, f.axisymmetric,
        "what is turned in the plane of radius and axis is no ring any more, and a rotation about "
        "the axis (swirl) is no motion of this geometry", "leave it out", "axis"),
    Exclusion(g.inflow, f.axisymmetric,
        "rings that enter along the radius have other volumes layer by layer",
        "only along the axis y can they", "axis"),
    # Plane stress.
    Exclusion(f.plane_stress, f.not_plane,
        "plane-stress is for 2 dimensions, but the case has {b.name}"),
    Exclusion(f.mean, f.plane_stress,
        "mean is against locking, which plane stress does not have", "take pointwise"),
    Exclusion(f.not_across, f.plane_stress,
        "{a.name} is not known in plane stress", "hooke, neo-hookean and von-mises are"),
    Exclusion(g.stress, f.plane_stress,
        "has a part out of the plane", "take settle, or plane-strain"),
    Exclusion(g.packaged_exact, f.plane_stress, "is not known in plane stress", "leave it out"),
    Exclusion(g.level_gauges, f.plane_stress,
        "is for liquids and soils, which are never in plane stress", "leave it out"),
    # Method.
    Exclusion(f.mean, f.no_boxes,
        "mean is for particles that are boxes, whose parts in cells are known; {b.name} are none:",
        "take shape: gimp, finite-gimp or cpdi, or leave it out (pointwise)"),
    Exclusion(f.ordered, f.all_initial,
        "is for the current configuration; in the initial one, as of '{b.name}', vertices keep "
        "their velocities, and steps lose no energy:", "leave it out (last)"),
    Exclusion(f.ordered, f.mixed,
        "is for bodies that are all in the current configuration, but {b.name}",
        "leave it out (last)"),
    Exclusion(f.ordered, f.free_rigid,
        "the velocities of '{b.name}', which moves freely, follow from those of vertices before "
        "they are mapped", "give it a motion, rigid: {{velocity: ..}}, or leave this out (last)"),
    # The initial configuration.
    Exclusion(f.one_particle, f.initial_on_lattice,
        "bodies in the initial configuration, as '{b.name}', have hourglass modes with one "
        "particle along {a.name} directions of a cell: they strain no particle, and grow "
        "without end", "take 2 along all directions, or all but one"),
    Exclusion(g.exact, f.mixed, "is for bodies of one configuration, but {b.name}",
        "leave it out, or take one for all"),
    Exclusion(f.not_separable, f.mixed,
        "{a.name} is for bodies of one configuration, but {b.name}:", "take cpdi"),
    Exclusion(f.initial, f.liquid,
        "'{b.name}' flows, and keeps no deformation; the initial configuration is for solids:",
        "take updated-lagrangian", "owner"),
    Exclusion(g.holding, f.initial,
        "holds what comes against it; of bodies in the initial configuration, as '{b.name}', only "
        "unilateral does:",
        "take that, fixed, slip or {{velocity: ..}}, or formulation: updated-lagrangian"),
    Exclusion(g.outflow, f.all_initial,
        "bodies in the initial configuration, as '{b.name}', may leave the domain, and stay what "
        "they are", "leave it out"),
    Exclusion(f.initial_volume, f.initial,
        "is for the current configuration; in the initial one, as of '{b.name}', forces are "
        "computed from the initial volume and the first Piola-Kirchhoff stress, exactly:",
        "leave it out"),
    Exclusion(g.contact_forces, f.initial,
        "forces of contact act where bodies are, and frames show the grid of the start, as "
        "'{b.name}' is in the initial configuration", "the history has their sums"),
    Exclusion(g.wall_gauges, g.met_by_initial,
        "bodies in the initial configuration, as '{b.name}', meet {a.name} where they are, and not "
        "on their grid", "history.csv has the force, reaction.{a.name}", "owner"),
    Exclusion(f.initial_with_memory, g.stressed,
        "total-lagrangian begins undeformed, and the stress of '{a.name}' follows from the "
        "deformation:",
        "take updated-lagrangian, or hooke, or equilibrate in place of start.stress", "owner"),
    Exclusion(f.initial, g.entering,
        "the grid of the initial configuration moves with the body as it was at the start, and "
        "nothing can be added to it", "what enters takes formulation: updated-lagrangian", "owner"),
    Exclusion(g.recovered, f.in_current,
        "is for bodies in the initial configuration, whose particles keep their neighbours, but "
        "'{b.name}' is in the current one", "take stress"),
    Exclusion(f.averaged, f.of_points,
        "averaged is for particles with a size: points may leave a vertex of '{a.name}' hardly any "
        "mass", "take gimp, or lumped"),
    # Bodies exact to their surface.
    Exclusion(f.exact_surface, f.whole_beside_current,
        "is for all bodies in the initial configuration, if others are in the current one, but "
        "'{b.name}' is whole:", "take surface: cut-particles for both"),
    *(
        Exclusion(f.exact_surface, feature, f"{why}:", "take surface: cut-particles")
        for feature, why in (
            (f.beyond_cells, "is for particles that are points or boxes in cells, not {b.name}"),
            (f.points, "needs a surface, and '{b.name}', of particles from a file, has none"),
        )
    ),
    # What is wider than cells moves more than the surface of a body.
    Exclusion(f.beyond_cells, f.meetings_by_surfaces,
        "{a.name} reach beyond the surfaces by which all bodies here meet ({b.name}):",
        "take gimp; in the initial configuration it is as accurate for its cost"),
    # Periodic faces.
    Exclusion(f.initial_not_uniform, g.periodic,
        _PERIODIC + "where the vertices of bodies in the initial configuration begin at one "
        "velocity, [..]", "take formulation: updated-lagrangian"),
    Exclusion(g.profiles, g.periodic, _PERIODIC + "where this coordinate would jump",
        "take a direction along these faces, or a longer domain without periodic faces", "axis"),
    Exclusion(g.at_ends, g.periodic, "{a.name} is on a periodic face, behind which it may go on",
        "a body with an end there begins within the domain", "axis"),
    Exclusion(g.body_force, g.periodic,
        _PERIODIC + "but this force depends on the position, and would jump there", "take gravity"),
    Exclusion(g.turning, g.periodic,
        "the domain is periodic along {b.axis}: each of its copies would turn about a centre of "
        "its own", "only a rotation about {b.axis} is the same for all", "axis"),
    Exclusion(g.inflow, g.periodic,
        "along {b.axis} the domain is periodic: what enters would come back into the inflow",
        "take open faces there", "axis"),
    Exclusion(g.water, g.periodic,
        "has a level along {b.axis}, where the domain is periodic", "leave one out", "axis"),
    Exclusion(g.outlet, g.conditions,
        "{a.name} has a condition (boundaries), through which nothing is to leave",
        "remove one of the two", "owner"),
)  # fmt: skip
