"""Bodies that meet at rest by their surfaces: blocks on each other, and one that is folded."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING

EXACT = {"formulation": "total-lagrangian"}


def surface_blocks():
    """In 3D blocks of other lattices on each other, whose facets are joined; one tilts off."""
    tilts = {"rotation": {"about": [8.1, 3.0, 1.9], "rate": [0.1, 0.9, 0.0]}}
    bodies = {
        "base": box([2.03, 1.1, 0.0], [8.1, 4.9, 1.9]) | EXACT,
        "lies": box([2.4, 1.4, 1.9], [4.9, 4.4, 3.4]) | EXACT,
        "tilts": box([6.3, 1.3, 1.9], [9.6, 4.6, 3.9]) | EXACT | {"velocity": tilts},
    }
    return scene(
        3,
        bodies,
        cells=[14, 6, 6],
        end=0.9,
        step={"courant": 0.35},
        materials={"soft": SOFT | {"young": 200.0}},
        gravity=[0.0, 0.0, -4.0],
        boundaries={"z-min": {"unilateral": {"friction": 0.2}}},
        contact=[{"bodies": "all", "friction": 0.2}],
        output={"every": 0.3, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )


def surface_folded():
    """A plate folds a fork across slabs until its arms meet, and is taken off; it springs back."""
    whole, slot = ({"box": {"min": low, "max": high}} for low, high in (
        ([2.2, 0.0], [15.1, 5.5]), ([4.0, 1.6], [16.0, 3.7])))  # fmt: skip
    bodies = {
        "fork": {"material": "soft", "region": {"difference": [whole, slot]}} | EXACT,
        "plate": {"rigid": {"velocity": [0.0, -3.0]},
                  "region": {"box": {"min": [7.0, 5.52], "max": [20.0, 7.0]}}},
    }  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[18, 8],
        end=0.85,
        step={"courant": 0.35},
        boundaries={"y-min": {"unilateral": {"friction": 0.2}}},
        contact=[{"bodies": "all", "friction": 0.2}, {"bodies": ["fork"], "self": True}],
        output={"every": 0.4, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [{"name": "off", "end": 1.3, "remove": ["plate"]}]
    return case
