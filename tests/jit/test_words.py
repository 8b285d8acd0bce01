"""Bits of whole numbers."""

import pytest

from pgimp.jit.kernel import kernel
from pgimp.jit.words import lowest_bit


@kernel
def lowest(word):
    """The lowest bit, for Python."""
    return lowest_bit(word)


@pytest.mark.parametrize(("word", "place"), [(1, 0), (12, 2), (-1, 0), (-(1 << 63), 63), (0, 64)])
def test_lowest_bit(word, place):
    assert lowest(word) == place
