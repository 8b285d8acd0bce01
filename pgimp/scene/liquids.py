"""What `auto` means for liquids and gases: relaxation of velocities, walls that reflect."""

from __future__ import annotations

from typing import Any

#: Rate of relaxation over nu/h^2. It adds about a fifth of this part to the viscosity; what the
#: grid cannot resolve fades within the time that the flow across ten cells needs to develop.
VISCOUS = 0.01

#: Rate over c/h below which there is none: it would do nothing in ten thousands of steps.
MIN_RATE = 1e-5


def only_liquids(case: Any) -> list[Any]:
    """Return the bodies' materials if all are liquids, else none."""
    laws = [case.materials[body.material] for body in case.bodies.values()]
    return laws if all(law.LIQUID for law in laws) else []


def is_gas(law: Any) -> bool:
    """Whether a material is a gas: it bears no shear, and does not come to rest."""
    return bool(law.VOLUME_ONLY and not law.RESTS)


def _flow(case: Any) -> tuple[bool, bool]:
    """Whether all bodies are liquids or gases, and whether all are gases."""
    laws = [case.materials[body.material] for body in case.bodies.values()]
    gases = [is_gas(law) for law in laws]
    return all(gas or law.LIQUID for gas, law in zip(gases, laws, strict=True)), all(gases)


def relaxation_rate(case: Any) -> float:
    """Return the rate at which all particles' velocities relax to the grid's.

    By `auto` that of the least viscous liquid, if there is nothing but liquids.
    """
    if case.method.relaxation != "auto":
        return float(case.method.relaxation)
    least, laws = min(case.grid.cell), only_liquids(case)
    rates = [VISCOUS * law.shear_viscosity / (law.density * least**2) for law in laws]
    waves = [law.flow_speed / least for law in laws]
    if not rates or any(rate < MIN_RATE * c for rate, c in zip(rates, waves, strict=True)):
        return 0.0
    return float(min(rates))


def reflecting(case: Any) -> list[str]:
    """Return the faces that reflect the part of supports beyond them, by name.

    By `auto` those of liquids and gases alone. But not of shapes whose liquids lose nothing there,
    nor walls that let go: what they reflect comes and goes, and violent water crowds the more. A
    gas presses always, and without mirrors its pressure drives eddies out of rounding.
    """
    wall = getattr(case.method, "wall", "ghost")
    auto = wall == "auto"
    fluids, gases = _flow(case)
    if wall == "ghost" or (auto and not gases and (case.method.ends or not fluids)):
        return []
    return [
        name
        for name, face in case.boundaries.items()
        if face.mirrors and not (auto and face.releases and not gases)
    ]
