"""``pgimp completion SHELL``: prints a script by which bash, zsh or fish complete pgimp's words."""

from __future__ import annotations

import argparse
import importlib
from importlib.metadata import version

from pgimp.commands import COMMANDS

SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The parser to add to.
    """
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Parameters
    ----------
    args : argparse.Namespace
        Arguments declared by `add_arguments`, and `parser_of`, which gives a command's parser.

    Returns
    -------
    int
        The exit status, 0.
    """
    from pgimp.commands.init import packaged
    from pgimp.commands.study import TABLE
    from pgimp.io.rundir.ownfiles import RUN
    from pgimp.physics.fields import FIELDS
    from pgimp.utilities.completion.words import Value, read
    from pgimp.utilities.element.paths import PATHS

    runs = Value("DIR", marks=(RUN,))
    known = {
        ("run", "output"): runs,
        ("init", "name"): Value("NAME", tuple(packaged())),
        ("plot", "directories"): runs,
        ("plot", "field"): Value("NAME", tuple(FIELDS)),
        ("report", "directory"): Value("DIR", marks=(RUN, TABLE)),
        ("report", "field"): Value("NAME", tuple(FIELDS)),
        ("export", "directory"): runs,
        ("export", "field"): Value("NAME,...", tuple(FIELDS)),
        ("element", "path"): Value("PATH", tuple(PATHS)),
        ("compare", "first"): runs,
        ("compare", "second"): runs,
    }
    commands = [
        read(name, COMMANDS.get(name, ""), args.parser_of(name), known)
        for name in ("run", *COMMANDS)
    ]
    shell = importlib.import_module(f"pgimp.utilities.completion.{args.shell}")
    print(shell.script(commands, version("pgimp")), end="")
    return 0
