"""Rebounds of rigid bodies: velocities to part with, by restitution, before impulses are solved.

Pairs that close in the step are hit at once, and push only: the least change of velocities, in the
norm of the kinetic energy, after which none of them closes. The change times 1 + e is applied. Then
the pairs that close now are hit, until none does: an impact goes on from body to body, as in
Newton's cradle. With e = 1 each of these reflections keeps the energy, with less they lose some:
Smith, Kaufman, Vouga, Tamstorf and Grinspun, Reflections on simultaneous impact, ACM Trans. Graph.
31, 106 (2012).

The velocities at which pairs part are bounds of the sweeps, which add weight, friction and whatever
else there is.
"""

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.data import impulse_of
from pgimp.kernels.rigid.bodies import arm_of, lever

#: Impacts one after the other in a step, at most; sweeps over the pairs of one, and the change over
#: the velocity of the impact that ends them.
IMPACTS, SWEEPS, EXACT = 256, 400, 1e-12

#: Change of velocity in the step by forces, times this: what closes more slowly is at rest.
SLOW = 4.0

#: Least velocity of an impact over the greatest one in the step.
LEAST = 1e-9

#: Columns of the scratch for pairs: inverse mass along the normal, velocity at which a pair closes
#: at least to be hit, impulse of one impact, of all.
_ANSWER, _CLOSES, _ONE, _ALL = range(4)
COLUMNS = 4


@inner_kernel
def _free_number(rigid_bodies, s):
    """Number of a rigid end among the free bodies; -1 of others. `s` is as in `load_rigid`."""
    t = -1 - s - rigid_bodies.bodies
    return rigid_bodies.lattice[t].free if t < len(rigid_bodies.lattice) else -1


@inner_kernel
def are_rigid(end):
    """Whether both ends of a pair are rigid."""
    return end.rows[0] < 0 and end.rows[1] < 0


@inner_kernel
def _speed(rigid_bodies, contact_pairs, k, V):
    """Velocity at which pair `k` parts along its normal; `V`, (free bodies, 6), are the bodies'."""
    end, rigid, found = contact_pairs.ends[k], contact_pairs.rigid[k], 0.0
    for side in range(2):
        n, sign = _free_number(rigid_bodies, end.rows[side]), 2.0 * side - 1.0
        if n < 0:
            for d in range(3):
                found += sign * contact_pairs.states[k].normal[d] * rigid[side, d]
            continue
        arm = arm_of(rigid_bodies, -1 - end.rows[side] - rigid_bodies.bodies, rigid[2])
        for d in range(3):
            for u in range(6):
                found += sign * contact_pairs.states[k].normal[d] * lever(arm, d, u) * V[n, u]
    return found


@inner_kernel
def _push(rigid_bodies, contact_pairs, k, J, V):
    """Apply an impulse along the normal of pair `k`; returns the pair's velocity per impulse."""
    end, rigid, answer = contact_pairs.ends[k], contact_pairs.rigid[k], 0.0
    normal = contact_pairs.states[k].normal
    for side in range(2):
        n, sign = _free_number(rigid_bodies, end.rows[side]), 2.0 * side - 1.0
        if n < 0:
            continue
        arm = arm_of(rigid_bodies, -1 - end.rows[side] - rigid_bodies.bodies, rigid[2])
        C = rigid_bodies.responses[0, n].derivative
        for u in range(6):
            own = 0.0
            for w in range(6):
                given = 0.0
                for d in range(3):
                    given += lever(arm, d, w) * normal[d]
                own += C[u, w] * given
            V[n, u] += sign * J * own
            for d in range(3):
                answer += normal[d] * lever(arm, d, u) * own
    return answer


@inner_kernel
def _hit(rigid_bodies, contact_pairs, V, scratch, fastest):
    """Hit all pairs that close, without rebound: sets their impulses; returns how many there are.

    Those that close more slowly than `fastest` times `LEAST` are not hit. The velocities change.
    """
    hit = 0
    for k in range(len(contact_pairs.ends)):
        scratch[k, _ONE] = -1.0
        if not are_rigid(contact_pairs.ends[k]) or not scratch[k, _ANSWER] > 0.0:
            continue
        closing = -_speed(rigid_bodies, contact_pairs, k, V)
        if closing > max(scratch[k, _CLOSES], LEAST * fastest):
            scratch[k, _ONE] = 0.0
            hit += 1
    for _ in range(SWEEPS if hit > 0 else 0):
        change = 0.0
        for k in range(len(contact_pairs.ends)):
            if scratch[k, _ONE] < 0.0:
                continue
            v = _speed(rigid_bodies, contact_pairs, k, V)
            J = max(0.0, scratch[k, _ONE] - v / scratch[k, _ANSWER]) - scratch[k, _ONE]
            scratch[k, _ONE] += J
            _push(rigid_bodies, contact_pairs, k, J, V)
            change = max(change, abs(J) * scratch[k, _ANSWER])
        if not change > EXACT * fastest:
            break
    return hit


