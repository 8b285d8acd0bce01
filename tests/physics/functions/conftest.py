"""What the tests of functions of one's own share."""

import pytest

from pgimp.physics.functions.registry import FUNCTIONS


@pytest.fixture(autouse=True)
def registered():
    """Functions that a test registers are gone after it."""
    before = dict(FUNCTIONS)
    yield
    FUNCTIONS.clear()
    FUNCTIONS.update(before)
