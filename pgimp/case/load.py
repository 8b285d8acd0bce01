"""Reading a case from its file, from a dictionary, or from another case, on one rank."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike, fspath

from pgimp.case.reader import read_case, validate
from pgimp.case.schema import Case
from pgimp.errors import CaseError, UsageError
from pgimp.schema.document import Document, read
from pgimp.schema.overrides import Overrides, apply, as_data
from pgimp.schema.words.renew import renew

Source = Case | str | PathLike[str] | Mapping[str, object]
"""A case, the name of its file, or the file's content as a dictionary."""


def load(case: Source, overrides: Overrides = ()) -> Case:
    """Read a case, and change values of it.

    ``load("block.yaml", {"materials.rubber.young": 1e6, "grid.cell": [0.1, 0.1]})`` gives the case
    of the file with other values, as ``--set`` does. `case` may also be a loaded case, which stays
    unchanged.

    Parameters
    ----------
    case : Case, str, Path or mapping
        A case, the name of its file, or the file's content as a dictionary. Names of files
        in it start from the folder of its file, in a dictionary from the working directory.
    overrides : mapping, or sequence of str
        Values by key paths, with list indices from 0: ``{"time.end": 3.0}``. NumPy's numbers and
        arrays will do. Or ``["time.end=3.0"]``, as on the command line.

    Returns
    -------
    Case
        The case, which cannot be changed.

    Raises
    ------
    UsageError
        If the file cannot be read.
    CaseError
        For all errors in it, each with its line and key path.
    """
    if isinstance(case, Case):
        if not overrides:
            return case
    elif isinstance(case, str | PathLike):
        try:
            text = read(fspath(case))
        except OSError as error:
            raise UsageError(f"cannot read the case {case}: {error.strerror or error}") from None
        return read_case(text, fspath(case), overrides)
    elif not isinstance(case, Mapping):
        raise CaseError(
            "expected a case, the name of its file or a dictionary with its content, got a value "
            f"of type {type(case).__name__}"
        )
    document = Document(as_data(case, "case"))
    renew(document, "case")
    apply(document, overrides)
    return validate(Case, document, "case")
