"""Evaluation of a material step by step, with the compiled functions of a run's kernels."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydantic import ValidationError

from pgimp.errors import UsageError
from pgimp.kernels.once.march import march
from pgimp.physics.materials import MATERIALS, Material
from pgimp.physics.materials.base import state_width, states_of
from pgimp.physics.materials.parameters.outside import parameters_of
from pgimp.schema.messages import unknown

Array = np.ndarray


def entry_of(material: Material | Mapping[str, object]) -> Material:
    """Return the entry of a material, given as an entry or as in a case.

    Raises
    ------
    UsageError
        If it is no material.
    """
    if isinstance(material, Material):
        return material
    if not isinstance(material, Mapping):
        raise UsageError(
            "a material is an entry, as pgimp.load(CASE).materials[NAME], or a mapping as in a "
            f"case, {{'model': ..., 'density': ...}}; got {type(material).__name__}"
        )
    model = str(material.get("model"))
    if model not in MATERIALS:
        raise UsageError(unknown("model", model, MATERIALS))
    try:
        return MATERIALS[model].model_validate(dict(material))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the material"
        raise UsageError(f"{where}: {first['msg']}") from None


class Element:
    """A particle of a material, deformed step by step.

    Parameters
    ----------
    material : Material
        The entry.
    dimensions : int, optional
        1, 2 or 3; by default the most that the material supports.

    Raises
    ------
    UsageError
        If the material varies in space.

    Attributes
    ----------
    row : (columns,) float64
        Stress, then state.
    F : (D, D) float64
        Deformation gradient.
    speed : float
        Speed of the fastest wave after the last step.
    """

    def __init__(self, material: Material, dimensions: int | None = None) -> None:
        if material.variations:
            keys = ", ".join(".".join(path) for path in material.variations)
            raise UsageError(
                f"{keys} of the material varies in space: say where it is wanted, --at x,y (in "
                "Python material.at((x, y)))"
            )
        self.dimensions = dimensions or max(material.DIMENSIONS)
        self.material = material
        self.parameters = parameters_of(material, self.dimensions)
        kind = type(self.parameters)
        self.components = (3, 4, 6)[self.dimensions - 1]
        width = self.components + state_width(kind, self.dimensions)
        self.row = np.zeros(width)
        if pressure := material.initial_pressure:
            self.row[:3] = -pressure
        at = self.components
        #: Columns of the state variables in a row.
        self.places: dict[str, slice] = {}
        for state in states_of(kind):
            place = slice(at, at + state.width(self.dimensions))
            start = state.initial
            self.row[place] = getattr(self.parameters, start) if isinstance(start, str) else start
            self.places[state.name], at = place, place.stop
        self.F = np.eye(self.dimensions)
        self.speed = np.nan

    def tried(self, F: Array, dt: float | Array) -> tuple[Array, Array]:
        """Return the state after trial steps, without updating the particle.

        Parameters
        ----------
        F : (n, D, D) float64
            Deformation gradients at the end of each step.
        dt : float or (n,) float64
            Lengths of the steps.

        Returns
        -------
        rows : (n, columns) float64
            Stress and state.
        speeds : (n,) float64
            Speed of the fastest wave.
        """
        F = np.ascontiguousarray(F, dtype=float)
        n, D = len(F), self.dimensions
        steps = np.broadcast_to(np.asarray(dt, dtype=float), (n,)).copy()
        before = np.concatenate([self.F[None], F[:-1]])
        # The step's gradient, as in the kernels: F = (1 + dt L) F_before.
        change = np.linalg.solve(before.transpose(0, 2, 1), (F - before).transpose(0, 2, 1))
        L = np.ascontiguousarray(change.transpose(0, 2, 1)) / steps[:, None, None]
        found, speed = np.zeros((n + 1, len(self.row))), np.zeros(n)
        found[0] = self.row
        if self.material.VOLUME_ONLY:
            F = np.eye(D) * np.linalg.det(F)[:, None, None] ** (1.0 / D)
        F, L = F.reshape(n, D * D), L.reshape(n, D * D)
        likes = (0.0,) * D * D, (0.0,) * len(self.row)
        march((self.parameters,), F, L, steps, found, speed, *likes)
        return found[1:], speed

    def advance(self, F: Array, dt: float | Array) -> Array:
        """Do steps, see `tried`; return stress and state after each."""
        rows, speeds = self.tried(F, dt)
        self.row, self.F, self.speed = rows[-1].copy(), np.array(F[-1]), float(speeds[-1])
        return rows

    def stress(self, rows: Array) -> Array:
        """Return the stress of rows, (n, 6) as xx yy zz xy yz xz."""
        full = np.zeros((len(rows), 6))
        full[:, : self.components] = rows[:, : self.components]
        return full

    def states(self, rows: Array) -> dict[str, Array]:
        """Return the state variables of rows, (n,) or (n, components) each."""
        found = {}
        for name, place in self.places.items():
            values = rows[:, place]
            found[name] = values[:, 0] if values.shape[1] == 1 else values
        return found


def element(
    material: Material | Mapping[str, object], F: Array, dt: float | Array = 1.0
) -> dict[str, Array]:
    """Return the response of a material along a path, without a grid.

    Parameters
    ----------
    material : Material or mapping
        The entry of a case, ``pgimp.load(CASE).materials[NAME]``, or its content,
        ``{"model": "von-mises", "young": 2e11, ...}``.
    F : (n, D, D) array_like of float
        Deformation gradients at the end of each step, starting from 1. D is 3, or less for a case
        of fewer dimensions.
    dt : float or (n,) array_like
        Lengths of the steps.

    Returns
    -------
    dict of str to ndarray
        ``stress`` (n, 6), Cauchy, as xx yy zz xy yz xz; ``wave-speed`` (n,). Each state variable
        by its name, (n,), or (n, components) for a tensor.

    Raises
    ------
    UsageError
        If the material or F is invalid.
    """
    entry = entry_of(material)
    path = np.asarray(F, dtype=float)
    if path.ndim != 3 or path.shape[1] != path.shape[2] or path.shape[1] not in (1, 2, 3):
        raise UsageError(f"F must be of the shape (n, D, D) with D from 1 to 3, got {path.shape}")
    if path.shape[1] not in entry.DIMENSIONS:
        allowed = " and ".join(f"{d}D" for d in entry.DIMENSIONS)
        raise UsageError(f"the material exists in {allowed} only, but F is of {path.shape[1]}D")
    if not np.isfinite(path).all() or (np.linalg.det(path) <= 0.0).any():
        raise UsageError("F: every matrix must be finite and have a determinant above 0")
    steps = np.asarray(dt, dtype=float)
    if steps.shape not in ((), (len(path),)) or not (steps > 0.0).all():
        raise UsageError("dt: one number above 0, or one for each step")
    one = Element(entry, path.shape[1])
    if len(path) == 0:
        rows, speeds = np.zeros((0, len(one.row))), np.zeros(0)
    else:
        rows, speeds = one.tried(path, steps)
    return {"stress": one.stress(rows), **one.states(rows), "wave-speed": speeds}
