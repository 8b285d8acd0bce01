"""Where rigid bodies are known: beyond the domain large ones end some cells away from it."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from pgimp.errors import EndlessError
from pgimp.kernels.contact.lagrangian.filled import NEVER
from pgimp.kernels.rigid.bodies import AnyRigidBodies
from pgimp.physics.contact.pairs import Pairs
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.bonds import interactions
from pgimp.solver.time.clock import Step


def lost_body(
    scene: Scene,
    pairs: Pairs,
    groups: np.ndarray,
    around: tuple[np.ndarray, np.ndarray],
    rigid_bodies: AnyRigidBodies,
) -> tuple[str, str] | None:
    """Names of a body, and of a rigid one near it whose distance is not known there; or None.

    Parameters
    ----------
    groups : (bodies,) int64
        The groups of bonded bodies.
    around : (groups, D) float64, twice
        Ends of what groups may reach soon, in cells from the grid's origin.
    rigid_bodies : RigidBodies or ()
        The rigid bodies at their positions.
    """
    every, frame, D = scene.interaction.rigid_bodies, scene.domain.frame, scene.dimension
    inverse, (low, high) = np.array(frame.inverse), around
    for t, (field, ends) in enumerate(zip(every.fields, every.ends, strict=True)):
        assert rigid_bodies
        far = field.low + field.spacing * (field.shape - 1)
        if (field.low[:D] <= ends[0]).all() and (ends[1] <= far[:D]).all():
            continue  # one that turns, too
        motion = rigid_bodies.motion[t]
        way = (motion["centre"] - motion["reference"])[:D] - frame.origin
        known = (np.array([field.low[:D], far[:D]]) + way) * inverse
        whole = (ends + way) * inverse
        first, last = np.maximum(low, whole[0]), np.minimum(high, whole[1])
        beyond = ((first < known[0]) | (last > known[1])) & (scene.domain.periods == 0.0)
        lost = (first <= last).all(axis=1) & beyond.any(axis=1)
        if lost.any():
            lost &= interactions(pairs, groups, len(every))[:, len(lost) + t] != NEVER
        for group in np.flatnonzero(lost)[:1]:
            return scene.body_names[int(np.flatnonzero(groups == group)[0])], every.names[t]
    return None


def refuse(lost: tuple[str, str], done: Step) -> NoReturn:
    """End a run in which a body has come to where a rigid one is not known, see `lost_body`.

    Raises
    ------
    EndlessError
        Always.
    """
    body, rigid = lost
    raise EndlessError(
        f"at time {done.end:.6g}, after step {done.number}, '{body}' comes to a part of the rigid "
        f"'{rigid}' so far beyond the domain that its surface is not known there\n"
        "  try: a larger grid, which costs nothing where it is empty, an earlier time.end, or a "
        f"smaller region of '{rigid}'"
    )
