"""Parameters of materials that vary in space, substituted for each particle.

In such a material `KernelScene` has `Own` in place of each number that varies. Derived parameters
(Lame's constants from Young's modulus) were computed when particles were created. They are in the
column `own`, in the order of each `Own` in the particle's material. The functions of materials get
numbers, or vectors of four, as without variation.
"""

from pgimp.jit.kernel import inlined, is_number, of_types
from pgimp.jit.own import count_own, filled
from pgimp.jit.tuples import read
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.transfer.lane_io import take_row


@of_types
def _width(materials):
    """Greatest number of varying parameters of a material."""
    return max(map(count_own, materials), default=0)


@inlined
def substitute_parameters(setting, particles, rows):
    """The setting with the materials' parameters of a particle, or of four: `rows` is a tuple then.

    Where nothing varies it is the setting itself.
    """
    width = _width(setting.materials)
    if not width:
        return setting
    like = (0.0,) * width
    own = particles.own
    values = read(own, rows, 0, like) if is_number(rows) else take_row(own, rows, 0, like)
    materials = tuple(filled(each, values) for each in setting.materials)
    return KernelScene(
        setting.shape, setting.frame, setting.identity, materials, setting.material_of,
        setting.tracked, setting.exits,
    )  # fmt: skip
