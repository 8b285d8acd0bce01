"""Materials that vary in space: the parameters of each particle."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.regions import Points
from pgimp.physics.fields import Field, Source
from pgimp.physics.materials.parameters.layout import Layout, layout_of
from pgimp.physics.materials.parameters.outside import parameters_of
from pgimp.physics.materials.parameters.states import initial_row
from pgimp.physics.materials.parameters.vary import field_of, first_text
from pgimp.physics.variation import NoValueError, Places, TableVariation
from pgimp.physics.variation.find import described, value_at
from pgimp.scene.bodies.lattice import ParticleBlock

Reals = np.ndarray


class ParticleParameters(NamedTuple):
    """Parameters of particles whose material varies, (n, ...) each."""

    #: (n, width) float64: Parameters of the kernels that vary, and values of the case.
    columns: Reals
    #: density, pressure: (n,) float64: At the start.
    density: Reals
    pressure: Reals
    state: Reals  #: (n, k) float64: State at the start.
    values: Reals  #: (n, keys) float64: Values of the varying keys.


class Variations:
    """Varying parameters of a scene; false where there are none.

    Parameters
    ----------
    names : list of str
        Names of the materials in use.
    materials : tuple of NamedTuple
        Their parameters, with typical values.
    states : int
        Number of state variables of a particle.

    Attributes
    ----------
    width : int
        Number of columns of a particle.
    materials : tuple of NamedTuple
        The parameters with `Own` in place of varying ones, for kernels.
    typical : (materials, width) float64
        Columns of a typical particle.
    fields : dict of str to Field
        Fields of varying parameters for frames: nan for particles of materials without them.
    """

    def __init__(self, case: Case, names: list[str], materials: tuple[Any, ...], states: int):
        self.case, self.names, self._states = case, names, states
        entries = [case.materials[name] for name in names]
        self.layouts: list[Layout | None] = [
            layout_of(entry, lambda one: parameters_of(one, case.dimensions))
            if entry.variations
            else None
            for entry in entries
        ]
        self.width = max((one.width for one in self.layouts if one), default=0)
        self.materials = tuple(
            one if layout is None else layout.marked
            for one, layout in zip(materials, self.layouts, strict=True)
        )
        self.typical = np.zeros((len(names), self.width))
        for i, (entry, layout) in enumerate(zip(entries, self.layouts, strict=True)):
            if layout:
                values = [value_at(entry, path) for path in layout.paths]
                self.typical[i, : layout.width] = layout.packer()(materials[i], values)
        paths = {path for layout in self.layouts if layout for path in layout.paths}
        self.fields = {field_of(path): self._field(path) for path in sorted(paths)}

    def __bool__(self) -> bool:
        """Return whether anything varies."""
        return any(self.layouts)

    def _field(self, path: tuple[str, ...]) -> Field:
        """Field of a parameter that varies in at least one material."""
        index, constant, meaning = [], [], ""
        for name, layout in zip(self.names, self.layouts, strict=True):
            varies = layout is not None and path in layout.paths
            index.append(layout.indices[layout.paths.index(path)] if layout and varies else -1)
            constant.append(np.nan if varies else _constant(self.case.materials[name], path))
            if varies:
                meaning = meaning or described(type(self.case.materials[name]), path)
        columns, constants = np.array(index), np.array(constant)

        def values(source: Source) -> Reals:
            number = np.asarray(source.body_material)[source.take("body")]
            table, column = source.take("own"), columns[number]
            rows = np.arange(len(table))
            return np.where(column < 0, constants[number], table[rows, np.maximum(column, 0)])

        return Field(values, f"{'.'.join(path)} of the particle's material: {meaning}")

    def of(self, block: ParticleBlock, material: int) -> ParticleParameters | None:
        """Return the particles' own parameters; None if their material is uniform.

        Raises
        ------
        CaseError
            If a parameter has no value, or an invalid one, at a particle.
        """
        layout = self.layouts[material]
        if layout is None:
            return None
        with located(self.case):
            return self._of(block, material, layout)

    def _of(self, block: ParticleBlock, material: int, layout: Layout) -> ParticleParameters:
        body = list(self.case.bodies)[block.body]
        name = self.names[material]
        entry = self.case.materials[name]
        columns = {key: table[:, 0] for key, table in block.states.items() if table.shape[1] == 1}
        points = Places(block.centroids, columns)
        values = np.empty((len(block.ids), len(layout.paths)))
        for j, path in enumerate(layout.paths):
            try:
                values[:, j] = entry.variations[path].values(points)
            except NoValueError as error:
                raise CaseError(
                    f"materials.{name}.{'.'.join(path)}: {self._particle(block, error.row, body)} "
                    f"{error}"
                ) from None
        distinct, which = np.unique(values, axis=0, return_inverse=True)
        which, make, pack = which.reshape(-1), entry.maker(), layout.packer()
        found = ParticleParameters(
            np.zeros((len(distinct), self.width)),
            np.empty(len(distinct)),
            np.empty(len(distinct)),
            np.zeros((len(distinct), self._states)),
            distinct,
        )
        for i, row in enumerate(distinct.tolist()):
            try:
                one: Any = make(dict(zip(layout.paths, row, strict=True)))
                parameters = one.parameters()
                carried = pack(parameters, row)
                if carried is None:
                    raise CaseError(
                        "with that the law is another one than elsewhere (a viscosity or a "
                        "hardening is 0 at some places only, a limit sets in): give such a part a "
                        "body and a material of its own"
                    )
            except Exception as error:  # a user's own material may raise anything
                particle = self._particle(block, int(np.argmax(which == i)), body)
                raise CaseError(_refused(name, layout, row, particle, error)) from None
            found.columns[i, : layout.width] = carried
            found.density[i], found.pressure[i] = parameters.density, one.initial_pressure
            found.state[i] = initial_row(parameters, self.case.dimensions, self._states)
        return ParticleParameters(*(part[which] for part in found))

    def _particle(self, block: ParticleBlock, row: int, body: str) -> str:
        """Name a particle, by the line of its file or by its position."""
        position = ", ".join(f"{x:.6g}" for x in block.positions[row])
        region = self.case.bodies[body].region
        text = f"the particle at ({position}) of body '{body}'"
        if isinstance(region, Points) and block.rows is not None:
            lines = region.lines([int(block.rows[row])])
            text += "".join(f", {line} of {region.file}," for line in lines)
        return text

    def entry(self, material: int, own: Reals) -> Any:
        """Return the entry of a particle's material with its own parameters, from column `own`."""
        layout, entry = self.layouts[material], self.case.materials[self.names[material]]
        if layout is None:
            return entry
        return entry.maker()(dict(zip(layout.paths, layout.values(own), strict=True)))


