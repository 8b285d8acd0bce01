"""Records of arrays as arguments of parts: one LLVM value, where Numba passes each of their items.

Numba passes a tuple's items one by one: the caller takes them out, the callee makes a tuple again.
The records of a kernel have hundreds of items, and a kernel has some hundred parts. That was a
fifth of the compile time, to no effect: all parts are inlined.

Numbers that kernels compute are still passed one by one. Of two products in a sum LLVM contracts
one, chosen by the order of the operands, and that depends on which of them is an argument. Kernels
themselves also get their items one by one: LLVM then reads them where they are used.
"""

from functools import cache

from numba.core import types
from numba.core.base import BaseContext
from numba.core.datamodel.packer import ArgPacker
from numba.core.funcdesc import PythonFunctionDescriptor

from pgimp.jit.outside import NumbaObject


class PartTypes(tuple):
    """Types of a part's arguments."""


@cache
def passed_whole(kind: NumbaObject) -> bool:
    """Whether a type is a record that contains an array, at any depth."""
    return isinstance(kind, types.BaseNamedTuple) and _has_array(kind)


def _has_array(kinds: NumbaObject) -> bool:
    """Whether there is an array in types, at any depth."""
    return any(
        isinstance(kind, types.Array) or (isinstance(kind, types.BaseTuple) and _has_array(kind))
        for kind in kinds
    )


class _Whole:
    """How a record is passed: as it is."""

    def __init__(self, model: NumbaObject) -> None:
        self.get_argument_type = model.get_value_type

    def as_argument(self, builder: NumbaObject, value: NumbaObject) -> NumbaObject:
        """Return what the caller passes."""
        return value

    from_argument = as_argument


class _Models:
    """Numba's models of types, but records of arrays are passed whole."""

    def __init__(self, models: NumbaObject) -> None:
        self._models = models

    def lookup(self, kind: NumbaObject) -> NumbaObject:
        """Return the model of a type."""
        model = self._models.lookup(kind)
        return _Whole(model) if passed_whole(kind) else model


def _packer(self: NumbaObject, kinds: NumbaObject) -> ArgPacker:
    models = self.data_model_manager
    return ArgPacker(_Models(models) if isinstance(kinds, PartTypes) else models, kinds)


# Numba's classes, which have no place to say this.
_context: NumbaObject = BaseContext
_descriptor: NumbaObject = PythonFunctionDescriptor
_described = _descriptor.from_specialized_function.__func__


def _describe(cls: type, func_ir: NumbaObject, *words: object, **named: object) -> NumbaObject:
    found = _described(cls, func_ir, *words, **named)
    if getattr(func_ir.func_id, "is_part", False):
        found.argtypes = PartTypes(found.argtypes)
    return found


_context.get_arg_packer = _packer
_descriptor.from_specialized_function = classmethod(_describe)
