"""Parameters of materials that vary in space: put in for the particles that they belong to.

Of such a material `Setting` has `Own` in place of each number that varies. What follows from the
numbers of the case (Lame's constants from Young's modulus) was computed when particles were made,
and lies in their column `own`: first what belongs in place of the first `Own` of the particle's
material, and so on. The functions of materials see numbers, or vectors of four, as ever.
"""

from pgimp.jit.kernel import specialise
from pgimp.jit.own import count_own, filled
from pgimp.jit.tuples import read
from pgimp.kernels.batch import take_row
from pgimp.kernels.concepts import Setting


def _width(setting):
    """Numbers that the material with most of them has of its own."""
    materials = setting.types[setting.fields.index("materials")]
    return max(map(count_own, materials), default=0)


def _each_filled(materials, values):
    """Materials with values in place of each one's `Own`."""


@specialise(_each_filled)
def _each(materials, values):
    if len(materials) == 1:
        return lambda materials, values: (filled(materials[0], values),)
    return lambda materials, values: (
        filled(materials[0], values), *_each_filled(materials[1:], values),
    )  # fmt: skip


def _with_materials(setting, materials):
    """The setting with other materials."""


@specialise(_with_materials)
def _setting_with(setting, materials):
    return lambda setting, materials: Setting(
        setting.shape, setting.frame, setting.identity, materials, setting.material_of,
        setting.tracked, setting.exits,
    )  # fmt: skip


def with_own(setting, particles, rows):
    """The setting with the materials' parameters of four particles; itself if nothing varies."""


@specialise(with_own)
def _with_own(setting, particles, rows):
    width = _width(setting)
    if not width:
        return lambda setting, particles, rows: setting
    zeros = (0.0,) * width
    return lambda setting, particles, rows: _with_materials(
        setting, _each_filled(setting.materials, take_row(particles.own, rows, 0, zeros))
    )


def with_own_of(setting, particles, p):
    """As `with_own`, of one particle."""


@specialise(with_own_of)
def _with_own_of(setting, particles, p):
    width = _width(setting)
    if not width:
        return lambda setting, particles, p: setting
    zeros = (0.0,) * width
    return lambda setting, particles, p: _with_materials(
        setting, _each_filled(setting.materials, read(particles.own, p, 0, zeros))
    )
