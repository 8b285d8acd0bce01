"""The laws of contact as kernels call them, see `pgimp.physics.contact`."""

from pgimp.jit.kernel import class_of, inlined, inner_kernel
from pgimp.jit.tuples import read


@inlined
def _find_part(kinds, k, pairs, entry, load):
    """Transmitted part by the law of an entry, one of `kinds`, numbered from `k`."""
    if len(kinds) == 1 or pairs.kind[entry] == k:
        law = class_of(kinds[0])(*read(pairs.parameters, entry, 0, kinds[0]))
        return class_of(law).sliding_part(law, *load)
    return _find_part(kinds[1:], k + 1, pairs, entry, load)


@inlined
def _find_slope(kinds, k, pairs, entry, pressed, stress, slip):
    """Slope by the law of an entry, one of `kinds`, numbered from `k`."""
    if len(kinds) == 1 or pairs.kind[entry] == k:
        law = class_of(kinds[0])(*read(pairs.parameters, entry, 0, kinds[0]))
        return class_of(law).slope(law, pressed, stress, slip)
    return _find_slope(kinds[1:], k + 1, pairs, entry, pressed, stress, slip)


@inner_kernel
def sliding_part(pairs, entry, cohesion, pressed, stress, sticking, slip):
    """Part of the sticking tangential impulse that the law of an entry transmits.

    See `pgimp.physics.contact.base.Sliding`.
    """
    return _find_part(pairs.kinds, 0, pairs, entry, (cohesion, pressed, stress, sticking, slip))


@inner_kernel
def sliding_slope(pairs, entry, pressed, stress, slip):
    """Derivative of the tangential impulse by the normal one while surfaces slide."""
    return _find_slope(pairs.kinds, 0, pairs, entry, pressed, stress, slip)
