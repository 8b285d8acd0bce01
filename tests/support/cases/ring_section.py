"""Sections of axisymmetric bodies, for whole runs."""

SOLID = {"model": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 2.0}


def case(
    region, *, material=SOLID, size=(3.0, 2.0), h=0.25, end=1.0, shape="gimp",
    configuration="current", **more,
):  # fmt: skip
    return {
        "format": 1,
        "dimensions": 2,
        "geometry": "axisymmetric",
        "grid": {"size": list(size), "cell": [h, h]},
        "method": {"shape": shape, "particles-per-cell": [2, 2]},
        "time": {"end": end, "step": {"courant": 0.3}},
        "materials": {"m": material},
        "bodies": {"b": {"material": "m", "region": region, "formulation": configuration}},
    } | more


def box(low, high):
    return {"box": {"min": list(low), "max": list(high)}}
