"""Material parameters in SI units, where the case names its units, and warnings about them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pgimp.physics.materials.johnson_cook import JohnsonCook
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.warned import Warned, warned
from pgimp.scene.mass_scaling import inertia_factor

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.physics.materials.base import Material

_LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "um": 1e-6, "µm": 1e-6, "in": 0.0254}
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
_MASSES = {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "tonne": 1e3, "Mg": 1e3}

#: Units by the endings of key descriptions: powers of length, mass and time, and the name in SI.
_UNITS = {
    "mass/volume": ((-3, 1, 0), "kg/m^3"),
    "stress": ((-1, 1, -2), "Pa"),
    "stress time": ((-1, 1, -1), "Pa s"),
    "1/time": ((0, 0, -1), "1/s"),
    "length": ((1, 0, 0), "m"),
    "energy/mass": ((2, 0, -2), "J/kg"),
    "energy/(mass temperature)": ((2, 0, -2), "J/(kg K)"),
    "temperature": ((0, 0, 0), "K"),
}
#: Ranges of all materials, widened: from aerogel to osmium, jelly to diamond, and metals at their
#: coldest to hydrogen. Moduli of water and soil are often reduced on purpose, to slow the waves.
_RANGES = {
    "density": (0.5, 3.0e4),
    "young": (1.0, 3.0e12),
    "bulk": (1.0, 3.0e12),
    "specific-heat": (20.0, 2.0e4),
}
#: Wave speeds [m/s], from jelly to diamond; widened.
_WAVES = (0.05, 3.0e4)
#: Plastic strain within which no metal melts by its own work.
_NO_MELTING = 0.2
_LAST = re.compile(r"\[([^\]]+)\]$")


def scales(units: str) -> tuple[float, float, float] | None:
    """Metres, kilograms and seconds of the units of length, mass and time; None if not known."""
    words = re.split(r"[\s,;]+", units.strip())
    if units.strip() == "SI":
        words = ["m", "kg", "s"]
    length, mass, time = (
        next((table[word] for word in words if word in table), None)
        for table in (_LENGTHS, _MASSES, _TIMES)
    )
    return (length, mass, time) if length and mass and time else None


def in_si(case: Case, name: str) -> dict[str, tuple[float, str]]:
    """Material parameters in SI units, by key: value and unit; empty if units are unknown.

    Parameters that vary in space, or have no unit, are left out.
    """
    known = scales(case.units)
    if known is None:
        return {}
    found, entry = {}, case.materials[name]
    for field, info in type(entry).model_fields.items():
        value, unit = getattr(entry, field), _LAST.search(info.description or "")
        if isinstance(value, bool) or not isinstance(value, float | int) or not value:
            continue
        if unit and unit[1] in _UNITS:
            powers, label = _UNITS[unit[1]]
            factor = 1.0
            for scale, power in zip(known, powers, strict=True):
                factor *= scale**power
            found[(info.alias or field).replace("_", "-")] = (value * factor, label)
    return found


def unlikely(case: Case, body: BodyFacts) -> Iterator[Warned]:
    """Yield warnings of implausible values, in units with a known label, such as "mm, t, s"."""
    name = case.bodies[body.name].material
    entry, known = case.materials[name], scales(case.units)
    found = in_si(case, name)
    if known:
        length, mass, time = known
        factor = inertia_factor(case)
        if "density" in body.varies:
            found["density"] = (body.density * mass / length**3, "kg/m^3")
        if "density" in found:
            found["density"] = (found["density"][0] / factor, "kg/m^3")
        for key, limits in _RANGES.items():
            if key in found and not limits[0] <= found[key][0] <= limits[1]:
                value, unit = found[key]
                given = value if key not in body.varies else body.density
                given = getattr(entry, key.replace("-", "_"), given)
                given = given if isinstance(given, float | int) else body.density
                number = f"{given / factor if key == 'density' else given:g}"
                yield warned(
                    "units",
                    f"materials.{name}.{key}: {number} would be {value:.3g} {unit} in the units "
                    f"'{case.units}', which no material has; is it given in them?",
                )
        speed = body.wave_speed * factor**0.5
        wave = speed * length / time
        if not _WAVES[0] <= wave <= _WAVES[1]:
            stiff = "young" if hasattr(entry, "young") else "bulk"
            yield warned(
                "units",
                f"materials.{name}: wave speed {speed:.4g} would be {wave:.3g} m/s in "
                f"the units '{case.units}', which no material has; are {stiff} and density given "
                "in them?",
            )
    yield from _melting(name, entry)


def _melting(name: str, entry: Material) -> Iterator[Warned]:
    """Warn of a metal that would melt by the work of a small plastic strain."""
    if not isinstance(entry, JohnsonCook):
        return
    numbers = (entry.a, entry.density, entry.specific_heat, entry.melting, entry.temperature)
    if not all(isinstance(each, float | int) for each in (*numbers, entry.taylor_quinney)):
        return
    heat = entry.taylor_quinney * entry.a / (entry.density * entry.specific_heat)
    if heat * _NO_MELTING > entry.melting - entry.temperature:
        strain = (entry.melting - entry.temperature) / heat
        yield warned(
            "melting",
            f"materials.{name}.specific-heat: a plastic strain of {strain:.2g} would heat it above "
            "melting; are a, density and specific-heat in one consistent set of units?",
        )
