"""Words of the trades: what other programs call something, and what no key of pgimp is for."""

from __future__ import annotations

from collections.abc import Collection

#: What words of other programs are called here; the first that may stand in a place is meant.
MEANT = {
    "elastic": ("hooke", "neo-hookean"),
    "linear-elastic": ("hooke",),
    "isotropic": ("hooke",),
    "hyperelastic": ("neo-hookean",),
    "elastoplastic": ("von-mises",),
    "plastic": ("von-mises",),
    "j2": ("von-mises",),
    "mises": ("von-mises",),
    "mcc": ("cam-clay",),
    "water": ("newtonian",),
    "fluid": ("newtonian",),
    "gas": ("ideal-gas",),
    "symmetry": ("slip",),
    "symmetric": ("slip",),
    "roller": ("slip",),
    "free-slip": ("slip",),
    "no-slip": ("fixed",),
    "sticky": ("fixed",),
    "clamped": ("fixed",),
    "separating": ("unilateral",),
    "lysmer": ("absorbing",),
    "viscous-boundary": ("absorbing",),
    "outflow": ("remove",),
    "outlet": ("remove",),
    "inlet": ("inflow",),
    "cfl": ("courant",),
    "dt": ("step",),
    "e": ("young",),
    "youngs-modulus": ("young",),
    "elastic-modulus": ("young",),
    "nu": ("poisson",),
    "poissons-ratio": ("poisson",),
    "rho": ("density",),
    "mu": ("friction", "shear-viscosity"),
    "ppc": ("particles-per-cell",),
    "axisymmetric": ("geometry",),
    "plane-strain": ("geometry",),
    "plane-stress": ("geometry",),
    "pic": ("pic-damping",),
    "srf": ("strength-reduction",),
    "tied": ("tie",),
    "bonded": ("tie",),
    "frictional": ("friction",),
    "mean-dilatation": ("b-bar",),
}

_WATER = "water in pores is at rest: it neither seeps nor builds up excess pressure"
_HEAT = "heat does not flow"
_FAILED = "failed particles keep their place, and are not removed"
_THIN = "there are no shells and beams: bodies have particles through their thickness"

#: What pgimp does not compute, by words that ask for it.
BEYOND = {
    **dict.fromkeys(
        (
            "permeability",
            "seepage",
            "consolidation",
            "pore-pressure",
            "drained",
            "undrained",
            "biot",
        ),
        _WATER,
    ),
    **dict.fromkeys(
        ("conductivity", "temperature", "heat", "heat-flux", "thermal", "convection", "expansion"),
        _HEAT,
    ),
    **dict.fromkeys(("erosion", "element-deletion"), _FAILED),
    **dict.fromkeys(("shell", "shells", "beam", "membrane", "truss"), _THIN),
    **dict.fromkeys(
        ("spring-back", "springback", "implicit", "newmark"),
        "there are no implicit steps; settle finds states of rest, as after a spring-back, by "
        "steps in time",
    ),
    **dict.fromkeys(
        ("fracture", "fracture-energy", "cohesive-zone"), "failure has no length of its own"
    ),
    **dict.fromkeys(("gpu", "cuda"), "it runs on cores of CPUs"),
    **dict.fromkeys(("surface-tension", "turbulence"), "its fluids have pressure and viscosity"),
    **dict.fromkeys(("self-contact",), "a body does not meet itself"),
}


def folded(name: str) -> str:
    """Return a word as the tables have it: in lower case, with hyphens."""
    return name.strip().casefold().replace("_", "-").replace(" ", "-").replace("'", "")


def meant_by(name: str, known: Collection[str]) -> list[str]:
    """Return the known names for which other programs have the word `name`."""
    return [each for each in MEANT.get(folded(name), ()) if each in known]


def beyond(name: str) -> str:
    """Return why nothing in pgimp is called so; empty for words that ask for nothing else."""
    word = folded(name)
    parts = {word, *word.split("-")}
    return next((text for key, text in BEYOND.items() if key in parts), "")
