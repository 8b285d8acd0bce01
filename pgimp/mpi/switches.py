"""Environment variables that turn off features that change no bit, for comparisons."""

import os

from pgimp.errors import UsageError


def switched_on(name: str, off: str, on: str) -> bool:
    """Whether an environment variable leaves a feature on.

    Parameters
    ----------
    name : str
        The variable: 0 turns off; 1, or none, does not.
    off, on : str
        Effects of both states, for messages.

    Raises
    ------
    UsageError
        If the variable has another value.
    """
    value = os.environ.get(name, "")
    if value not in ("", "0", "1"):
        raise UsageError(
            f"the environment variable {name} is '{value}'; 0 {off}, 1 or nothing {on}"
        )
    return value != "0"
