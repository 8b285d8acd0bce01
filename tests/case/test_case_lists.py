"""Lists of one number a direction: too short or too long they are named, whatever indexes them."""

from json import dumps, loads

import pytest

from pgimp.case.load import load
from pgimp.errors import CaseError
from pgimp.utilities.reference.jsonschema import json_schema

BOX = {"box": {"min": [0.2, 0.2, 0.2], "max": [0.8, 0.8, 0.8]}}
OTHER = {"box": {"min": [0.2, 0.2, 1.2], "max": [0.8, 0.8, 1.6]}}
HALF = {"half-space": {"point": [0.5, 0.5, 0.5], "normal": [0.0, 0.0, 1.0]}}
REGIONS = {
    "ball": {"ball": {"centre": [0.5, 0.5, 0.5], "radius": 0.2}},
    "cylinder": {"cylinder": {"from": [0.5, 0.5, 0.2], "to": [0.5, 0.5, 0.8], "radius": 0.2}},
    "half-space": {
        "intersection": [BOX, {"half-space": {"point": [0.5, 0.5, 0.5], "normal": [0.0, 0.0, 1.0]}}]
    },
    "mesh": {
        "mesh": {"file": "none.obj", "rotate": [0.0, 90.0, 0.0], "translate": [0.1, 0.1, 0.0]}
    },
    "heights": {
        "heights": {
            "file": "none.npy",
            "bottom": 0.0,
            "nodes": {"origin": [0.0, 0.0], "spacing": [0.1, 0.1]},
            "part": {"min": [0.2, 0.2], "max": [0.8, 0.8]},
            "translate": [0.1, 0.1, 0.0],
        }
    },
}
BASE = {
    "format": 1,
    "dimensions": 3,
    "grid": {"origin": [0.0, 0.0, 0.0], "size": [1.0, 1.0, 2.0], "cell": [0.1, 0.1, 0.1]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2, 2]},
    "time": {"end": 0.01, "step": {"courant": 0.3}},
    "materials": {"m": {"model": "hooke", "young": 1e6, "poisson": 0.3, "density": 1000.0}},
    "bodies": {"block": {"material": "m", "region": BOX, "velocity": [0.0, 0.0, 0.0]}},
}
WATER = {"water": {"model": "newtonian", "bulk": 1e5, "density": 1000.0}}
TABLE = {"table": [[0.0, [0.0, 0.0, -9.81]], [1.0, [0.0, 0.0, 0.0]]]}
TURN = {"about": [0.5, 0.5, 0.5], "axis": [0.0, 0.0, 1.0], "rate": 1.0}
MOTION = {
    "rotation": {"about": [0.5, 0.5, 0.5], "rate": [0.0, 0.0, 1.0]},
    "translation": [0.0, 0.0, 0.0],
}
PRESSED = {"body": "block", "region": REGIONS["half-space"]}


def plate(rigid, **more):
    """The bodies with a rigid one."""
    return {"bodies": {**BASE["bodies"], "plate": {"rigid": rigid, "region": OTHER, **more}}}


def held(**keys):
    """A constraint of the block."""
    return {"constraints": {"grip": {"body": "block", "region": BOX, **keys}}}


