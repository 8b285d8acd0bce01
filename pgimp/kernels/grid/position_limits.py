"""Faces that hold particles in.

The grid's velocity at a wall is zero only where all the weight is on vertices that the wall holds.
A particle wider than a point has some on the vertices inside, so that material
that flows along a wall, or is pressed against it, creeps through: by a millionth of a cell, or more
where particles stretch. Such a particle is moved back onto the wall, and its velocity into the wall
becomes the wall's, as in an inelastic impact. Its loss is the wall's impulse and work.
"""

from math import isfinite

from pgimp.jit.kernel import inner_kernel, specialise

#: Columns of `walls`: the face's number or -1, the coordinate to which particles are moved, the
#: wall's velocity, and gravity across it; the number whether it holds in or not, whether it holds
#: every component, and the three of its velocity.
FACE, PLACE, VELOCITY, GRAVITY, NUMBER, HOLDS, MOTION, WALL = 0, 1, 2, 3, 4, 5, 6, 9


def prescribed_by(constraints, number, d):
    """Whether constraint `number`, from 1, prescribes component `d`; 0 is no constraint."""


@specialise(prescribed_by)
def _prescribed_by(constraints, number, d):
    if len(constraints) == 0:
        return lambda constraints, number, d: False
    return lambda constraints, number, d: number > 0 and constraints[number - 1].held[d]


@inner_kernel
def free_part(constraints, particles, p, n):
    """The components of `n` that no constraint prescribes for a particle."""
    number = particles.constraint[p, 0] if particles.constraint.shape[1] > 0 else 0
    return (
        0.0 if prescribed_by(constraints, number, 0) else n[0],
        0.0 if prescribed_by(constraints, number, 1) else n[1],
        0.0 if prescribed_by(constraints, number, 2) else n[2],
    )


@inner_kernel
def hold_inside(walls, frame, constraints, particles, p, impulse, work):
    """Move a particle that has passed walls back onto them.

    Parameters
    ----------
    walls : (6, WALL) float64
        For each face, x-min to z-max: its number among those with a condition, or -1 if it holds
        nothing in; the coordinate to which it moves particles; its velocity along the normal; the
        component of gravity along that axis.
    constraints : tuple of Constraint
        Constraints; a particle moves as its constraint says, also through a wall.
    impulse : (faces, 3) float64
        Grows by the walls' impulses.
    work : (1,) float64
        Grows by their work, and by that of gravity over the correction.

    Returns
    -------
    int
        1 if the particle was changed, else 0.
    """
    held = 0
    for d in range(len(frame.origin)):
        xi = (particles.x[p, d] - frame.origin[d]) * frame.inverse[d]
        if not isfinite(xi) or (xi >= 0.0 and xi <= frame.cells[d]):
            continue
        wall = walls[2 * d + (xi > 0.0)]
        number = particles.constraint[p, 0] if particles.constraint.shape[1] > 0 else 0
        if wall[FACE] < 0.0 or prescribed_by(constraints, number, d):
            continue
        held = 1
        work[0] += particles.m[p] * wall[GRAVITY] * (wall[PLACE] - particles.x[p, d])
        particles.x[p, d] = wall[PLACE]
        change = wall[VELOCITY] - particles.v[p, d]
        if change < 0.0 if xi > 0.0 else change > 0.0:
            particles.v[p, d] = wall[VELOCITY]
            change *= particles.m[p]
            impulse[int(wall[FACE]), d] += change
            work[0] += change * wall[VELOCITY]
    return held
