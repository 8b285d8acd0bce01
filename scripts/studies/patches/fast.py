"""Bodies that meet fast: whether energy and momentum stay, and whether they cross."""

import numpy as np
from studies.patches.hard import greatest, watched
from studies.patches.impacts import SOLID, C, energy, exact
from studies.patches.pressed import turned
from studies.scenes import ball, box, case_of, core


def fast(R=6.0, v=0.15, shape="disk"):
    """Bodies meet at 2 v in wave speeds: energy, momentum, depth, whether they have crossed."""
    one = np.array([R + 3.13, R + 5.21])
    other = np.add(one, [2.0 * R + 0.5, 0.3 * R])
    regions = [ball(c, R) if shape == "disk" else box(c - R, c + R) for c in (one, other)]
    if shape == "square":
        regions[1] = turned(np.add(other, [0.6 * R, 0.0]), [2.0 * R] * 2, 20.0)[0]
    bodies = {"a": exact(regions[0], [v * C, 0.0]), "b": exact(regions[1], [-v * C, 0.0])}
    sim = core(case_of([6.0 * R + 8.0, 3.0 * R + 12.0], 1.0, {"solid": SOLID}, bodies,
                       (2.0 / v + 8.0 * R) / C,
                       contact=[{"bodies": ["a", "b"], "friction": 0.3}]))  # fmt: skip
    first, deepest, lines = watched(sim, 1)
    L = lines[-1]["angular-momentum-z"] - first["angular-momentum-z"]
    scale = first["body.a.momentum-x"]
    return {
        "depth": round(deepest, 4), "energy": round(energy(lines[-1]) / energy(first), 4),
        "most": round(greatest(lines) / energy(first), 6),
        "a": lines[-1]["body.a.momentum-x"] / scale,
        "momentum": abs(lines[-1]["momentum-x"] - first["momentum-x"]) / scale,
        "spin": abs(L) / (scale * R),
    }  # fmt: skip