@inner_kernel
def _begin(rigid_bodies, contact_pairs, V, scratch):
    """Set velocities to those before the step, and the scratch; returns the greatest velocity."""
    fastest = 0.0
    for after in range(2):
        for t in range(len(rigid_bodies.lattice)):
            n, motion = rigid_bodies.lattice[t].free, rigid_bodies.motion[t]
            if n >= 0:
                for u in range(6):
                    V[n, u] = motion.velocity_before[u] if after else motion.velocity_after[u]
        for k in range(len(contact_pairs.ends)):
            if not are_rigid(contact_pairs.ends[k]):
                continue
            v = _speed(rigid_bodies, contact_pairs, k, V)
            if not after:
                scratch[k, _CLOSES] = v
                continue
            fastest = max(fastest, abs(v))
            forces = abs(scratch[k, _CLOSES] - v)
            gap = contact_pairs.states[k].gap_rate
            scratch[k, _CLOSES] = max(SLOW * forces, gap - forces)
            scratch[k, _ANSWER], scratch[k, _ALL] = 0.0, 0.0
            scratch[k, _ANSWER] = _push(rigid_bodies, contact_pairs, k, 0.0, V)
    return fastest


@kernel
def find_rebounds(rigid_bodies, contact_pairs, restitution, V, scratch) -> int:
    """Find the velocities at which rigid bodies part that hit each other; returns how many pairs.

    Parameters
    ----------
    rigid_bodies : RigidBodies
        With velocities before the step, and after it without impulses.
    contact_pairs : ContactPairs
        `gap_rate` of pairs that are hit becomes minus the velocity at which they are to part.
    restitution : (entries,) float64
        Coefficient of restitution of each law.
    V : (free bodies, 6) float64
        Scratch.
    scratch : (pairs, COLUMNS) float64
        Scratch.
    """
    fastest, found = _begin(rigid_bodies, contact_pairs, V, scratch), 0
    for _ in range(IMPACTS):
        if _hit(rigid_bodies, contact_pairs, V, scratch, fastest) == 0:
            break
        for k in range(len(contact_pairs.ends)):
            if scratch[k, _ONE] > 0.0:
                e = restitution[contact_pairs.ends[k].law - 1]
                _push(rigid_bodies, contact_pairs, k, e * scratch[k, _ONE], V)
                scratch[k, _ALL] += (1.0 + e) * scratch[k, _ONE]
    for k in range(len(contact_pairs.ends)):
        if are_rigid(contact_pairs.ends[k]) and scratch[k, _ALL] > 0.0:
            contact_pairs.states[k].gap_rate = -_speed(rigid_bodies, contact_pairs, k, V)
            found += 1
    return found


@kernel
def find_gains(rigid_bodies, contact_pairs, gains):
    """Find the energy that impulses of rigid pairs give; below 0 what they take.

    Parameters
    ----------
    rigid_bodies : RigidBodies
        With velocities before the step, and after it.
    contact_pairs : ContactPairs
        With their impulses.
    gains : (2, pairs) float64
        Set here; 0 of other pairs. The second row is half the sizes of power before and after.
    """
    for k in range(len(contact_pairs.ends)):
        end, rigid, row = contact_pairs.ends[k], contact_pairs.rigid[k], contact_pairs.states[k]
        before, after = 0.0, 0.0
        for side in range(2 if are_rigid(end) else 0):
            n, sign = _free_number(rigid_bodies, end.rows[side]), 2.0 * side - 1.0
            t = -1 - end.rows[side] - rigid_bodies.bodies
            for d in range(3):
                J = sign * impulse_of(row, d)
                if n < 0:
                    before, after = before + J * rigid[side, d], after + J * rigid[side, d]
                    continue
                arm, motion = arm_of(rigid_bodies, t, rigid[2]), rigid_bodies.motion[t]
                for u in range(6):
                    before += J * lever(arm, d, u) * motion.velocity_before[u]
                    after += J * lever(arm, d, u) * motion.velocity_after[u]
        gains[0, k] = 0.5 * (before + after)
        gains[1, k] = 0.5 * (abs(before) + abs(after))
