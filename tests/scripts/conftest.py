"""Machines for the scripts: bare, and set up."""

from pathlib import Path

import pytest
from machines import Machine


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


@pytest.fixture
def ready(machine: Machine) -> Machine:
    """A machine that is set up."""
    machine.add_system_packages()
    done = machine.run("scripts/setup")
    assert done.returncode == 0, done.stdout + done.stderr
    return machine
