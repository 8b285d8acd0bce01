"""Bodies in the initial configuration."""

from pathlib import Path

from scenes import SOFT, box, scene

from pgimp.physics.columns import SURFACE
from rank_scenes.entries import EVERYTHING, GRID, PAIR, turning


def initial():
    """In the initial configuration: held, dragged, loaded and turning bodies fly out of the grid.

    Courant control; a rotor far across the slabs, two cut bodies that share vertices, and a frame
    of the grid between steps. Volumes are means over cells.
    """
    held = {"body": "bar", "region": {"box": {"min": [0.0, 1.0], "max": [1.0, 3.0]}}}
    disk = {"ball": {"centre": [8.3, 5.6], "radius": 1.4}}
    bodies = {
        "bar": box([0.0, 1.0], [7.0, 3.0], [0.0, 1.0]),
        "disk": {"material": "stiff", "region": disk, "velocity": [-3.0, 5.0]},
        "flap": box([9.8, 5.0], [11.4, 6.0]),
        "rotor": turning(box([12.5, 5.0], [15.5, 6.0]), [14.0, 5.5], 1.5, [9.0, 4.0]),
    }
    load = {"body": "bar", "face": "x-max", "pressure": {"table": [[0.0, 0.0], [1.0, 9.0]]}}
    return scene(
        2,
        {name: body | {"formulation": "total-lagrangian"} for name, body in bodies.items()},
        cells=[16, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"x-min": "fixed"},
        constraints={"grip": held | {"velocity": [None, {"table": [[0.0, 0.0], [1.0, 3.0]]}]}},
        tractions={"push": load},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
        probes={
            "tip": {"body": "rotor", "at": [15.5, 5.5]},
            "gate": {"place": [15.0, 6.0], "every": {"steps": 3}},
        },
    ) | {"method": {"shape": "finite-gimp", "particles-per-cell": [2, 2], "volumetric": "b-bar"}}


def exact_surfaces():
    """Cut bodies across slabs: one turns, one hangs, pressed and dragged, a thin one falls."""
    disk = {"ball": {"centre": [5.3, 5.4], "radius": 1.9}}
    bodies = {
        "bar": box([0.0, 1.02], [14.6, 2.98]),
        "disk": turning({"material": "stiff", "region": disk}, [5.3, 5.4], 2.0, [1.0, 0.5]),
        "thin": turning(box([9.3, 7.97], [16.4, 8.2]), [12.0, 8.0], 0.1, [1.0, 0.5]),
    }
    held = {"body": "bar", "region": {"box": {"min": [12.0, 0.0], "max": [13.0, 3.0]}}}
    top = {"body": "bar", "region": {"box": {"min": [3.3, 2.0], "max": [9.1, 4.0]}}}
    more = {"formulation": "total-lagrangian"}
    return scene(
        2,
        {name: body | more for name, body in bodies.items()},
        cells=[18, 9],
        shape="finite-gimp",
        end=0.8,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"x-min": "fixed"},
        constraints={"grip": held | {"velocity": [None, {"table": [[0.0, 0.0], [1.0, 2.0]]}]}},
        tractions={
            "push": top | {"pressure": 2.0, "normal": {"of": [0.0, 1.0]}},
            "pull": {"body": "bar", "face": "x-max", "traction": [1.0, 0.0]},
        },
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )


def exact_means():
    """The same bodies, two with mean dilatation, and stresses recovered from neighbours."""
    case = exact_surfaces()
    case["method"]["volumetric"] = "b-bar"
    case["bodies"]["disk"]["volumetric"] = "pointwise"
    case["output"]["fields"] = [*EVERYTHING, "recovered-stress"]
    case["probes"] = {
        name: {"body": body, "at": at, "fields": ["recovered-stress"], "every": {"steps": 10}}
        for name, body, at in (("top", "bar", [7.3, 2.98]), ("side", "disk", [7.2, 5.4]))
    }
    return case


