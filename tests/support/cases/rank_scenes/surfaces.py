"""Rings, and bodies in periodic domains, that meet by their own surfaces."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING, GRID, PAIR
from rank_scenes.initial_bodies import within
from rank_scenes.laws import METALS

MORE = {"configuration": "initial", "surface": "exact"}


def surface_rings():
    """Bars, a ball and a tube meet across a seam and on a floor; a sleeve, rigid disks and a stamp.

    A stage ties the sleeve to the tube.
    """
    balls = [{"ball": {"centre": [0.0, y], "radius": 1.9}} for y in (0.3, 12.3)]
    bodies = {
        "bar": box([0.0, 2.6], [2.1, 5.43], [0.0, -3.0]),
        "ball": {"material": "rubber", "region": within([12.0, 12.0], *balls),
                 "velocity": [0.0, 2.0], "mass": "averaged"},
        "tube": box([5.1, 1.3], [7.88, 6.2], None, "rubber"),
        "sleeve": box([7.88, 2.0], [9.03, 4.4], [0.0, 2.0]),
    }  # fmt: skip
    bodies = {name: body | MORE for name, body in bodies.items()}
    stamp = {"ball": {"center": [6.5, 8.23], "radius": 2.0}}
    bodies["stamp"] = {"rigid": {"velocity": [0.0, -1.5]}, "region": stamp}
    bodies["disk"] = {"rigid": {"density": 3.0}, "velocity": [0.0, -3.0],
                      "region": box([-2.0, 5.6], [2.0, 6.7])["region"]}  # fmt: skip
    bodies["puck"] = {"rigid": {"density": 2.0}, "velocity": [0.0, -6.0],
                      "region": box([-1.0, 7.0], [1.0, 8.1])["region"]}  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[12, 12],
        end=0.5,
        step={"courant": 0.3},
        materials={"soft": METALS["soft"], "rubber": SOFT},
        gravity=[0.0, -2.0],
        boundaries={"y-min": "periodic", "y-max": "periodic"},
        contact=[{"bodies": "all", "friction": 0.3}],
        tractions={"bore": {"body": "tube", "face": "x-min", "pressure": 8.0}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": ["mass", "velocity"]},
        history={"every": {"steps": 10}},
    )
    case["geometry"] = "axisymmetric"
    tied = [{"bodies": "all", "friction": 0.1}, {"bodies": ["tube", "sleeve"], "law": "tied"}]
    case["time"]["stages"] = [{"name": "grown", "end": 0.8, "contact": tied}]
    return case


def surface_round():
    """Bodies meet through and beside seams: soft, rigid and free ones, and a plate from end to end.

    One is bonded to another across a seam, until a stage ends that.
    """
    balls = [{"ball": {"centre": [x, y], "radius": 1.9}} for x in (0.3, 18.3) for y in (0.4, 11.4)]
    bars = [
        {"box": {"min": [low, 4.02], "max": [high, 5.97]}} for low, high in ((0, 2.6), (13.9, 18))
    ]
    ends = [18.0, 11.0]
    bodies = {
        "bar": {"material": "soft", "region": within(ends, *bars), "velocity": [0.0, -1.0]},
        "disk": {"material": "stiff", "region": within(ends, *balls), "velocity": [2.0, 1.5],
                 "mass": "averaged"},
        "glued": box([2.6, 4.02], [5.03, 5.97], [0.0, -1.0]),
        "flies": box([9.2, 8.1], [11.7, 10.3], [7.0, 1.0], "stiff"),
    }  # fmt: skip
    bodies = {name: body | MORE for name, body in bodies.items()}
    plate = {"box": {"min": [-2.0, 6.7], "max": [20.0, 7.9]}}
    bodies["plate"] = {"rigid": {"velocity": [3.0, -0.7]}, "region": plate}
    bodies["puck"] = {"rigid": {"density": 2.0}, "velocity": [-3.0, 2.0],
                      "region": {"ball": {"center": [8.2, 2.2], "radius": 1.2}}}  # fmt: skip
    faces = ("x-min", "x-max", "y-min", "y-max")
    case = scene(
        2,
        bodies,
        cells=[18, 11],
        shape="finite-gimp",
        end=0.6,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries=dict.fromkeys(faces, "periodic"),
        contact=[{"bodies": "all", "friction": 0.3}, {"bodies": ["bar", "glued"], "law": "tied"}],
        output={"every": 0.3, "fields": [*EVERYTHING, "unwrapped"], "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [
        {"name": "loose", "end": 1.2, "contact": [{"bodies": "all", "friction": 0.3}]}
    ]
    return case
