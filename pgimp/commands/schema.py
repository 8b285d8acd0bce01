"""``pgimp schema``: prints the keys of a case file, for editors or as a page to read."""

from __future__ import annotations

import argparse
import json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        "--markdown",
        action="store_true",
        help="print the reference of case file, frames, history and study file instead of the "
        "JSON schema",
    )
    parser.add_argument(
        "--study", action="store_true", help="print the JSON schema of the study file"
    )


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        The exit status, 0.
    """
    if args.markdown:
        from pgimp.utilities.reference.page import reference

        print(reference(), end="")
    else:
        from pgimp.utilities.reference.jsonschema import json_schema, study_schema

        schema = study_schema() if args.study else json_schema()
        print(json.dumps(schema, indent=2, ensure_ascii=False))
    return 0
