"""Reading a case from its file, on one rank."""

from collections.abc import Sequence
from pathlib import Path

from pgimp.case.document import read
from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.errors import UsageError


def load(name: str | Path, overrides: Sequence[str] = ()) -> Case:
    """Read a case from its file.

    Parameters
    ----------
    name : str or Path
        The file.
    overrides : sequence of str
        Changes, as ``key.path=value``.

    Raises
    ------
    UsageError
        If the file cannot be read.
    CaseError
        For everything that is wrong in it, each with its line.
    """
    try:
        text = read(name)
    except OSError as error:
        raise UsageError(f"cannot read the case {name}: {error.strerror or error}") from None
    return read_case(text, str(name), list(overrides))
