"""Two blocks of materials of which some remember."""

from scenes import box, scene

SOFTENING = {"model": "softening", "young": 100.0, "poisson": 0.3, "density": 1.0} | {
    "damage": 0.9, "toughness": 1.0,
}  # fmt: skip


RUBBER = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}


def two_blocks(dimension=2, **parts):
    """A block that softens hits one of rubber; both cross cells and slabs, and leave."""
    rest = [1.0] * (dimension - 1)
    case = scene(
        dimension,
        box([1.0, *rest], [4.0, *(3.0 for _ in rest)], [4.0, *(0.3 for _ in rest)]),
        cells=[12, 4, 4][:dimension],
        end=0.8,
        step={"courant": 0.3},
        **parts,
    )
    case["materials"] = {"hard": RUBBER, "soft": SOFTENING}
    other = {"box": {"min": [4.5, *rest], "max": [7.0, *(3.0 for _ in rest)]}}
    case["bodies"]["other"] = {"material": "hard", "region": other}
    case["boundaries"] = {"x-max": "fixed"}
    case["output"] = {"every": {"steps": 1}, "fields": ["deformation", "damage", "peak-energy"]}
    case["probes"] = {
        "own": {"body": "body", "at": [3.5, *rest], "every": {"steps": 1}},
        "none": {"body": "other", "at": [5.0, *rest], "every": {"steps": 1}},
    }
    case["checkpoint"] = {"every": {"steps": 5}, "keep": 50}
    return case
