"""Units of quantities, from the case's label of its units."""

from __future__ import annotations

import math
import re

from pgimp.physics import columns, fields
from pgimp.physics.derived import DERIVED
from pgimp.solver.history.columns import HISTORY

_BASE = ("length", "mass", "time")
# Derived units with a name of their own, in consistent sets of length, mass and time.
_NAMES = {
    ("m", "kg", "s"): {"stress": "Pa", "energy": "J", "force": "N"},
    ("mm", "t", "s"): {"stress": "MPa", "energy": "mJ", "force": "N"},
    ("mm", "g", "ms"): {"stress": "MPa", "energy": "mJ", "force": "N"},
    ("mm", "kg", "ms"): {"stress": "GPa", "energy": "J", "force": "kN"},
    ("cm", "g", "us"): {"stress": "Mbar", "energy": "1e5 J", "force": "1e7 N"},
}
_FREQUENCIES = {"s": "Hz", "ms": "kHz", "us": "MHz"}
# Units that take a prefix; not those of a power.
_PREFIXES = {"n": -9, "u": -6, "m": -3, "c": -2, "": 0, "k": 3, "M": 6, "G": 9}
_SIMPLE = re.compile(r"([numckMG]?)(Pa|N|J|m|s)(/.*)?")
_SECTION = {1: "^2", 2: ""}
_EXTENSIVE = ("mass", "energy", "force")
_PLACES = {
    "AXIS": "[xyz]",
    "COMPONENT": "[xyz][xyz]",
    "FACE": "[xyz]-(min|max)",
    "NAME": r"[A-Za-z][\w-]*",
}


def unit(kind: str, units: str, dimension: int) -> str:
    """Return the unit of a kind of quantity.

    Parameters
    ----------
    kind : str
        As in the reference: ``stress``, ``length/time``, ``mass length^2/time``.
    units : str
        The case's label: units of length, mass and time.
    dimension : int
        1, 2 or 3; in 1D and 2D, totals are per section and per thickness. 3 also for rings, whose
        totals are all round.

    Returns
    -------
    str
        The unit; empty if there is none, or if the label is no list of three units.
    """
    base = tuple(part.strip() for part in units.split(","))
    if len(base) != 3 or not all(re.fullmatch(r"[A-Za-z]+", part) for part in base):
        return ""
    if kind in ("", "1"):
        return ""
    length, mass, time = base
    if kind == "frequency":
        return _FREQUENCIES.get(time, f"1/{time}")
    if kind == "mass/length^dimensions":
        kind = "mass/length^3"  # per section and per thickness are handled above and below
        dimension = 3
    words = dict(zip(_BASE, base, strict=True)) | _NAMES.get(
        (length, mass, time),
        {
            "stress": f"{mass}/({length} {time}^2)",
            "energy": f"{mass} {length}^2/{time}^2",
            "force": f"{mass} {length}/{time}^2",
        },
    )
    text = kind.replace("^dimensions", f"^{dimension}" if dimension > 1 else "")
    text = re.sub("|".join(words), lambda found: words[found[0]], text)
    if dimension < 3 and kind.startswith(_EXTENSIVE):
        section = length + _SECTION[dimension]
        text = f"{text} / {section}" if "/" in text else f"{text}/{section}"
    return re.sub(r"\^(\d)", r"$^\1$", text)


def kind_of_field(name: str) -> str:
    """Return the kind of a frame's field, empty if it has none."""
    known = fields.FIELDS.get(name)
    return _bracketed(known.meaning if known else columns.SURFACE.get(name, ""))


def kind_of_column(name: str) -> str:
    """Return the kind of a column of the history, a probe or a spectrum, empty if it has none."""
    if name == "frequency":
        return name
    units = {column.name: column.unit for group in HISTORY for column in group.columns}
    probes = columns.POINT | {name: mean.meaning for name, mean in columns.PLACE.items()}
    units |= {key: _bracketed(meaning) for key, meaning in probes.items()}
    for key, field in DERIVED.items():
        parts = [f"{key}-{part}" for part in field.components.split()] or [key]
        units |= dict.fromkeys(parts, _bracketed(field.meaning))
    for key, kind in units.items():
        pattern = re.sub("|".join(_PLACES), lambda found: _PLACES[found[0]], re.escape(key))
        if re.fullmatch(pattern.replace(r"\-(", "-("), name):
            return kind
    return ""


def _bracketed(meaning: str) -> str:
    found = re.search(r"\[([^\]]*)\]$", meaning)
    return found[1] if found else ""


def labelled(text: str, unit: str) -> str:
    """Return the label of an axis: ``stress xx [Pa]``."""
    return f"{text} [{unit}]" if unit else text


def scaled(unit: str, factor: float) -> str:
    """Return the unit of values that a power of ten multiplies: ``kN/m`` for N/m and 0.001.

    Returns
    -------
    str
        The unit with another prefix; empty if there is none, or if the unit is not simple. The
        sign of the factor is of no account.
    """
    found = _SIMPLE.fullmatch(unit)
    power = round(math.log10(abs(factor)))
    if not found or not math.isclose(abs(factor), 10.0**power, rel_tol=1e-12):
        return ""
    prefix, symbol, rest = found.groups()
    exponent = _PREFIXES[prefix] - power
    names = {number: name for name, number in _PREFIXES.items() if name != "c"}
    if exponent not in names or (symbol == "s" and exponent > 0):
        return ""
    return f"{names[exponent]}{symbol}{rest or ''}"
