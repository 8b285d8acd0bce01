"""Force of a liquid on what it surrounds: the weight of the liquid that the body displaces."""

import numpy as np
from studies.scenes import box, case_of, core

#: Gravity and density of the liquid.
PULL, LIQUID = 2.0, 0.7
BODIES = {
    "block, 2D": (box([2.2, 1.7], [6.1, 5.9]),),
    "disk of 5 cells, 2D": ({"ball": {"center": [4.1, 4.2], "radius": 2.53}},),
    "ball of 5 cells, 3D": ({"ball": {"center": [4.1, 4.2, 3.9], "radius": 2.53}},),
}


def error(region):
    """Error of the force at the start over the weight of the liquid."""
    D = len(next(iter(region.values())).get("center", [0, 0]))
    solid = {"model": "hooke", "young": 100.0, "poisson": 0.3, "density": 1.0}
    load = {"body": "b", "region": box([-1.0] * D, [20.0] * D),
            "hydrostatic": {"level": 8.0, "density": LIQUID}}  # fmt: skip
    case = case_of([9.0] * D, 1.0, {"m": solid}, {"b": {"material": "m", "region": region}}, 1.0,
                   gravity=[0.0] * (D - 1) + [-PULL], tractions={"sea": load})  # fmt: skip
    sim = core(case)
    before = sim.diagnostics()
    sim.advance()
    after = sim.diagnostics()
    lift = np.array([(after[f"momentum-{a}"] - before[f"momentum-{a}"]) / sim.dt
                     for a in "xyz"[:D]])  # fmt: skip
    weight = after["mass"] * PULL
    lift[-1] += weight - LIQUID * weight
    return float(np.abs(lift).max() / (LIQUID * weight))
