"""Columns of history.csv for errors, where the solution is known exactly."""

from __future__ import annotations

import numpy as np

from pgimp.kernels.sums.errors import DISPLACEMENT, STRESS, STRESS_VOLUME, VELOCITY
from pgimp.solver.history.totals import Column, Group

ERRORS = (
    Group(lambda scene: [""] if scene.settings.exact else [], (
        Column("error", "1",
            "only with `exact`, as all that follows: error of the stress, the sum of |exact - s| "
            "times volume over the particles, over the initial volume times a reference stress: "
            "the column's weight, the stress behind the shock",
            lambda s, _: s.mean(STRESS_VOLUME) / s.reference_stress()),
        Column("error.displacement-l2", "length",
            "root of the mean square error of the displacement, by initial volume",
            lambda s, _: np.sqrt(s.mean(DISPLACEMENT))),
        Column("error.displacement-max", "length",
            "greatest error of the displacement of a particle",
            lambda s, _: s.greatest[DISPLACEMENT]),
        Column("error.velocity-l2", "length/time", "as for the displacement",
            lambda s, _: np.sqrt(s.mean(VELOCITY))),
        Column("error.velocity-max", "length/time", "as for the displacement",
            lambda s, _: s.greatest[VELOCITY]),
        Column("error.stress-l2", "stress",
            "as for the displacement, of the Cauchy stress (Frobenius norm)",
            lambda s, _: np.sqrt(s.mean(STRESS))),
        Column("error.stress-max", "stress", "as for the displacement, of the Cauchy stress",
            lambda s, _: s.greatest[STRESS]),
    )),
)  # fmt: skip
"""Columns in scenes with an exact solution."""