def _refused(name: str, layout: Layout, row: list[float], particle: str, error: Exception) -> str:
    """Describe a particle's invalid value."""
    if isinstance(error, ValidationError):
        where = error.errors(include_url=False)[0]["loc"]
        key, text = ".".join((name, *map(str, where))), first_text(error)
    else:
        known = type(error) is CaseError
        key, text = name, str(error) if known else f"{type(error).__name__}: {error}"
    return f"materials.{key}: {particle} has {_listed(layout, row)}: {text}"


def _listed(layout: Layout, row: list[float]) -> str:
    return ", ".join(
        f"{'.'.join(path)} {value:.6g}" for path, value in zip(layout.paths, row, strict=True)
    )


def _constant(entry: Any, path: tuple[str, ...]) -> float:
    """A number of a material if present, else nan."""
    try:
        value = value_at(entry, path)
    except StopIteration:
        return np.nan
    return np.nan if value is None else float(value)


def tables(case: Case) -> list[tuple[str, TableVariation]]:
    """Tables from files, each with the key of its parameter."""
    return [
        (f"materials.{name}.{'.'.join(path)}", part)
        for name, entry in case.materials.items()
        for path, variation in entry.variations.items()
        for part in variation.parts()
        if isinstance(part, TableVariation) and part.from_file
    ]
