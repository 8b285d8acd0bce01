"""The registry of warnings: by id, when they are given, and why."""

from __future__ import annotations

from typing import Literal, NamedTuple


class Kind(NamedTuple):
    """A kind of warning."""

    stage: Literal["check", "start"]
    """Whether `pgimp check` alone gives it, or a run as it starts, too."""
    reason: str
    bound: str
    """From what value on, or in which case, it is given."""


class Warned(str):
    """A warning that knows its id."""

    id: str

    def line(self, verbose: bool) -> str:
        """Return the line that tells it, with its id if `verbose`."""
        return f"warning: {f'[{self.id}] ' if verbose else ''}{self}"


def warned(id: str, text: str) -> Warned:
    """Return a warning of a registered kind."""
    assert id in WARNINGS, id
    warning = Warned(text)
    warning.id = id
    return warning


#: Reason of what is asked for and has no effect.
_IDLE = "what is asked for would not happen"

WARNINGS = {
    "load-strain": Kind("check", "units that do not fit each other", "strain by loads above 0.5"),
    "units": Kind("check", "units that do not fit each other",
        "a parameter far from that of any material"),
    "melting": Kind("check", "units of the heat",
        "a small plastic strain heats a metal above its melting point"),
    "short-run": Kind("check", "units of time", "a wave crosses less than 0.1 of a body"),
    "long-run": Kind("check", "units of time; an explicit method follows each wave",
        "a million travel times"),
    "sink": Kind("check", _IDLE, "a sink contains all of a body at the start"),
    "random-length": Kind("check", "a random field depends on the cells",
        "correlation length below a cell"),
    "affine-points": Kind("check", "points gain energy with `affine`", "`mpm` with `affine`"),
    "contact-points": Kind("check", "the gap between points jumps", "`mpm` with contact"),
    "thin-body": Kind("check", "stress and bending need several cells", "less than a cell across"),
    "thin-contact": Kind("check", "both sides of a body in one cell have no normal",
        "less than a cell across"),
    "few-cells": Kind("check", "`affine` adds energy on few cells", "less than 3 cells long"),
    "probe-place": Kind("check", _IDLE, "no particle within a cell of the place"),
    "probe-far": Kind("check", _IDLE, "the nearest particle is a spacing away"),
    "idle-traction": Kind("check", _IDLE, "a traction on a face that a wall holds"),
    "idle-interval": Kind("check", _IDLE, "an interval of output beyond the end"),
    "many-frames": Kind("check", "units of time", "more than 10,000 frames"),
    "series-end": Kind("check", "a series is held at its last value", "it ends before the run"),
    "short-step": Kind("check", "steps far below what waves need", "Courant number below 0.01"),
    "chosen-strain": Kind("check", "a method that was chosen for smaller strains",
        "strains of a pilot run beyond those for which a method was chosen"),
    "pilot-failed": Kind("check", "the run may fail as well", "a pilot run failed"),
    "pilot-step": Kind("check", "steps become unstable as waves become faster",
        "in a pilot run, see unstable-step"),
    "endless": Kind("check", "units of time", "a year of computing on this machine"),
    "tearing": Kind("check", "a body tears on the grid where it is stretched",
        "the stretch measured for it"),
    "impedance": Kind("check", "tools send waves of rho c v into the ground",
        "a fifth of the strength is left"),
    "bonded": Kind("check", "bodies share vertices, and are bonded",
        "at the start, without contact"),
    "unstable-step": Kind("start", "free surfaces become unstable",
        "the Courant number measured for the shape"),
    "locking": Kind("start", "pointwise volumes are too stiff", "Poisson's ratio above 0.45"),
    "overstress": Kind("start", "a stress that the material cuts", "beyond its strength"),
    "idle-constraint": Kind("start", _IDLE, "a later constraint in whose region nothing is"),
    "free-load": Kind("start", _IDLE, "body forces and water beside free rigid bodies"),
    "fast-rigid": Kind("start", "what is hit gets too little momentum",
        "above 0.3 of the wave speed"),
    "axis-edge": Kind("start", "contact sees an edge on the axis", "a section that ends there"),
    "through-plane": Kind("start", "a plane of symmetry has the other half move against it",
        "motion through slip"),
    "meeting": Kind("start", "bodies are bonded", "they may meet without contact"),
    "passing": Kind("start", "bodies pass through each other", "they may meet without contact"),
    "wall-reach": Kind("start", "walls act before they are touched", "within half the reach"),
    "wall-coming": Kind("start", "the run stops where a particle passes a wall",
        "in the initial configuration"),
    "tied": Kind("start", "material is bonded to rigid bodies", "they may meet without contact"),
    "absorbing-weight": Kind("start", "absorbing faces bear no weight that begins at once",
        "gravity without a start"),
    "low-wave": Kind("start", "low waves slow down and die", "crests of less than 0.5 cells"),
}  # fmt: skip
"""All kinds of warnings about a case, by id."""
