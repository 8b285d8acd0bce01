"""How a run begins."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from pgimp.errors import UsageError
from pgimp.io.rundir.ownfiles import COARSE

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.io.rundir.rundir import RunDirectory


class How(NamedTuple):
    """How a run begins, as the command line says."""

    overwrite: bool = False  #: In place of an older one.
    resume: bool = False  #: Where an older one stopped.
    error: bool = False  #: After companion runs, from which errors are estimated.
    forecast: bool = False  #: Not at all: only the companion runs, and what it will cost.


def has_companions(case: Case, directory: RunDirectory, how: How) -> bool:
    """Whether companions run first; those of a run that is resumed go on; collective.

    Raises
    ------
    UsageError
        If only they are to run, and the run itself has begun.
    """
    step = (directory.before or {}).get("steps")
    if how.forecast and step and not how.overwrite:
        raise UsageError(f"{directory.path} holds a run that has begun: it needs no --forecast")
    begun = directory.before is not None and not directory.overwrite
    begun = directory.comm.bcast(begun and (directory.path / COARSE).is_dir())
    return how.error or how.forecast or case.accuracy is not None or begun
