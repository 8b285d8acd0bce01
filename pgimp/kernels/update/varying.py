"""Parameters of materials that vary in space, substituted for each particle.

In such a material `KernelScene` has `Own` in place of each number that varies. Derived parameters
(Lame's constants from Young's modulus) were computed when particles were created. They are in the
column `own`, in the order of each `Own` in the particle's material. The functions of materials get
numbers, or vectors of four, as without variation.
"""

from numba.core import types

from pgimp.jit.kernel import inlined, specialise
from pgimp.jit.own import count_own, filled
from pgimp.jit.tuples import read
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.transfer.lane_io import take_row


def _width(setting):
    """Greatest number of varying parameters of a material."""
    materials = setting.types[setting.fields.index("materials")]
    return max(map(count_own, materials), default=0)


@inlined
def _each_filled(materials, values):
    """Materials with values in place of each one's `Own`."""
    if len(materials) == 1:
        return (filled(materials[0], values),)
    return (filled(materials[0], values), *_each_filled(materials[1:], values))


@inlined
def _with_materials(setting, materials):
    """The setting with other materials."""
    return (KernelScene(
        setting.shape, setting.frame, setting.identity, materials, setting.material_of,
        setting.tracked, setting.exits,
    ))  # fmt: skip


def _values(own, rows, like):
    """Leading numbers of the column `own`, as many as `like` has: of a particle, or of four."""


@specialise(_values)
def _values_of(own, rows, like):
    if isinstance(rows, types.Integer):
        return lambda own, rows, like: read(own, rows, 0, like)
    return lambda own, rows, like: take_row(own, rows, 0, like)


def substitute_parameters(setting, particles, rows):
    """The setting with the materials' parameters of a particle, or of four: `rows` is a tuple then.

    Where nothing varies it is the setting itself.
    """


@specialise(substitute_parameters)
def _with_own(setting, particles, rows):
    width = _width(setting)
    if not width:
        return lambda setting, particles, rows: setting
    zeros = (0.0,) * width
    return lambda setting, particles, rows: _with_materials(
        setting, _each_filled(setting.materials, _values(particles.own, rows, zeros))
    )
