"""No launcher for tests of the doctor but those that they put there."""

import os

import pytest
from processes import LAUNCHER_VARIABLES


@pytest.fixture(autouse=True)
def no_launcher(monkeypatch):
    for name in [name for name in os.environ if name.startswith(LAUNCHER_VARIABLES)]:
        monkeypatch.delenv(name)
