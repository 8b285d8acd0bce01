"""Results for a particle along its path: columns, exact columns, and a figure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import UsageError
from pgimp.physics.fields import TENSOR
from pgimp.physics.materials import Material
from pgimp.utilities.element.follow import follow
from pgimp.utilities.element.march import Array, Element
from pgimp.utilities.element.paths import legs, path_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Prefix of exact columns.
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
        Name of the path.
    values : list of float
        Target values, in order.
    steps : int
        Number of steps to each value.
    confine, rate : float
        Confining pressure, 0 for the material's initial pressure; rate of the value.

    Returns
    -------
    dict of str to (n,) float64
        Columns by name: value, time, det-F, stresses, pressure, q (positive), states. If the
        material has an exact curve, also its columns with the prefix ``exact-``, nan in rows that
        it does not cover.

    Raises
    ------
    UsageError
        If the path is impossible: no confining pressure for a material that needs pressure.
    RunError
        If no strain gives the path's prescribed stress.
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
    with np.errstate(all="ignore"):  # Values beyond a curve's range are not finite.
        exact = material.exact_path(name, table["value"], rate, pressure) or {}
    return table | {
        f"{EXACT}{column}": np.where(np.isfinite(found), found, np.nan)
        for column, found in exact.items()
        if column in table and np.isfinite(found).any()
    }


def _pressure(material: Material, name: str, confine: float) -> float:
    """Return the isotropic pressure at a path's beginning, after checking that it is possible."""
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
    """Return the greatest difference from each exact column, over the column's greatest value.

    For stresses it is over the greatest of all stresses, as a single one may nearly vanish.
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
    """Return the table as CSV, with all digits; empty entries where exact values are unknown."""
    lines = [",".join(table)]
    columns = (values.tolist() for values in table.values())
    lines += [
        ",".join("" if number != number else repr(number) for number in row)
        for row in zip(*columns, strict=True)
    ]
    return "\n".join(lines) + "\n"


def draw(table: dict[str, Array], name: str, title: str) -> Figure:
    """Return a figure of the path's stress and of the material's state, preferably a scalar."""
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
            axes.plot(table["value"], table[EXACT + column], "--", color=COLOURS[1], label="exact")
            axes.legend()
        axes.locator_params(axis="x", nbins=6)
        axes.set_xlabel(plain(path.meaning.partition(";")[0].partition(",")[0]))
        axes.set_ylabel(plain(column))
    figure.suptitle(plain(title))
    return figure
