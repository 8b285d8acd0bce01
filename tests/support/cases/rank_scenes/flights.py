"""Bodies fly across slabs, in 1D, 2D and 3D."""

from scenes import box, scene, wall

from rank_scenes.entries import EVERYTHING, LINE, PAIR, turning


def line_gimp():
    """Two bars fly at each other past all slabs, collide, and leave the first slabs empty."""
    bodies = {"quick": box([1.0], [7.0], [8.0]), "slow": box([20.0], [26.0], [-2.0], "stiff")}
    return scene(
        1,
        bodies,
        cells=[40],
        end=2.0,
        step=0.01,
        materials=LINE,
        output={"every": 0.5, "fields": EVERYTHING},
        history={"every": {"steps": 20}},
    )


def line_slows():
    """Courant control; a bar flies against its weight, so that steps lengthen again and again."""
    return scene(
        1,
        box([24.0], [32.0], [-8.0]),
        cells=[40],
        end=2.0,
        step={"courant": 0.1},
        gravity=[4.0],
        output={"every": 0.5, "fields": EVERYTHING},
        history={"every": {"steps": 20}},
    )


def line_mpm():
    """Courant control, with stops; a bar falls on a floor, and a moving wall pushes another."""
    bodies = {"falls": box([1.0], [5.0], [-1.0]), "pushed": box([26.0], [30.0], [0.0])}
    ramp = [[0.0, [0.0]], [0.5, [-2.0]]]
    push = [[0.0, 0.0], [0.5, -0.4]]
    return scene(
        1,
        bodies,
        cells=[30],
        shape="mpm",
        per_cell=3,
        end=1.0,
        step={"courant": 0.1},
        gravity={"table": ramp},
        boundaries={"x-min": "unilateral", "x-max": wall(push)},
        output={"at": [0.3, 0.7], "fields": EVERYTHING},
        history={"every": 0.1},
    )


def plane_gimp(**parts):
    """Courant control; squares fly up and across, one turns, one is dragged along a wall.

    The upper and the lower one come into each layer together, in the order of neither's ids.
    """
    bodies = {
        "upper": box([6.0, 8.0], [7.0, 9.0], [2.0, 1.0]),
        "lower": box([6.0, 5.0], [7.0, 6.0], [2.0, 1.0], "stiff"),
        "flies": turning(box([1.0, 2.0], [4.0, 5.0]), [2.5, 3.5], 0.4, [4.0, 6.0]),
        "dragged": box([8.0, 0.0], [11.0, 2.0], None, "stiff"),
    }
    return scene(
        2,
        bodies,
        cells=[16, 24],
        end=1.5,
        step={"courant": 0.25},
        materials=PAIR,
        boundaries={"y-min": wall(-1.5, 0.0), "x-max": "slip"},
        **{
            "output": {"every": 0.4, "at": [0.77], "fields": EVERYTHING},
            "history": {"every": {"steps": 15}},
        }
        | parts,
    )


def plane_mpm():
    """Two turning squares pass each other, one up, one down."""
    bodies = {
        "up": turning(box([1.0, 2.0], [3.0, 4.0]), [2.0, 3.0], 0.5, [2.9, 5.3]),
        "down": turning(box([12.0, 6.0], [14.0, 8.0]), [13.0, 7.0], -0.4, [-3.1, -2.7]),
    }
    return scene(
        2,
        bodies,
        cells=[16, 18],
        shape="mpm",
        end=1.4,
        step=0.007,
        boundaries={"y-min": "fixed", "y-max": "slip"},
        output={"every": 0.35, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )


def space_gimp():
    """Courant control; two blocks fly in y and z, collide on the way, one turns."""
    bodies = {
        "flies": turning(
            box([1.0, 1.0, 1.0], [3.0, 3.0, 3.0]), [2.0] * 3, [0.2, 0.3, 0.4], [5.0, 6.0, 7.0]
        ),
        "meets": box([5.0, 5.0, 6.0], [7.0, 7.0, 8.0], [0.0, 3.0, 3.0], "stiff"),
    }
    return scene(
        3,
        bodies,
        cells=[12, 12, 14],
        end=0.9,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, 0.0, -1.0],
        boundaries={"z-min": "unilateral", "y-max": "slip"},
        output={"every": 0.3, "fields": EVERYTHING},
        history={"every": 0.1},
    )


def space_mpm():
    """Long enough for a re-sort of the rows while a block crosses slabs."""
    block = box([1.0, 1.0, 1.0], [3.0, 3.0, 3.0])
    bodies = {
        "flies": turning(block, [2.0] * 3, [0.1, -0.4, 0.3], [3.7, 2.9, 4.1]),
        "stays": box([7.0, 1.0, 1.0], [9.0, 3.0, 2.0], None),
    }
    return scene(
        3,
        bodies,
        cells=[12, 8, 10],
        shape="mpm",
        end=1.05,
        step=0.007,
        boundaries={"z-min": "slip"},
        output={"every": 0.35, "fields": EVERYTHING},
        history={"every": {"steps": 25}},
    )


def narrow():
    """Three cells along x: room for four ranks at most."""
    body = box([0.0, 1.0, 1.0], [3.0, 3.0, 3.0], [0.0, 5.0, 3.0])
    second = box([0.0, 1.0, 6.0], [2.0, 2.0, 7.0], [0.4, 0.0, 0.0], "stiff")
    return scene(
        3,
        {"wide": body, "small": second},
        cells=[3, 12, 10],
        end=1.0,
        step=0.01,
        materials=PAIR,
        boundaries={"x-min": "slip", "x-max": "slip"},
        output={"every": 0.5, "fields": EVERYTHING, "grid": ["momentum"]},
        history={"every": {"steps": 20}},
        probes={"small": {"body": "small", "at": [1.0, 1.5, 6.5], "every": {"steps": 1}}},
    )


def cut():
    """A tilted cylinder and a ball, which the lattice cuts, spinning."""
    motion = {
        "rotation": {"about": [1.5, -2.0, 0.3], "rate": [0.9, -0.4, 1.3]},
        "translation": [0.4, -0.3, 0.8],
    }
    pin = {"from": [3.7, 2.1, 2.2], "to": [6.4, 3.9, 3.1], "radius": 0.71}
    regions = {
        "ball": {"ball": {"centre": [2.03, 2.61, 2.57], "radius": 1.43}},
        "pin": {"cylinder": pin},
    }
    body = {"surface": "cut-particles", "velocity": motion}
    bodies = {
        name: body | {"material": material, "region": regions[name]}
        for name, material in (("ball", "soft"), ("pin", "stiff"))
    }
    return scene(
        3,
        bodies,
        cells=[8, 6, 6],
        end=0.1,
        materials=PAIR,
        boundaries={"y-min": "slip"},
        output={"fields": EVERYTHING},
    )
