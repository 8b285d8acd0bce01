"""Position limits: faces that hold particles in.

The grid's velocity at a wall is zero only where the wall holds all vertices with weight. A particle
wider than a point has weight on the vertices inside. So material that flows along a wall, or is
pressed against it, creeps through. It creeps by a millionth of a cell, or more where particles
stretch. Such a particle is moved back onto the wall, and its velocity into the wall becomes the
wall's, as in an inelastic impact. Its loss is the wall's impulse and work.
"""

from math import isfinite

from pgimp.jit.kernel import inlined, inner_kernel

#: Columns of `walls`: number of the face or -1, coordinate to which particles are moved, velocity
#: of the wall, and gravity across it. Then number of the face in any case, whether it holds every
#: component, and its three velocity components.
FACE, COORDINATE, VELOCITY, GRAVITY, NUMBER, HOLDS, MOTION, WALL = 0, 1, 2, 3, 4, 5, 6, 9


@inlined
def prescribed_by(constraints, number, d):
    """Whether constraint `number`, from 1, prescribes component `d`; 0 is no constraint."""
    if len(constraints) == 0:
        return False
    return number > 0 and constraints[number - 1].held[d]


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
        For each face, x-min to z-max: its number among faces with a condition; -1 if it holds
        nothing in. Then the coordinate to which it moves particles; its normal velocity; the
        component of gravity along that axis.
    constraints : tuple of Constraint
        Constraints; a particle moves as its constraint says, also through a wall.
    impulse : (faces, 3) float64
        Grows by the walls' impulses.
    work : (1,) float64
        Grows by their work, and by the work of gravity over the correction.

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
        work[0] += particles.m[p] * wall[GRAVITY] * (wall[COORDINATE] - particles.x[p, d])
        particles.x[p, d] = wall[COORDINATE]
        change = wall[VELOCITY] - particles.v[p, d]
        if change < 0.0 if xi > 0.0 else change > 0.0:
            particles.v[p, d] = wall[VELOCITY]
            change *= particles.m[p]
            impulse[int(wall[FACE]), d] += change
            work[0] += change * wall[VELOCITY]
    return held
