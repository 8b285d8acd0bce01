"""Exceptions whose messages are for people; the command line turns each into an exit status."""


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


class DamagedError(Exception):
    """A checkpoint cannot be used: what is wrong with it, in one line.

    It is no end yet, for there may be another one; so it has no exit status.
    """
