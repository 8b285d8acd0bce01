"""NamedTuples with numbers that vary by particle.

For parameters that vary in space, `Own` stands in place of a number. A kernel substitutes the
values of its particle, or of four (`filled`). The types decide the compiled code: where nothing
varies there is no `Own`, and nothing is done.
"""

from typing import NamedTuple

from numba.core import cgutils, types
from numba.extending import intrinsic

from pgimp.jit.outside import NumbaObject


class Own(NamedTuple):
    """Placeholder of a number that varies by particle: its index among these."""

    number: int


def is_own(kind: NumbaObject) -> bool:
    """Whether a Numba type is the type of `Own`."""
    return getattr(kind, "instance_class", None) is Own


def count_own(kind: NumbaObject) -> int:
    """Number of `Own` in values of a Numba type, at any depth."""
    if is_own(kind):
        return 1
    parts: NumbaObject = kind if isinstance(kind, types.BaseTuple) else ()
    return sum(count_own(part) for part in parts)


def _type_of(kind, number):
    """Type of a structure, given by its type, with numbers in place of `Own`."""
    if is_own(kind):
        return number
    if not count_own(kind):
        return kind
    parts = [_type_of(part, number) for part in kind]
    return types.BaseTuple.from_types(parts, getattr(kind, "instance_class", None))


@intrinsic
def filled(typing_context, structure, values):
    """The structure, tuples of any depth, with ``values[i]`` for the i-th `Own` in it.

    `values` are at least as many numbers, or vectors.
    """
    given: list[NumbaObject] = [*values] if isinstance(values, types.BaseTuple) else []
    if not given or count_own(structure) > len(given):
        return None
    number = given[0]

    def generate(context, builder, sig, args):
        found = iter(cgutils.unpack_tuple(builder, args[1]))

        def build(kind, value):
            if is_own(kind):
                return next(found)
            if not count_own(kind):
                return value
            parts = [build(part, builder.extract_value(value, i)) for i, part in enumerate(kind)]
            return context.make_tuple(builder, _type_of(kind, number), parts)

        return build(sig.args[0], args[0])

    return _type_of(structure, number)(structure, values), generate


@intrinsic
def named(typing_context, like, values):
    """The tuple `values` as a NamedTuple of the class of `like`."""
    kind = types.BaseTuple.from_types([*values], like.instance_class)

    def generate(context, builder, sig, args):
        return context.make_tuple(builder, kind, cgutils.unpack_tuple(builder, args[1]))

    return kind(like, values), generate
