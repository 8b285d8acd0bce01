"""Layout of records, and copy of runs of numbers, of which the compiler makes a slow loop."""

import numpy as np
from numba.core import cgutils, types
from numba.extending import intrinsic


@intrinsic
def copy(typing_context, target, at, source, begin, count):
    """``target[at:at + count] = source[begin:begin + count]`` for vectors that do not overlap.

    In a plain loop the compiler allows for an overlap.
    """
    if target.dtype != source.dtype:
        return None

    def generate(context, builder, sig, args):
        def address(kind, array, index):
            return builder.gep(context.make_array(kind)(context, builder, array).data, [index])

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
