"""``pgimp schema`` prints what a case file may hold: for editors, or as a page for people."""

from __future__ import annotations

import argparse
import json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The parser to add to.
    """
    parser.add_argument(
        "--markdown",
        action="store_true",
        help="print the reference of case file, frames and history instead of the JSON schema",
    )


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        The exit status, 0.
    """
    if args.markdown:
        from pgimp.case.reference import reference

        print(reference(), end="")
    else:
        from pgimp.case.jsonschema import json_schema

        print(json.dumps(json_schema(), indent=2, ensure_ascii=False))
    return 0
