"""The motion that is left where a run does not come to rest."""

from __future__ import annotations

import numpy as np

from pgimp.solver.rank_state import RankState

#: Part of a body's kinetic energy from which it moves as a whole.
WHOLE = 0.9


def what_moves(rank: RankState, cycle: float) -> str:
    """Describe the motion that is left, and what would end it; collective.

    Parameters
    ----------
    cycle : float
        Steps in half a period of the motion.
    """
    p, rows, names = rank.up_to_date(), rank.live(), rank.scene.body_names
    D = p.x.shape[1]
    m, v, body = p.m[rows], p.v[rows], p.body[rows]
    twice = m * (v * v).sum(axis=1)  # kinetic energy
    columns = np.column_stack([m, twice, m[:, None] * v, twice[:, None] * p.x[rows]])
    own = np.zeros((len(names), columns.shape[1]))
    np.add.at(own, body, columns)
    sums = np.add.reduce(rank.comm.allgather(own), axis=0)
    number = int(np.argmax(sums[:, 1]))
    mass, twice_most, *rest = sums[number].tolist()
    if not twice_most > 0.0:
        return "  nothing moves at this step"
    momentum = np.array(rest[:D])
    part = 100.0 * twice_most / sums[:, 1].sum()
    text = f"  what still moves is '{names[number]}', with {part:.0f} % of the kinetic energy"
    if momentum @ momentum > WHOLE * mass * twice_most:
        along = int(np.argmax(np.abs(momentum)))
        sign = "-" if momentum[along] < 0.0 else "+"
        return (
            f"{text}, as a whole along {sign}{'xyz'[along]}: hold it by boundaries, constraints or "
            "contact, or balance its loads"
        )
    place = ", ".join(f"{x / twice_most:.4g}" for x in rest[D:])
    return (
        f"{text}, most of it near ({place}), back and forth in about {2.0 * cycle:.0f} steps "
        "or more: look there for what yields or flows under loads that no rest can bear, for parts "
        "that hold to the body by less than a cell, and for contact that opens and closes; "
        "a liquid flows on under the unevenness of its particles"
    )
