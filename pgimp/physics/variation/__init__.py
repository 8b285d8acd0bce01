"""Parameters of materials that vary in space: by a table, layers, a column, at random.

In place of a number a case has a mapping that gives it from a particle's initial position,
``young: {table: [[0.0, 5e6], [10.0, 4e7]], over: depth, surface: 12.0}``. Each kind of variation
is a type here, with its values at positions. `pgimp.physics.materials.parameters.vary` inserts the
numbers into the material.
"""

from pgimp.physics.variation.along import LayersVariation, TableVariation
from pgimp.physics.variation.base import KINDS, VARIATION, NoValueError, Path, Places, Variation
from pgimp.physics.variation.column import FromColumn
from pgimp.physics.variation.own import OwnVariation
from pgimp.physics.variation.randomfield import RandomVariation

__all__ = ["KINDS", "VARIATION", "NoValueError", "Path", "Places", "TableVariation", "Variation"]

KINDS |= {
    "table": TableVariation,
    "layers": LayersVariation,
    "random": RandomVariation,
    "column": FromColumn,
    "function": OwnVariation,
}
