"""Numba types of vectors and of their masks, and the LLVM values of vectors and numbers."""

from collections.abc import Iterable

from llvmlite import ir
from numba.core import types
from numba.extending import models, register_model

from pgimp.jit.kernel import of_types
from pgimp.jit.outside import NumbaObject

DOUBLES = ir.VectorType(ir.DoubleType(), 4)
LANE = ir.IntType(32)


class VectorType(types.Type):
    """Numba's type of a vector of `lanes` float64."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"Vec{lanes}")


class MaskType(types.Type):
    """Numba's type of `lanes` truth values."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"Mask{lanes}")


vec4, vec8 = VectorType(4), VectorType(8)
MASKS = {kind: MaskType(kind.lanes) for kind in (vec4, vec8)}


@of_types
def is_vector(kind: NumbaObject) -> bool:
    """Whether a Numba type is that of a vector."""
    return isinstance(kind, VectorType)


@of_types
def is_mask(kind: NumbaObject) -> bool:
    """Whether a Numba type is that of the truth values of a vector's elements."""
    return isinstance(kind, MaskType)


def common(kinds: Iterable[NumbaObject]) -> NumbaObject:
    """The type of a result of vectors and numbers: the vectors', or float64."""
    return next(filter(is_vector, kinds), types.float64)


def llvm_type(kind: NumbaObject) -> ir.Type:
    """LLVM's type of a vector or a number."""
    return ir.VectorType(ir.DoubleType(), kind.lanes) if is_vector(kind) else ir.DoubleType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, llvm_type(fe_type))


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, ir.VectorType(ir.IntType(1), fe_type.lanes))


def splat(builder, value, lanes):
    """The LLVM vector of a number."""
    undefined = ir.Constant(ir.VectorType(ir.DoubleType(), lanes), ir.Undefined)
    first = builder.insert_element(undefined, value, ir.Constant(LANE, 0))
    mask = ir.Constant(ir.VectorType(LANE, lanes), [0] * lanes)
    return builder.shuffle_vector(first, undefined, mask)


def widened(builder, kinds, values):
    """LLVM values of these types, numbers as vectors if any of them is a vector."""
    kind = common(kinds)
    if not is_vector(kind):
        return list(values)
    return [
        value if is_vector(own) else splat(builder, value, kind.lanes)
        for own, value in zip(kinds, values, strict=True)
    ]


def floats(kinds: Iterable[NumbaObject]) -> list[NumbaObject]:
    """The types with float64 in place of those of other numbers."""
    return [kind if is_vector(kind) else types.float64 for kind in kinds]
