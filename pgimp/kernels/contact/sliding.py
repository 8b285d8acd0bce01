"""The laws of contact as kernels call them, see `pgimp.physics.contact`."""

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.tuples import read


def _part_of(law, cohesion, pressed, stress, sticking, slip):
    """Part of the sticking tangential impulse that a law transmits."""


@specialise(_part_of)
def _part_by(law, cohesion, pressed, stress, sticking, slip):
    return law.instance_class.sliding_part


def _slope_of(law, pressed, stress, slip):
    """Derivative of a law's tangential impulse by the normal one."""


@specialise(_slope_of)
def _slope_by(law, pressed, stress, slip):
    return law.instance_class.slope


def _find_part(kinds, k, pairs, entry, load):
    """Transmitted part by the law of an entry, one of `kinds`, numbered from `k`."""


@specialise(_find_part)
def _find_part_by(kinds, k, pairs, entry, load):
    kind = kinds[0].instance_class

    def of_kind(kinds, k, pairs, entry, load):
        law = kind(*read(pairs.parameters, entry, 0, kinds[0]))
        return _part_of(law, load[0], load[1], load[2], load[3], load[4])

    def of_one(kinds, k, pairs, entry, load):
        if pairs.kind[entry] == k:
            law = kind(*read(pairs.parameters, entry, 0, kinds[0]))
            return _part_of(law, load[0], load[1], load[2], load[3], load[4])
        return _find_part(kinds[1:], k + 1, pairs, entry, load)

    return of_one if len(kinds) > 1 else of_kind


def _find_slope(kinds, k, pairs, entry, pressed, stress, slip):
    """Slope by the law of an entry, one of `kinds`, numbered from `k`."""


@specialise(_find_slope)
def _find_slope_by(kinds, k, pairs, entry, pressed, stress, slip):
    kind = kinds[0].instance_class

    def of_kind(kinds, k, pairs, entry, pressed, stress, slip):
        return _slope_of(kind(*read(pairs.parameters, entry, 0, kinds[0])), pressed, stress, slip)

    def of_one(kinds, k, pairs, entry, pressed, stress, slip):
        if pairs.kind[entry] == k:
            return _slope_of(
                kind(*read(pairs.parameters, entry, 0, kinds[0])), pressed, stress, slip
            )
        return _find_slope(kinds[1:], k + 1, pairs, entry, pressed, stress, slip)

    return of_one if len(kinds) > 1 else of_kind


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
