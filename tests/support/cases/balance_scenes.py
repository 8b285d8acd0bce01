"""Scenes whose load leaves the ranks that had it."""

from scenes import box, scene

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.4, "density": 1.0}


def column(n, end):
    """A column at a wall, n cells wide and twice as tall, slumps sideways on a slippery floor."""
    return scene(
        2,
        box([0.0, 0.0], [n, 2.0 * n]),
        cells=[4 * n, 2 * n + 4],
        end=end,
        step={"courant": 0.3},
        materials={"soft": SOFT},
        gravity=[0.0, -60.0 / n],
        boundaries={"x-min": "slip", "y-min": "slip"},
        output={"every": end / 4, "fields": ["velocity", "stress"]},
        history={"every": {"steps": 50}},
    )


def crossing(n, end):
    """A square of n cells flies from one end of the domain to the other, as fast as sound."""
    return scene(
        2,
        box([2.0, 3.0], [2.0 + n, 3.0 + n], [12.0, 0.2]),
        cells=[6 * n, n + 10],
        end=end,
        step={"courant": 0.3},
        materials={"soft": SOFT},
        output={"every": end / 4, "fields": ["velocity", "stress"]},
        history={"every": {"steps": 50}},
    )
