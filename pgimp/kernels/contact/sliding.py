"""The laws of contact as kernels call them, see `pgimp.physics.contact`."""

from pgimp.jit.kernel import class_of, inlined, inner_kernel
from pgimp.jit.tuples import read


@inlined
def _find_part(laws, k, pairs, entry, load):
    """Transmitted part by the law of an entry, one of `laws`, numbered from `k`."""
    if len(laws) == 1 or pairs.law[entry] == k:
        law = class_of(laws[0])(*read(pairs.parameters, entry, 0, laws[0]))
        return class_of(law).sliding_part(law, *load)
    return _find_part(laws[1:], k + 1, pairs, entry, load)


@inlined
def _find_slope(laws, k, pairs, entry, pressed, stress, slip):
    """Slope by the law of an entry, one of `laws`, numbered from `k`."""
    if len(laws) == 1 or pairs.law[entry] == k:
        law = class_of(laws[0])(*read(pairs.parameters, entry, 0, laws[0]))
        return class_of(law).slope(law, pressed, stress, slip)
    return _find_slope(laws[1:], k + 1, pairs, entry, pressed, stress, slip)


@inlined
def _act_apart(laws, k, pairs, entry):
    """Whether the law of an entry, one of `laws`, numbered from `k`, acts without pressure."""
    if len(laws) == 1 or pairs.law[entry] == k:
        return not hasattr(class_of(laws[0]), "only_pressed")
    return _act_apart(laws[1:], k + 1, pairs, entry)


@inner_kernel
def acts_apart(pairs, entry):
    """Whether the law of an entry may transmit slip without pressure and cohesion."""
    return _act_apart(pairs.laws, 0, pairs, entry)


@inner_kernel
def sliding_part(pairs, entry, cohesion, pressed, stress, sticking, slip):
    """Part of the sticking tangential impulse that the law of an entry transmits.

    See `pgimp.physics.contact.base.Sliding`.
    """
    return _find_part(pairs.laws, 0, pairs, entry, (cohesion, pressed, stress, sticking, slip))


@inner_kernel
def sliding_slope(pairs, entry, pressed, stress, slip):
    """Derivative of the tangential impulse by the normal one while surfaces slide."""
    return _find_slope(pairs.laws, 0, pairs, entry, pressed, stress, slip)
