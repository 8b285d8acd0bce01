"""Tiers of tests: what `scripts/test` leaves to ``--all``."""

from typing import Any

import pytest


def wide(*values: Any) -> Any:
    """Parameters of a test that is run with ``--all`` alone."""
    return pytest.param(*values, marks=pytest.mark.wide)
