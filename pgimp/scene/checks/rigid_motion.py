"""Warnings of rigid bodies: fast, through a plane of symmetry, without a load, on an axis.

And notes on those that are known in part.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.rigid import Motion
from pgimp.scene.checks.warned import Warned, warned
from pgimp.scene.faces import Face
from pgimp.scene.rigid.rigid import SceneRigidBodies
from pgimp.scene.wave_speeds import wave_speed

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

#: Fraction of the wave speed above which a prescribed rigid body is fast. On cells of
#: a twelfth of the block, rubber hit at half the wave speed gets some per cent too little momentum.
#: At 2.7 times the wave speed it gets half of it.
_FAST = 0.3

#: Instants of a stage at which bodies are examined. Least depth in cells beyond a plane; least
#: depth in the domain, where the body no longer pushes the plane's vertices. Part of the greatest
#: speed that counts as rounding.
_INSTANTS, _BEYOND, _WITHIN, _STILL = 100, 0.05, 1.0, 1e-9

#: Distance of a section from the axis, in cells, from which it has a hole.
_ON_AXIS = 0.25


def motion_warnings(scenes: Sequence[Scene]) -> list[Warned]:
    """Return warnings of rigid bodies that are too fast for the material, or miss a load.

    Parameters
    ----------
    scenes : sequence of Scene
        The scenes of all stages; in the first the rigid bodies are measured.
    """
    scene = scenes[0]
    if not scene.interaction.rigid_bodies:
        return []
    found = _edges_on_axis(scene)
    for key in ("body-force", "water"):
        if not scene.interaction.rigid_bodies.free:
            break
        if not any(getattr(each.case, key.replace("-", "_")) for each in scenes):
            continue
        names = ", ".join(f"'{body.name}'" for body in scene.interaction.rigid_bodies.free.values())
        text = (
            f"{key}: it acts on bodies of a material only, not on {names}, which moves freely "
            "by gravity and contact alone"
        )
        found.append(warned("free-load", text))
    first = len(scene.body_names)
    waves = [wave_speed(scene, body) for body in range(first)]
    for number, speed in scene.interaction.rigid_bodies.speeds().items():
        met = [
            (waves[body], scene.body_names[body])
            for body in range(first)
            if scene.interaction.pairs is None
            or scene.interaction.pairs.entry[body, first + number] != 0
        ]
        slowest, name = min(met, default=(inf, ""))
        if speed > _FAST * slowest > 0.0:
            text = (
                f"bodies.{scene.interaction.rigid_bodies.names[number]}.rigid: "
                f"it moves at up to {speed:.3g}, {speed / slowest:.2g} times as fast as "
                f"waves in '{name}' ({slowest:.3g}); above "
                f"{_FAST:g} what it hits gets too little momentum, beyond 1 half of it or less: "
                "smaller cells (grid.cell), or a body that moves freely (rigid: {density: ..}); "
                "are the units of velocity, young and density one set?"
            )
            found.append(warned("fast-rigid", text))
    return found + _through_planes(scenes)


def known_in_part(scene: Scene) -> Iterator[str]:
    """Yield a note on each rigid body whose surface is known only so far beyond the domain.

    That is as far as the domain is long, see `pgimp.solver.contact.surfaces.table`. Bodies in the
    initial configuration may come farther.

    Parameters
    ----------
    scene : Scene
        Its rigid bodies are measured.
    """
    case, every, pairs = scene.case, scene.interaction.rigid_bodies, scene.interaction.pairs
    if pairs is None:
        return
    D, first = scene.dimension, len(scene.body_names)
    initial = np.array([body.formulation == "total-lagrangian" for body in case.bodies.values()])
    closed = np.asarray(scene.domain.periods) > 0.0
    domain = np.array([case.grid.origin, case.grid.corner])
    times = np.linspace(0.0, case.time.end, _INSTANTS)
    size = domain[1] - domain[0]
    known = np.array([domain[0] - size, domain[1] + size])
    for number, ends in enumerate(every.ends):
        short = np.array([ends[0] < known[0], ends[1] > known[1]]) & ~closed
        if not (short.any() and (initial & (pairs.entry[:first, first + number] != 0)).any()):
            continue
        motion = every.entries[number].rigid
        ways = [motion.displacement(t)[:D] for t in times] if isinstance(motion, Motion) else [0.0]
        beyond = np.min(
            [[domain[0] - known[0] - way, known[1] + way - domain[1]] for way in ways], 0
        )
        side, axis = np.unravel_index(np.where(short, beyond, inf).argmin(), short.shape)
        yield (
            f"bodies.{every.names[number]}.region: it is large, and known only to "
            f"{beyond[side, axis]:.3g} beyond the domain at {'xyz'[axis]}-{('min', 'max')[side]}; "
            "a body in the initial configuration that comes farther does not meet it: a larger "
            "grid costs nothing where it is empty, or end the region where nothing comes"
        )


def _edges_on_axis(scene: Scene) -> list[Warned]:
    """Warnings of bodies whose section ends on the axis, or less than a cell beyond it."""
    bodies = scene.interaction.rigid_bodies
    if not scene.case.axisymmetric or bodies.by_surfaces:
        return []
    found, cell = [], scene.case.grid.cell[0]
    for name, ends in zip(bodies.names, bodies.ends, strict=True):
        low, high = ends[:, 0].tolist()
        if -cell < low < _ON_AXIS * cell:
            text = (
                f"bodies.{name}.region: its section ends on the axis, where contact sees an edge; "
                "let it reach across by a cell or more, as a plane of symmetry is crossed: a box "
                f"from x = {-high:.6g} to {high:.6g}"
            )
            found.append(warned("axis-edge", text))
    return found


def _through_planes(scenes: Sequence[Scene]) -> list[Warned]:
    """Warnings of prescribed bodies that turn on `slip` walls, or move through them."""
    rigid_bodies = scenes[0].interaction.rigid_bodies
    found: dict[tuple[str, str], str] = {}
    for scene in scenes:
        times = np.linspace(scene.case.staged.start, scene.case.time.end, _INSTANTS)
        for face in scene.domain.faces:
            for number, name in enumerate(rigid_bodies.names):
                motion = rigid_bodies.entries[number].rigid
                moves = (
                    isinstance(motion, Motion)
                    and motion.moves
                    and name in scene.interaction.rigid_bodies.names
                )
                if moves and isinstance(face.condition, Slip) and (name, face.name) not in found:
                    if text := _conflict(rigid_bodies, number, face, times):
                        found[name, face.name] = text
    return [
        warned("through-plane", f"bodies.{name}.rigid: {text}") for (name, _), text in found.items()
    ]


def _conflict(
    rigid_bodies: SceneRigidBodies, number: int, face: Face, times: NDArray[np.float64]
) -> str:
    """Describe the conflict of a motion with a plane of symmetry; empty if there is none.

    A body may lie across it and move to and fro, as a piston: only its part within counts.
    """
    frame, motion, axis = rigid_bodies.frame, rigid_bodies.entries[number].rigid, face.axis
    assert isinstance(motion, Motion)
    cell, origin = np.array(frame.cell), np.array(frame.origin)
    corner = origin + cell * frame.cells
    D, plane = len(cell), (corner if face.side > 0 else origin)[axis]
    own = rigid_bodies.surface.points[rigid_bodies.surface.body == number] - motion.reference
    before = None
    for time in times.tolist():
        centre, turn = motion.pose(time)
        arm = own @ np.array(turn).reshape(3, 3).T
        x = (arm + centre)[:, :D]
        beside = np.delete((x >= origin - cell) & (x <= corner + cell), axis, 1).all(axis=1)
        if not beside.any():
            continue
        depth = face.side * (x[:, axis] - plane) / cell[axis]
        beyond, within = bool(depth.max() > _BEYOND), bool(depth.min() < -_WITHIN)
        # If a body turns across a plane, some points move in and others out.
        spin = np.array(motion.velocities(time)[1])
        turning = np.abs(np.cross(spin, arm)[:, axis]).max() > _STILL * np.abs(spin).max() * cell[0]
        if beyond and within and turning:
            return (
                f"it turns on the slip wall {face.name}, across which it lies at t = {time:.3g}: "
                "the wall holds what its surface takes along there, and as a plane of symmetry it "
                "has the body's other half turn the other way; end the body before the wall, or "
                "take another condition (boundaries)"
            )
        if before is not None and (beyond, within) != before and (beyond or before[0]):
            return (
                f"it moves through the slip wall {face.name} by t = {time:.3g}: the wall holds "
                "what it pushes there, and as a plane of symmetry it has the body's other half "
                "move the other way; let it lie across the wall or apart from it all the time, or "
                "take another condition (boundaries)"
            )
        before = beyond, within
    return ""
