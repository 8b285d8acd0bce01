"""Rows of matrices to and from vectors: entries of four rows become vectors, one a column."""

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from pgimp.jit.memory import part_of
from pgimp.jit.vectors.kinds import DOUBLES, vec4


def _shuffle(builder, u, v, *places):
    mask = ir.Constant(ir.VectorType(ir.IntType(32), len(places)), list(places))
    return builder.shuffle_vector(u, v, mask)


def _address(context, builder, kind, array, row, column):
    """Address of an entry of a matrix, as of a vector."""
    data = part_of(context, builder, kind, array, "data")
    if kind.layout == "C":
        columns = part_of(context, builder, kind, array, "shape", 1)
        address = builder.gep(data, [builder.add(builder.mul(row, columns), column)])
    else:
        parts = (part_of(context, builder, kind, array, name) for name in ("shape", "strides"))
        shape, strides = (cgutils.unpack_tuple(builder, each) for each in parts)
        address = cgutils.get_item_pointer2(
            context, builder, data, shape, strides, kind.layout, [row, column]
        )
    return builder.bitcast(address, DOUBLES.as_pointer())


@intrinsic
def load_row(typing_context, array, row, column):
    """Read ``array[row, column:column + 4]``, at any address."""

    def generate(context, builder, sig, args):
        return builder.load(_address(context, builder, sig.args[0], *args), align=8)

    return vec4(array, types.int64, types.int64), generate


@intrinsic
def store_row(typing_context, array, row, column, vector):
    """Write a vector to ``array[row, column:column + 4]``, at any address."""

    def generate(context, builder, sig, args):
        builder.store(args[3], _address(context, builder, sig.args[0], *args[:3]), align=8)
        return context.get_dummy_value()

    return types.void(array, types.int64, types.int64, vec4), generate


@intrinsic
def transpose(typing_context, a, b, c, d):
    """The four vectors of the first, second, third and fourth elements."""

    def generate(context, builder, sig, args):
        def shuffle(u, v, *places):
            return _shuffle(builder, u, v, *places)

        a, b, c, d = args
        ab, cd = (shuffle(*pair, 0, 4, 2, 6) for pair in ((a, b), (c, d)))
        low = shuffle(ab, cd, 0, 1, 4, 5), shuffle(ab, cd, 2, 3, 6, 7)
        ab, cd = (shuffle(*pair, 1, 5, 3, 7) for pair in ((a, b), (c, d)))
        high = shuffle(ab, cd, 0, 1, 4, 5), shuffle(ab, cd, 2, 3, 6, 7)
        columns = (low[0], high[0], low[1], high[1])
        return context.make_tuple(builder, sig.return_type, columns)

    return types.UniTuple(vec4, 4)(vec4, vec4, vec4, vec4), generate
