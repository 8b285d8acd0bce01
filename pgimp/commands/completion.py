"""``pgimp completion SHELL``: prints a script by which a shell completes pgimp's words."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from pgimp.commands import COMMANDS

#: By shell what is put before, and after, parts of shtab's script: its first word may also be a
#: case, after which the options of a run follow.
_CASES = {
    "bash": (
        (
            "complete -o bashdefault -F _shtab_pgimp pgimp",
            """\
_pgimp() {
  _shtab_pgimp
  [ "$COMP_CWORD" -gt 1 ] || mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(CASES "$2")
  compopt -o filenames 2>/dev/null
}
complete -F _pgimp pgimp""",
        ),
    ),
    "zsh": (
        ("_describe 'pgimp commands' _commands\n", "_describe 'pgimp commands' _commands; CASES\n"),
        (
            "      esac\n  esac\n}",
            "        *) _arguments -s ${_shtab_pgimp_options[1,-3]} ;;\n      esac\n  esac\n}",
        ),
    ),
}
SHELLS = tuple(_CASES)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
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
    import shtab

    from pgimp.commands.init import packaged
    from pgimp.physics.fields import FIELDS
    from pgimp.utilities.element.paths import PATHS

    words = {
        ("init", "name"): packaged(),
        ("plot", "field"): FIELDS,
        ("report", "field"): FIELDS,
        ("export", "field"): FIELDS,
        ("element", "path"): PATHS,
    }
    cases = shtab.glob("*.yaml", "*.yml")
    files = {
        "yaml": cases,
        "html": shtab.glob("*.html", "*.htm"),
        "FILE": shtab.FILE,
        "FIG": shtab.FILE,
        "FOLDER": shtab.DIRECTORY,
        "DIR": shtab.DIRECTORY,
        "DIR1": shtab.DIRECTORY,
        "DIR2": shtab.DIRECTORY,
    }
    # A run has no name of its own: its options are those of all lines without a command.
    root = args.parser_of("run")
    _complete(root, "run", words, files)
    root._actions[:] = [action for action in root._actions if action.option_strings]
    commands = root.add_subparsers()
    for name, summary in COMMANDS.items():
        commands.add_parser(name, help=summary, parents=[args.parser_of(name)], add_help=False)
        _complete(commands.choices[name], name, words, files)
    script = shtab.complete(root, args.shell)
    for part, more in _CASES[args.shell]:
        script = script.replace(part, more.replace("CASES", str(cases[args.shell])), 1)
    print(script)
    return 0


def _complete(
    parser: argparse.ArgumentParser,
    command: str,
    words: Mapping[tuple[str, str], Any],
    files: Mapping[str, Any],
) -> None:
    """Say what the values of a parser's actions may be, by their metavar: words or files."""
    import shtab

    for action in parser._actions:
        name = action.metavar if isinstance(action.metavar, str) else ""
        ending = name.rpartition(".")[2]
        if found := words.get((command, action.dest)):
            action.choices = tuple(found)
        elif name in files or ending in files:
            action.complete = files[name if name in files else ending]  # type: ignore[attr-defined]
        elif ending != name and ending.isalpha():
            action.complete = shtab.glob(f"*.{ending}")  # type: ignore[attr-defined]