FLAT = {
    "dimensions": 2,
    "grid": {"origin": [0.0, 0.0], "size": [1.0, 1.0], "cell": [0.1, 0.1]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
    "materials": {"m": {**BASE["materials"]["m"], "model": "neo-hookean"}},
}

#: Keys of a case beside those of the base, by what they are.
PARTS = {
    "plain": {"gravity": [0.0, 0.0, -9.81]},
    "gravity": {"gravity": TABLE},
    "moving": {"bodies": {"block": {**BASE["bodies"]["block"], "velocity": MOTION}}},
    "walls": {"boundaries": {"x-min": {"velocity": [0.0, None, 0.1]}}},
    "periodic": {"boundaries": {"x-min": "periodic", "x-max": "periodic"}},
    "grip": held(velocity=[0.0, None, None], force=[None, 1.0, None]),
    "turned": held(rotation=TURN, velocity=[0.0, 0.0, 0.0]),
    "pull": {"tractions": {"p": {"body": "block", "face": "x-max", "traction": [1.0, 0.0, 0.0]}}},
    "pulls": {"tractions": {"p": {"body": "block", "face": "x-max", "traction": TABLE}}},
    "normal": {
        "tractions": {"p": {**PRESSED, "pressure": 1.0, "normal": {"of": [0.0, 0.0, 1.0]}}}
    },
    "profile": {
        "tractions": {
            "p": {
                **PRESSED,
                "pressure": 1.0,
                "profile": {
                    "along": [1.0, 0.0, 0.0],
                    "from": [0.2, 0.2, 0.2],
                    "table": [[0.0, 1.0], [0.5, 1.0]],
                },
            }
        }
    },
    "tool": plate({"velocity": [0.0, 0.0, -1.0], "rotation": TURN}),
    "tools": plate({"velocity": TABLE}),
    "free": plate(
        {"density": 1.0, "force": [0.0, 0.0, 1.0], "spring": {"stiffness": 1.0, "to": [0.0] * 3}},
        velocity=[0.0, 0.0, -1.0],
    ),
    "flying": plate({"density": 1.0, "force": TABLE}, velocity=MOTION),
    "jet": {
        "materials": WATER,
        "bodies": {"jet": {"material": "water", "region": OTHER}},
        "inflow": {"jet": {"velocity": [0.0, 0.0, -2.0]}},
    },
    "probes": {
        "probes": {"a": {"body": "block", "at": [0.5, 0.5, 0.5]}, "b": {"place": [0.5, 0.5, 0.5]}}
    },
    "gauges": {
        "boundaries": {"z-min": "fixed"},
        "gauges": {
            "cut": {"cut": HALF, "about": [0.5, 0.5, 0.5], "within": BOX},
            "flux": {"flux": BOX},
            "floor": {"wall": "z-min", "within": {"box": {"min": [0.0] * 3, "max": [1.0] * 3}}},
            "depth": {"level": [0.5, 0.5]},
        },
    },
    "sink": {"outflow": {"bin": {"region": OTHER}}},
    "frame": {"body-force": {"rotating-frame": MOTION["rotation"]}},
    "field": {
        "materials": {
            "m": {
                **BASE["materials"]["m"],
                "young": {"random": {"mean": 1e6, "cov": 0.1, "correlation": [0.2, 0.2, 0.2]}},
            }
        }
    },
    "stages": {
        **held(velocity=[0.0, None, None]),
        "time": {
            **BASE["time"],
            "stages": [
                {
                    "name": "later",
                    "end": 0.02,
                    "gravity": [0.0, 0.0, -9.81],
                    "boundaries": {"x-min": {"velocity": [0.0, 0.0, 0.1]}},
                    "constraints": {"grip": {"velocity": [1.0, None, None]}},
                }
            ],
        },
    },
    "waves": {
        **FLAT,
        "boundaries": {f"{a}-{end}": "periodic" for a in "xy" for end in ("min", "max")},
        "bodies": {
            "block": {"material": "m", "region": {"box": {"min": [0.0, 0.0], "max": [1.0, 1.0]}}}
        },
        "exact": {
            "plane-wave": {"along": "x", "swing": "y", "amplitude": 0.01, "drift": [0.5, 0.25]}
        },
    },
    "spinning": {
        "materials": {"m": {**FLAT["materials"]["m"], "poisson": 0.0}},
        "exact": {
            "spinning-block": {
                "period": 1.0,
                "rate": 1.0,
                "axis": [0.0, 0.0, 1.0],
                "stretch": [0.1, 0.0, 0.0],
                "translation": [0.0, 0.0, 0.0],
            }
        },
    },
    **{
        f"body of a {name}": {"bodies": {"block": {"material": "m", "region": region}}}
        for name, region in REGIONS.items()
    },
    **{
        f"rigid {name}": plate({"velocity": [0.0, 0.0, -1.0]}, region=region)
        for name, region in REGIONS.items()
    },
    **{
        f"grip in a {name}": held(region=region, velocity=[0.0, 0.0, 0.0])
        for name, region in REGIONS.items()
    },
}  # fmt: skip

#: Keys whose empty lists are as good as none.
AS_NONE = {"force", "velocity", "drift"}
#: Keys whose lists are of as many numbers as one likes.
OTHERS = {"parameters"}


def lists(value, path=()):
    """Paths of the lists of numbers in a case."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from lists(each, (*path, key))
    elif isinstance(value, list):
        if not any(isinstance(each, str | list | dict) for each in value):
            yield path
        for i, each in enumerate(value):
            yield from lists(each, (*path, i))


@pytest.mark.parametrize("part", PARTS)
def test_a_list_of_another_length_is_named(part, tmp_path, monkeypatch):
    """Also beside what indexes it: periodic faces, inflows, stages."""
    monkeypatch.chdir(tmp_path)
    case = {**BASE, **PARTS[part]}
    load(case)
    for path in lists(case):
        if path[-2:-1] == ("table",):
            continue  # rows [coordinate, factor]
        *where, key = path
        for change in (lambda v: v[:-1], lambda v: [*v, v[-1]], lambda v: v + v, lambda v: []):
            wrong = loads(dumps(case))
            holder = wrong
            for part_of in where:
                holder = holder[part_of]
            holder[key] = change(holder[key])
            with pytest.raises(CaseError) as caught:
                load(wrong)
                assert holder[key] == [] and key in AS_NONE
                raise CaseError(f"case: {'.'.join(map(str, path))}")
            # Where two lists do not fit each other, either is named.
            found = ".".join(one for one in path[:2] if isinstance(one, str))
            (line,) = str(caught.value).splitlines()
            assert line.startswith(f"case: {found}")


def test_every_list_of_the_schema_is_here():
    """A key that takes one number a direction is in a part above."""
    known = {
        [key for key in path if isinstance(key, str)][-1]
        for part in PARTS.values()
        for path in lists({**BASE, **part})
    }
    found = set()

    def numbers(schema):
        if not isinstance(schema, dict):
            return False
        if schema.get("type") in ("number", "integer"):
            return True
        return any(numbers(one) for key in ("anyOf", "oneOf") for one in schema.get(key, ()))

    def walk(schema, name):
        if isinstance(schema, list):
            for each in schema:
                walk(each, name)
        elif isinstance(schema, dict):
            if schema.get("type") == "array" and numbers(schema.get("items")):
                found.add(name)
            for key, value in schema.items():
                if key in ("properties", "$defs"):
                    for one, below in value.items():
                        walk(below, one)
                else:
                    walk(value, name)

    walk(json_schema(), "")
    assert found - OTHERS <= known
    assert {"at", "size", "velocity", "gravity"} <= found
