"""Layout of records, parts of arrays, and copy of runs of numbers.

Of the copy the compiler makes a slow loop.
"""

import numpy as np
from numba.core import cgutils, types
from numba.extending import intrinsic


def part_of(context, builder, kind, array, name, *place):
    """Part of an array in LLVM: its data, or its shape along a direction; one instruction.

    Numba stores the whole array on the stack, and reads its parts from there.
    """
    position = context.data_model_manager[kind].get_field_position(name)
    return builder.extract_value(array, [position, *place])


@intrinsic
def copy(typing_context, target, at, source, begin, count):
    """``target[at:at + count] = source[begin:begin + count]`` for vectors that do not overlap.

    In a plain loop the compiler allows for an overlap.
    """
    if target.dtype != source.dtype:
        return None

    def generate(context, builder, sig, args):
        def address(kind, array, index):
            return builder.gep(part_of(context, builder, kind, array, "data"), [index])

        size = context.get_abi_sizeof(context.get_data_type(target.dtype))
        cgutils.raw_memcpy(
            builder,
            address(sig.args[0], args[0], args[1]),
            address(sig.args[2], args[2], args[3]),
            args[4],
            size,
        )
        return context.get_dummy_value()

    return types.void(target, types.int64, source, types.int64, types.int64), generate


def structure(*fields: tuple) -> np.dtype:
    """Type of aligned records: name, type and, of arrays, shape of each field."""
    return np.dtype([*fields], align=True)
