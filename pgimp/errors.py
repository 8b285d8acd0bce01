"""Exceptions whose messages are shown to the user; each has an exit status."""

import errno
import os
import sysconfig
import traceback
from pathlib import Path

_ADVICE = {
    errno.ENOSPC: "Make room there, or choose another place with -o.",
    errno.EDQUOT: "Make room in your quota, or choose another place with -o.",
    errno.EROFS: "Choose another place with -o.",
    errno.EACCES: "Choose another place with -o, or change the permissions.",
    errno.EPERM: "Choose another place with -o, or change the permissions.",
}

#: The package without its cases, as frames of exceptions have its files.
_PACKAGE = str(Path(__file__).absolute().parent) + os.sep
_CASES = _PACKAGE + "cases" + os.sep
#: Libraries that functions of a user call.
_STANDARD = sysconfig.get_paths()["stdlib"] + os.sep
_INSTALLED = tuple(os.sep + name + os.sep for name in ("site-packages", "dist-packages"))


class PgimpError(Exception):
    """Base of the errors that pgimp raises on purpose: what is wrong, where, what to do."""

    exit_status = 1


class CaseError(PgimpError):
    """The case file is wrong (exit status 2)."""

    exit_status = 2


class UsageError(PgimpError):
    """The command line or the environment is wrong (exit status 2)."""

    exit_status = 2


class RunError(PgimpError):
    """The run failed (exit status 1)."""


class EndlessError(RunError):
    """The run cannot go on, though no particle is at fault; on every rank together."""


#: Words of the message of `NoRestError`, by which `pgimp study` knows it.
NO_REST = "no rest after"


class NoRestError(RunError):
    """A run, or a stage, has not come to rest in its steps (exit status 3); on every rank."""

    exit_status = 3


class DamagedError(Exception):
    """A checkpoint cannot be used: what is wrong with it, in one line.

    It is no end yet, for there may be another one; so it has no exit status.
    """


def explain(error: OSError) -> str:
    """Describe why a file operation failed, and what to do about it."""
    if error.errno is None:
        return " ".join(str(error).split())
    cause = os.strerror(error.errno)
    return f"{cause}. {_ADVICE[error.errno]}" if error.errno in _ADVICE else cause


def is_outside(path: str) -> bool:
    """Whether a file is none of the package's; its cases are as a user's."""
    return not path.startswith(_PACKAGE) or path.startswith(_CASES)


def is_library(path: str) -> bool:
    """Whether a file is of Python itself or of an installed package."""
    return path.startswith(_STANDARD) or any(name in path for name in _INSTALLED)


def raised_at(error: BaseException) -> traceback.FrameSummary | None:
    """Return where a user's function raised an exception, or called what raised it.

    None if there is no frame outside of the package.
    """
    frames = traceback.extract_tb(error.__traceback__)
    outside = [frame for frame in frames if is_outside(frame.filename)]
    own = [frame for frame in outside if not is_library(frame.filename)] or outside
    return own[-1] if own else None
