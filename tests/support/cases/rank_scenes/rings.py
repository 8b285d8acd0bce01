"""Axisymmetric scenes: rings that cross slabs as they grow, bars, contact, rigid bodies."""

from scenes import SOFT, box, scene

from pgimp.physics.columns import SURFACE
from rank_scenes.entries import EVERYTHING, STIFF
from rank_scenes.initial_bodies import within
from rank_scenes.laws import METALS


def rings():
    """A bar hits a floor, a loaded ring grows across slabs, a gas expands; friction, a stamp."""
    gas = {"model": "ideal-gas", "gamma": 1.4, "energy": 4.0, "density": 0.5}
    bodies = {
        "bar": box([0.0, 1.6], [2.1, 5.0], [0.0, -6.0]),
        "ring": box([6.1, 2.0], [7.9, 3.2], [0.0, -2.0], "rubber"),
        "seat": box([5.0, 0.0], [9.0, 1.3], None, "stiff"),
        "gas": box([11.0, 1.0], [13.0, 3.0], [0.0, 1.0], "gas"),
        "stamp": {
            "rigid": {"velocity": [0.0, -1.5]},
            "region": {"ball": {"center": [0.0, 9.0], "radius": 3.3}},
        },
    }
    case = scene(
        2,
        bodies,
        cells=[18, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=METALS | {"rubber": SOFT, "stiff": STIFF, "gas": gas},
        gravity=[0.0, -2.0],
        boundaries={"y-min": "unilateral", "x-max": "slip"},
        escape={"y-max": "remove"},
        contact=[{"bodies": "all", "friction": 0.3}],
        tractions={
            "bore": {"body": "ring", "face": "x-min", "pressure": {"table": [[0, 0], [0.2, 15]]}},
            "lid": {"body": "ring", "face": "y-max", "traction": [0.0, -1.0]},
        },
        output={"every": 0.25, "fields": EVERYTHING, "grid": ["mass", "force", "contact"]},
        history={"every": {"steps": 10}},
        probes={"place": {"place": [0.4, 1.0]}, "rim": {"body": "bar", "at": [2.0, 2.0]}},
    )
    case["geometry"], case["method"]["affine"] = "axisymmetric", True
    return case


def rings_free():
    """A rigid disk falls freely onto a bar and presses it; another one flies past a ring's bore."""
    bodies = {
        "bar": box([0.0, 0.0], [4.1, 3.0], None, "rubber"),
        "ring": box([9.0, 3.0], [12.0, 5.0], [0.0, 2.0], "rubber"),
        "disk": {
            "rigid": {"density": 3.0},
            "region": box([-5.0, 3.2], [5.0, 4.4])["region"],
            "velocity": [0.0, -2.0],
        },
        "plug": {
            "rigid": {"density": 0.5},
            "region": {"ball": {"centre": [10.5, 7.0], "radius": 1.2}},
            "velocity": [0.0, -3.0],
        },
    }
    case = scene(
        2,
        bodies,
        cells=[16, 10],
        end=1.0,
        step={"courant": 0.3},
        materials={"rubber": SOFT},
        gravity=[0.0, -2.0],
        boundaries={"x-min": "slip", "y-min": "unilateral"},
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": 0.25, "fields": EVERYTHING, "grid": ["mass", "contact"]},
        history={"every": {"steps": 10}},
    )
    case["geometry"] = "axisymmetric"
    return case


def rings_initial():
    """A bar and a loaded tube in the initial configuration; one yields, one is held."""
    bodies = {
        "bar": box([0.0, 0.0], [2.1, 3.4], [0.0, -3.0]),
        "tube": box([5.1, 1.0], [7.9, 6.2], [0.0, 1.0], "rubber"),
    }
    case = scene(
        2,
        bodies,
        cells=[12, 8],
        end=1.0,
        step={"courant": 0.3},
        materials={"soft": METALS["soft"], "rubber": SOFT},
        gravity=[0.0, -2.0],
        boundaries={"y-min": "slip"},
        tractions={"bore": {"body": "tube", "face": "x-min", "pressure": 8.0}},
        constraints={
            "grip": {
                "body": "tube", "region": {"half-space": {"point": [0, 5.4], "normal": [0, -1]}},
                "velocity": [None, 0.5],
            }
        },
        output={"every": 0.25, "fields": EVERYTHING, "grid": ["mass", "velocity"]},
        history={"every": {"steps": 10}},
        probes={"rim": {"body": "bar", "at": [2.0, 2.0]}},
    )  # fmt: skip
    case["geometry"] = "axisymmetric"
    for body in bodies.values():
        body["formulation"] = "total-lagrangian"
    return case


def rings_initial_contact():
    """In the initial configuration, with means: bars and a tube meet, rigid disks press them."""
    bodies = {
        "bar": box([0.0, 0.6], [2.1, 3.4], [0.0, -3.0]),
        "lid": box([0.0, 3.4], [1.6, 5.0], [0.0, -4.0], "rubber"),
        "tube": box([5.1, 0.0], [7.9, 5.2], None, "rubber"),
        "sleeve": box([7.9, 1.0], [9.0, 4.0], [0.0, 2.0]),
    }
    for body in bodies.values():
        body["formulation"] = "total-lagrangian"
    bodies["stamp"] = {
        "rigid": {"velocity": [0.0, -1.5]},
        "region": {"ball": {"center": [6.5, 7.3], "radius": 2.0}},
    }
    bodies["disk"] = {
        "rigid": {"density": 3.0},
        "region": box([-2.0, 5.2], [2.0, 6.4])["region"],
        "velocity": [0.0, -2.0],
    }
    case = scene(
        2,
        bodies,
        cells=[12, 10],
        end=1.0,
        step={"courant": 0.3},
        materials={"soft": METALS["soft"], "rubber": SOFT},
        gravity=[0.0, -2.0],
        boundaries={"y-min": "unilateral"},
        contact=[{"bodies": "all", "friction": 0.3}],
        tractions={"bore": {"body": "tube", "face": "x-min", "pressure": 8.0}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": ["mass", "velocity"]},
        history={"every": {"steps": 10}},
    )
    case["geometry"], case["method"]["volumetric"] = "axisymmetric", "mean"
    return case


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
    bodies = {
        name: body | {"formulation": "total-lagrangian", "surface": "exact"}
        for name, body in bodies.items()
    }
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
    tied = [{"bodies": "all", "friction": 0.1}, {"bodies": ["tube", "sleeve"], "law": "tie"}]
    case["time"]["stages"] = [{"name": "grown", "end": 0.8, "contact": tied}]
    return case


def mixed_rings():
    """A current bar and tube meet initial ones, a rigid stamp, a free disk, and a floor.

    Frames have the loads of surfaces.
    """
    initial = {"formulation": "total-lagrangian"}
    bodies = {
        "bed": box([0.0, 0.0], [6.2, 1.9], None, "rubber"),
        "bar": box([0.0, 2.1], [2.13, 4.7], [0.0, -3.0]) | initial,
        "tube": box([3.1, 2.0], [4.97, 4.4], None, "rubber") | initial,
        "sleeve": box([5.07, 2.2], [7.0, 4.1], [0.0, -1.0], "rubber"),
        "disk": {"rigid": {"density": 3.0}, "velocity": [0.0, -4.0],
                 "region": box([-2.5, 5.3], [2.5, 6.4])["region"]},
        "stamp": {"rigid": {"velocity": [0.0, -1.5]},
                  "region": {"ball": {"center": [5.5, 6.1], "radius": 1.83}}},
    }  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[12, 9],
        end=0.8,
        step={"courant": 0.3},
        materials={"soft": METALS["soft"], "rubber": SOFT},
        gravity=[0.0, -2.0],
        boundaries={"y-min": "unilateral"},
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": 0.2, "fields": EVERYTHING, "surface": [*SURFACE]},
        history={"every": {"steps": 10}},
    )
    case["geometry"], case["method"]["volumetric"] = "axisymmetric", "mean"
    return case