def exact_skins():
    """A thin body on a thick one, which a stage takes away: its cells' means are over others then.

    Vertices of the thin one are slaves before, and have the masses of others after.
    """
    bodies = {"thick": box([2.0, 1.0], [15.0, 3.0]), "skin": box([3.0, 3.0], [14.2, 3.15])}
    clamp = {"body": "thick", "region": {"box": {"min": [2.0, 1.0], "max": [3.0, 3.0]}}}
    case = scene(
        2,
        {name: body | {"formulation": "total-lagrangian"} for name, body in bodies.items()},
        cells=[18, 9],
        shape="finite-gimp",
        end=0.5,
        step={"courant": 0.3},
        gravity=[0.0, -20.0],
        constraints={"clamp": clamp | {"velocity": [0.0, 0.0]}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["method"]["volumetric"] = "b-bar"
    gone = {"remove": ["thick"], "constraints": {"clamp": None}}
    case["time"]["stages"] = [{"name": "skinned", "end": 0.8} | gone]
    return case


def within(cells, *regions):
    """The part of some regions in the domain."""
    return {"intersection": [{"union": regions}, {"box": {"min": [0.0, 0.0], "max": cells}}]}


def exact_round():
    """Bodies exact to their surface across seams, cut near them: a disk, and a bar with a grip.

    The disk has an averaged mass, as the ball of the rings.
    """
    balls = [{"ball": {"centre": [x, y], "radius": 1.9}} for x in (0.3, 18.3) for y in (0.4, 9.4)]
    bars = [
        {"box": {"min": [low, 4.02], "max": [high, 5.97]}} for low, high in ((0, 2.6), (13.9, 18))
    ]
    more = {"formulation": "total-lagrangian", "velocity": [1.0, 0.5]}
    held = {"body": "bar", "region": {"box": {"min": [0.0, 4.0], "max": [0.8, 6.0]}}}
    top = {"body": "bar", "region": {"box": {"min": [0.0, 5.0], "max": [1.7, 7.0]}}}
    return scene(
        2,
        {
            "bar": {"material": "soft", "region": within([18.0, 9.0], *bars)} | more,
            "disk": {"material": "stiff", "region": within([18.0, 9.0], *balls)}
            | more
            | {"mass": "averaged"},
        },
        cells=[18, 9],
        shape="finite-gimp",
        end=1.6,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic"),
        constraints={"grip": held | {"velocity": [None, {"table": [[0.0, 0.0], [1.0, 2.0]]}]}},
        tractions={
            "push": top | {"pressure": 2.0, "normal": {"of": [0.0, 1.0]}},
            "pull": {"body": "bar", "region": top["region"], "traction": [1.0, 0.0]},
        },
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )


def exact_rings():
    """Rings exact to their surface: a ball on the axis across a seam, a tube with a load inside."""
    balls = [{"ball": {"centre": [0.0, y], "radius": 1.9}} for y in (0.4, 9.4)]
    tube = {"box": {"min": [7.03, 2.02], "max": [12.41, 5.97]}}
    more = {"formulation": "total-lagrangian"}
    case = scene(
        2,
        {
            "ball": {"material": "stiff", "region": within([18.0, 9.0], *balls)}
            | more
            | {"mass": "averaged"},
            "tube": {"material": "soft", "region": tube, "velocity": [0.0, 1.0]} | more,
        },
        cells=[18, 9],
        end=1.6,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"y-min": "periodic", "y-max": "periodic"},
        tractions={"bore": {"body": "tube", "face": "x-min", "pressure": 2.0}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["geometry"] = "axisymmetric"
    return case


def initial_stages():
    """Bonded bodies in the initial configuration, cut off the grid's lines, in stages.

    A grip begins and ends, bonds become friction and again bonds, one body is removed; a body in
    the current configuration flies up meanwhile, so that the window grows.
    """
    spin = {"rotation": {"about": [9.0, 3.0], "rate": 0.2}, "translation": [0.5, 0.4]}
    bodies = {
        "a": box([2.2, 2.3], [7.2, 4.3], spin),
        "b": box([7.2, 2.3], [12.0, 4.3], spin, "stiff"),
        "c": box([12.0, 2.3], [17.1, 4.3], spin),
    }
    bodies = {name: body | {"formulation": "total-lagrangian"} for name, body in bodies.items()}
    bodies["bird"] = box([9.0, 5.0], [11.0, 6.0], [3.0, 9.0])
    held = {"body": "b", "region": {"box": {"min": [8.0, 2.0], "max": [9.0, 5.0]}}}
    tied = [{"bodies": ["a", "b"], "law": "tie"}, {"bodies": ["b", "c"], "law": "tie"}]
    case = scene(
        2,
        bodies,
        cells=[20, 20],
        shape="finite-gimp",
        end=0.3,
        step={"courant": 0.3},
        materials=PAIR,
        boundaries={"x-max": "slip"},
        contact=[{"bodies": "all", "friction": 0.3}, *tied],
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["method"]["volumetric"] = "b-bar"
    case["time"]["stages"] = [
        {"name": "grip", "end": 0.5, "constraints": {"grip": held | {"velocity": [None, 2.0]}}},
        {"name": "loose", "end": 0.7, "contact": [{"bodies": "all", "friction": 0.1}, tied[1]]},
        {"name": "bound", "end": 0.9, "constraints": {"grip": None}, "gravity": [0.0, -2.0],
         "contact": [{"bodies": "all", "friction": 0.1}, *tied]},
        {"name": "gone", "end": 1.1, "remove": ["c"], "boundaries": {"y-min": "fixed"}},
    ]  # fmt: skip
    return case


def initial_contact():
    """Bodies of whole particles, in the initial configuration, meet: each other, tools, a floor.

    One comes from far, one is held, one lies on another and slides, one is tied to it; a ram comes
    in, and a turning drum drags what falls onto it. Bodies leave their first slabs on the way.
    """
    disk = {"ball": {"centre": [4.3, 5.6], "radius": 1.4}}
    bodies = {
        "flies": {"material": "stiff", "region": disk, "velocity": [9.0, -1.0]},
        "lies": box([8.0, 0.0], [13.0, 2.0]),
        "slides": box([8.5, 2.0], [10.5, 4.0], [3.0, 0.0]),
        "glued": box([12.0, 2.0], [13.0, 3.5]),
        "falls": box([17.0, 4.0], [19.5, 6.0], [0.0, -3.0], "stiff"),
    }
    more = {"formulation": "total-lagrangian", "surface": "whole-particles"}
    bodies = {name: body | more for name, body in bodies.items()}
    rotation = {"about": [18.0, 1.5], "rate": -4.0}
    bodies["drum"] = {"rigid": {"rotation": rotation},
                      "region": {"ball": {"centre": [18.0, 1.5], "radius": 1.7}}}  # fmt: skip
    bodies["ram"] = {"rigid": {"velocity": {"table": [[0.0, [6.0, 0.0]], [1.0, [2.0, 0.0]]]}},
                     "region": {"box": {"min": [-6.0, 2.0], "max": [2.5, 8.0]}}}  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[24, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"y-min": {"unilateral": {"friction": 0.2}}, "x-max": "slip"},
        contact=[
            {"bodies": "all", "friction": {"static": 0.4, "kinetic": 0.3}},
            {"bodies": ["lies", "glued"], "law": "tie"},
            {"bodies": ["lies", "drum"], "adhesion": {"normal": 1.0, "reach": 0.3}},
        ],
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )


def exact_contact():
    """The same of bodies that are cut anywhere, but for one; a tie ends in a stage.

    Beside one of whole particles all meet at vertices.
    """
    case = initial_contact()
    bodies = case["bodies"]
    places = {
        "lies": ([8.03, 0.0], [13.04, 1.97]),
        "slides": ([8.55, 1.97], [10.52, 3.98]),
        "glued": ([12.03, 1.97], [13.04, 3.5]),
        "falls": ([17.1, 4.02], [19.46, 6.0]),
    }
    for name, (low, high) in places.items():
        bodies[name]["region"] = {"box": {"min": low, "max": high}}
    for name in ("flies", "lies", "slides", "glued"):
        bodies[name]["surface"] = "cut-particles"
    friction = {"bodies": "all", "friction": 0.3}
    case["time"]["stages"] = [{"name": "loose", "end": 1.4, "contact": [friction]}]
    return case


def surface_contact():
    """Bodies exact to their surface meet, across slabs: each other, tools, a floor that lets go.

    Corners meet, one body is tied to another whose lattice differs, one is pressed by a free
    rigid body, another rolls on a drum, from which a rigid bead rebounds onto the floor.
    """
    disk = {"ball": {"centre": [4.3, 5.6], "radius": 1.37}}
    bodies = {
        "flies": {"material": "stiff", "region": disk, "velocity": [9.0, -1.0]},
        "lies": box([8.03, 0.0], [13.1, 1.93]),
        "slides": box([8.5, 1.93], [10.57, 4.1], [3.0, 0.0]),
        "glued": box([11.87, 1.93], [13.02, 3.48]),
        "falls": box([17.0, 4.03], [19.5, 6.0], [-1.0, -3.0], "stiff"),
        "edged": box([14.1, 2.7], [16.4, 4.6], [3.0, 0.5]),
    }
    more = {"formulation": "total-lagrangian"}
    bodies = {name: body | more for name, body in bodies.items()}
    rotation = {"about": [18.0, 1.5], "rate": -4.0}
    bodies["drum"] = {"rigid": {"rotation": rotation},
                      "region": {"ball": {"centre": [18.0, 1.5], "radius": 1.7}}}  # fmt: skip
    bodies["ram"] = {"rigid": {"velocity": {"table": [[0.0, [6.0, 0.0]], [1.0, [2.0, 0.0]]]}},
                     "region": {"box": {"min": [-6.0, 2.0], "max": [2.5, 8.0]}}}  # fmt: skip
    bodies["puck"] = {"rigid": {"density": 2.0}, "velocity": [-1.0, -2.0],
                      "region": {"box": {"min": [12.2, 4.3], "max": [13.9, 5.9]}}}  # fmt: skip
    bodies["bead"] = {"rigid": {"density": 1.0}, "velocity": [-3.0, -7.0],
                      "region": {"ball": {"centre": [21.1, 3.0], "radius": 0.9}}}  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[24, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={
            "y-min": {"unilateral": {"friction": 0.2, "restitution": 0.7}},
            "x-max": "slip",
        },
        contact=[
            {"bodies": "all", "friction": {"static": 0.4, "kinetic": 0.3}},
            {"bodies": ["bead", "drum"], "friction": 0.2, "restitution": 0.6},
            {"bodies": ["lies", "glued"], "law": "tie"},
            {"bodies": ["lies", "drum"], "adhesion": {"normal": 1.0, "reach": 0.3}},
        ],
        output={"every": 0.25, "fields": EVERYTHING, "surface": [*SURFACE]},
        history={"every": {"steps": 10}},
    )


def surface_beside():
    """Bodies exact to their surface meet others in the current configuration, across slabs.

    These also meet each other, a rigid tool, a free rigid body and a floor that lets go.
    """
    more = {"formulation": "total-lagrangian", "surface": "exact"}
    disk = {"ball": {"centre": [4.3, 5.2], "radius": 1.37}}
    bodies = {
        "bed": box([3.0, 0.0], [15.0, 2.0]),
        "flies": {"material": "stiff", "region": disk, "velocity": [3.0, -4.0]} | more,
        "slides": box([8.5, 2.0], [10.57, 4.1], [3.0, 0.0]) | more,
        "falls": box([9.0, 4.3], [11.5, 6.0], [1.0, -3.0], "stiff"),
        "puck": {"rigid": {"density": 2.0}, "velocity": [-1.0, -2.0],
                 "region": {"box": {"min": [12.2, 2.3], "max": [13.9, 4.0]}}},
        "ram": {"rigid": {"velocity": [-2.0, 0.0]},
                "region": {"box": {"min": [15.3, 0.5], "max": [17.0, 3.0]}}},
    }  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[24, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"y-min": {"unilateral": {"friction": 0.2}}, "x-max": "slip"},
        contact=[{"bodies": "all", "friction": {"static": 0.4, "kinetic": 0.3}}],
        output={"every": 0.25, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )


def surface_boxes():
    """A body of whole particles and one from a file, off the grid, meet across slabs and a seam."""
    more = {"formulation": "total-lagrangian"}
    disk = {"ball": {"centre": [4.3, 4.2], "radius": 1.9}}
    file = str(Path(__file__).with_name("bricks.csv"))
    bodies = {
        "rolls": {"material": "stiff", "region": disk, "velocity": [-5.0, -6.0]}
        | more
        | {"surface": "whole-particles"},
        "slides": {"material": "soft", "region": {"points": {"file": file}},
                   "velocity": [4.0, -3.0]} | more,
        "floor": {"rigid": {}, "region": {"box": {"min": [-2.0, 0.1], "max": [20.0, 2.1]}}},
    }  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[18, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"x-min": "periodic", "x-max": "periodic"},
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": 0.25, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )


def surface_stages():
    """Bodies exact to their surface, in stages: bonds become friction, a touched body goes."""
    spin = {"rotation": {"about": [9.0, 3.0], "rate": 0.2}, "translation": [0.5, 0.4]}
    bodies = {
        "a": box([2.2, 2.3], [7.21, 4.3], spin),
        "b": box([7.21, 2.3], [12.04, 4.3], spin, "stiff"),
        "c": box([12.04, 2.3], [17.1, 4.3], spin),
        "falls": box([13.1, 4.8], [15.6, 6.7], [0.0, -5.0]),
    }
    more = {"formulation": "total-lagrangian"}
    bodies = {name: body | more for name, body in bodies.items()}
    held = {"body": "b", "region": {"box": {"min": [8.0, 2.0], "max": [9.0, 5.0]}}}
    tied = [{"bodies": ["a", "b"], "law": "tie"}, {"bodies": ["b", "c"], "law": "tie"}]
    case = scene(
        2,
        bodies,
        cells=[20, 12],
        shape="finite-gimp",
        end=0.3,
        step={"courant": 0.3},
        materials=PAIR,
        boundaries={"y-min": "unilateral"},
        contact=[{"bodies": "all", "friction": 0.3}, *tied],
        gravity=[0.0, -2.0],
        output={"every": 0.25, "fields": EVERYTHING, "surface": [*SURFACE]},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [
        {"name": "grip", "end": 0.5, "constraints": {"grip": held | {"velocity": [None, 2.0]}}},
        {"name": "loose", "end": 0.7, "contact": [{"bodies": "all", "friction": 0.1}, tied[1]]},
        {"name": "bound", "end": 0.9, "constraints": {"grip": None},
         "contact": [{"bodies": "all", "friction": 0.1}, *tied]},
        {"name": "gone", "end": 1.1, "remove": ["c"]},
    ]  # fmt: skip
    return case


def both_configurations():
    """Water falls on a plate in the initial configuration, which a free ball hits and a ram pushes.

    The plate is held, moves over the slabs and slides on a floor; the water leaves the domain.
    """
    water = {"model": "newtonian", "density": 1.0, "bulk": 200.0, "shear-viscosity": 0.3}
    held = {"body": "plate", "region": {"box": {"min": [4.0, 1.0], "max": [5.0, 3.0]}}}
    bodies = {
        "plate": box([4.0, 1.0], [16.0, 3.0]) | {"formulation": "total-lagrangian"},
        "water": box([8.5, 3.6], [14.5, 6.4], [3.0, -2.0], "water"),
        "block": box([16.5, 0.0], [19.5, 2.0], [-3.0, 0.0], "stiff"),
        "ball": {"rigid": {"density": 3.0}, "velocity": [1.0, -4.0],
                 "region": {"ball": {"centre": [6.2, 5.2], "radius": 1.6}}},
        "ram": {"rigid": {"velocity": [-2.0, 0.0]},
                "region": {"box": {"min": [21.0, -1.0], "max": [26.0, 4.0]}}},
    }  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[24, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR | {"water": water},
        gravity=[0.0, -1.0],
        boundaries={"y-min": {"unilateral": {"friction": 0.2}}, "x-min": "slip"},
        outflow={"x-max": "remove", "y-max": "remove"},
        contact=[{"bodies": "all", "friction": 0.3}],
        constraints={"grip": held | {"velocity": [None, {"table": [[0.0, 0.0], [1.0, 1.0]]}]}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
        probes={"tip": {"body": "plate", "at": [16.0, 3.0]}, "jet": {"place": [15.0, 4.0]}},
    ) | {"method": {"shape": "finite-gimp", "particles-per-cell": [2, 2], "volumetric": "b-bar"}}


def initial_lattice():
    """Elastic bodies on the grid's lines, in the initial configuration: no particle has a state.

    A bar falls from a wall, a rotor turns across the slabs, a rod waits to be hit. Round grips are
    too light at some vertices to hold them. Steps as long as they may be, compressed frames, a
    probe in every third step.
    """
    round_grips = {
        body: {
            "body": body,
            "region": {"ball": {"center": center, "radius": 0.7}},
            "velocity": [None, 0.05],
        }
        for body, center in (("bar", [6.0, 2.0]), ("rotor", [12.0, 5.0]))
    }
    bodies = {
        "bar": box([0.0, 1.0], [7.0, 3.0], [0.0, 0.3]),
        "rotor": turning(box([9.0, 4.0], [15.0, 6.0]), [12.0, 5.0], 1.0, [1.0, 0.0]),
        "rod": box([8.0, 0.0], [12.0, 1.0], material="stiff"),
    }
    return scene(
        2,
        {name: body | {"formulation": "total-lagrangian"} for name, body in bodies.items()},
        cells=[20, 8],
        shape="gimp",
        end=3.0,
        step={"courant": "auto"},
        materials={"soft": SOFT, "stiff": SOFT | {"young": 300.0, "density": 2.0}},
        gravity=[0.0, -0.1],
        boundaries={"x-min": "fixed"},
        constraints=round_grips,
        output={"every": 0.5, "fields": EVERYTHING, "grid": GRID, "compression": "gzip"},
        history={"every": {"steps": 10}},
        probes={
            "tip": {"body": "rotor", "at": [15.0, 5.5], "every": {"steps": 3}},
            "gate": {"place": [10.0, 5.0], "every": {"steps": 7}},
        },
    )
