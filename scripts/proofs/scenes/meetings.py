"""Small scenes in 2D that meet all the time: for contact that keeps its selections."""

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}


def case(cells, bodies, gravity=None, friction=0.3, walls="separating", **parts):
    """A case without an end, whose bodies are in the initial configuration if they are soft."""
    faces = {f"{axis}-{end}": {"separating": {"friction": 0.2}} if walls == "separating" else walls
             for axis in "xy" for end in ("min", "max")}  # fmt: skip
    return {
        "format": 1,
        "dimensions": 2,
        "grid": {"size": [float(n) for n in cells], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles_per_cell": [2, 2]},
        "time": {"end": 1.0e9, "step": {"courant": 0.3}},
        "materials": {"soft": SOFT},
        "bodies": bodies,
        "boundaries": faces,
        "contact": [{"bodies": "all", "friction": friction}],
        **({"gravity": gravity} if gravity else {}),
        **parts,
    }


def body(region, velocity=None, configuration="initial"):
    """A soft body."""
    entry = {"material": "soft", "region": region, "configuration": configuration}
    return entry | ({"velocity": velocity} if velocity else {})


def box(low, high, *args):
    return body({"box": {"min": low, "max": high}}, *args)


def ball(centre, radius, *args):
    return body({"ball": {"centre": centre, "radius": radius}}, *args)


def spin(about, rate, translation):
    return {"rotation": {"about": about, "rate": rate}, "translation": translation}


def blocks():
    """Two blocks bounce and slide between walls with friction."""
    bodies = {
        "left": box([1.3, 1.1], [5.3, 5.1], spin([3.3, 3.1], 0.1, [2.0, 0.7])),
        "right": box([7.2, 0.4], [10.7, 4.4], spin([8.7, 2.4], -0.1, [-1.5, 0.5])),
    }
    return case([13, 9], bodies, gravity=[0.0, -0.2])


def disk():
    """A disk rolls to and fro in a trough of two rigid slopes."""

    def slope(low, high, n):
        half = {"half-space": {"point": [8.0, 1.6], "normal": [n, 1.0]}}
        return {"intersection": [{"box": {"min": [low, 0.6], "max": [high, 6.0]}}, half]}

    bodies = {
        "disk": ball([4.5, 5.4], 2.2),
        "left": {"rigid": {}, "region": slope(0.1, 8.0, 0.3)},
        "right": {"rigid": {}, "region": slope(8.0, 15.9, -0.3)},
    }
    return case([16, 10], bodies, gravity=[0.0, -0.4], walls="slip")


def stack():
    """Three blocks rest on each other and on the floor."""
    bodies = {name: box([2.0 + 0.3 * n, 3.0 * n], [6.0 + 0.3 * n, 3.0 * n + 3.0])
              for n, name in enumerate(("low", "middle", "high"))}  # fmt: skip
    return case([9, 10], bodies, gravity=[0.0, -0.3])


def heap():
    """Disks in the current configuration come to rest on each other."""
    bodies = {}
    for n in range(7):
        centre = [1.9 + 2.9 * (n % 3) + 0.2 * (n // 3), 1.7 + 3.1 * (n // 3)]
        bodies[f"disk{n}"] = ball(centre, 1.4, [0.3 * (-1) ** n, 0.0], "current")
    return case([10, 11], bodies, gravity=[0.0, -0.3])


def thin():
    """Strips, one-cell bodies and corners in a mill: a cross that turns fast, and a stone."""
    bodies = {
        "strip": box([0.6, 8.2], [5.6, 8.8], [0.5, -0.5]),
        "post": box([9.2, 1.0], [9.7, 5.0], [-0.6, 0.3]),
        "one": box([1.1, 1.2], [2.1, 2.2], [1.0, 0.4]),
        "two": box([2.2, 1.3], [3.2, 2.3], [0.8, 0.5]),
        "three": box([1.3, 2.4], [2.3, 3.4], [1.2, -0.3]),
        "wedge": body({"intersection": [
            {"box": {"min": [7.5, 7.2], "max": [10.5, 9.8]}},
            {"half-space": {"point": [7.5, 9.8], "normal": [0.8, 1.0]}}]}, [-0.5, -0.6]),
        "mill": {"rigid": {"rotation": {"about": [6.0, 5.5], "rate": 0.9}},
                 "region": {"union": [{"box": {"min": [3.9, 5.0], "max": [8.1, 6.0]}},
                                      {"box": {"min": [5.5, 3.4], "max": [6.5, 7.6]}}]}},
    }  # fmt: skip
    return case([12, 11], bodies, gravity=[0.0, -0.3])


def impact():
    """Fast bodies that stretch by half: a bar, a ball and one-cell bodies between walls."""
    bodies = {
        "bar": box([1.0, 4.0], [6.0, 5.5], [1.6, 0.3]),
        "ball": ball([10.0, 4.6], 1.5, [-1.8, 0.0]),
        "one": box([7.2, 4.5], [8.0, 5.3], [0.0, 0.5]),
        "two": box([6.2, 1.0], [7.2, 2.0], [0.5, 1.5]),
        "plate": box([3.0, 7.0], [9.0, 7.5], [0.0, -1.2]),
    }
    return case([13, 9], bodies, friction=0.1)


#: Scenes by name, with their steps.
SCENES = {
    "blocks": (blocks, 100_000),
    "disk": (disk, 100_000),
    "stack": (stack, 100_000),
    "heap": (heap, 100_000),
    "thin": (thin, 20_000),
    "impact": (impact, 20_000),
}
