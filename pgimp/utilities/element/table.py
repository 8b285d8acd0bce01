"""Results for a particle along its path: columns, exact ones beside them, and a picture."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from pgimp.errors import UsageError
from pgimp.physics.fields import TENSOR
from pgimp.physics.materials import Material
from pgimp.utilities.element.follow import follow
from pgimp.utilities.element.march import Array, Element
from pgimp.utilities.element.paths import legs, path_of

#: Columns beside which exact ones stand have these before their names.
EXACT = "exact-"
_COMPONENT = re.compile("-[xyz][xyz]$")


def curve(
    material: Material,
    name: str,
    values: list[float],
    steps: int,
    confine: float = 0.0,
    rate: float = 1.0,
) -> dict[str, Array]:
    """Return the table of a path, with a row for its start and one for each step.

    Parameters
    ----------
    material : Material
        The entry of the case.
    name : str
        Of the path.
    values : list of float
        Its targets, one after the other.
    steps : int
        To each of them.
    confine, rate : float
        Pressure before, 0 for that at which the material starts; rate of the value.

    Returns
    -------
    dict of str to (n,) float64
        By the names of columns: value, time, det-F, stresses, pressure, q (positive), states; where
        the material knows the exact curve, its columns too, with ``exact-`` before their names,
        nan in rows that it does not cover.

    Raises
    ------
    UsageError
        If the path cannot be: without a stress across where the material has to be pressed.
    RunError
        If no strain gives the stress that the path prescribes.
    """
    element = Element(material)
    path = path_of(name)
    along = legs(values, steps)
    pressure = _pressure(material, name, confine)
    rows, F, times = follow(element, path, along, pressure, rate)
    sigma = element.stress(rows)
    xx, yy, zz, xy, yz, xz = sigma.T
    shear = 3.0 * (xy**2 + yz**2 + xz**2)
    table = {
        "value": np.concatenate([[0.0], along]),
        "time": times,
        "det-F": np.linalg.det(F),
        **{f"stress-{part}": sigma[:, i] for i, part in enumerate(TENSOR.split())},
        "pressure": -(xx + yy + zz) / 3.0,
        "q": np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + shear),
    }
    for state, found in element.states(rows).items():
        if found.ndim == 1:
            table[state] = found
        else:
            table |= {
                f"{state}-{part}": found[:, i]
                for i, part in enumerate(TENSOR.split()[: found.shape[1]])
            }
    with np.errstate(all="ignore"):  # What is beyond a curve's range is not finite, so not known.
        exact = material.exact_path(name, table["value"], rate, pressure) or {}
    return table | {
        f"{EXACT}{column}": np.where(np.isfinite(found), found, np.nan)
        for column, found in exact.items()
        if column in table and np.isfinite(found).any()
    }


def _pressure(material: Material, name: str, confine: float) -> float:
    """Return the pressure from all sides at which a path begins, after checking that it can."""
    pressure = confine or material.initial_pressure
    if name == "uniaxial-stress" and pressure:
        raise UsageError(
            "--path uniaxial-stress: there is no stress across, but the material begins under a "
            f"pressure of {pressure:g}; --path triaxial keeps that across"
        )
    if name in ("uniaxial-stress", "triaxial") and not pressure and material.needs_pressure:
        raise UsageError(
            f"--path {name}: without pressure the material has no stress to bear this with; begin "
            "under one, --path triaxial --confine PRESSURE"
        )
    return pressure


def errors(table: dict[str, Array]) -> dict[str, float]:
    """Return the greatest difference from each exact column, over its greatest value.

    Of stresses, which may all but vanish beside others, that is the greatest of all stresses.
    """
    exact = {name.removeprefix(EXACT): table[name] for name in table if name.startswith(EXACT)}
    sizes = {name: float(np.nanmax(np.abs(column))) for name, column in exact.items()}
    stresses = [name for name in exact if name in ("pressure", "q") or name.startswith("stress-")]
    greatest = max((sizes[name] for name in stresses), default=0.0)
    sizes |= dict.fromkeys(stresses, greatest)
    return {
        name: float(np.nanmax(np.abs(table[name] - column))) / (sizes[name] or 1.0)
        for name, column in exact.items()
    }


def text(table: dict[str, Array]) -> str:
    """Return the table as CSV, with all digits; nothing where an exact curve is not known."""
    lines = [",".join(table)]
    columns = (values.tolist() for values in table.values())
    lines += [
        ",".join("" if number != number else repr(number) for number in row)
        for row in zip(*columns, strict=True)
    ]
    return "\n".join(lines) + "\n"


def draw(table: dict[str, Array], name: str, title: str) -> Any:
    """Return a figure of the path's stress and of the material's state, first of all scalars."""
    from matplotlib.figure import Figure

    from pgimp.utilities.plot.style import COLOURS, plain

    path = path_of(name)
    known = {"value", "time", "det-F", "pressure", "q"}
    states = [c for c in table if c not in known and not c.startswith((EXACT, "stress-"))]
    states = [c for c in states if np.ptp(table[c])]
    states = [c for c in states if not _COMPONENT.search(c)] or states[:3]
    shown = [path.component, *states[:5]]
    figure = Figure(figsize=(5.2 * min(len(shown), 2), 3.6 * ((len(shown) + 1) // 2)))
    for number, column in enumerate(shown):
        axes = figure.add_subplot((len(shown) + 1) // 2, min(len(shown), 2), number + 1)
        axes.plot(table["value"], table[column], color=COLOURS[0], label="pgimp")
        if EXACT + column in table:
            axes.plot(
                table["value"], table[EXACT + column], "--", color=COLOURS[1], label="exact"
            )
            axes.legend()
        axes.locator_params(axis="x", nbins=6)
        axes.set_xlabel(plain(path.meaning.partition(";")[0].partition(",")[0]))
        axes.set_ylabel(plain(column))
    figure.suptitle(plain(title))
    return figure
