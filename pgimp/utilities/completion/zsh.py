"""The script of zsh: the specifications of `_arguments`, with what the help says of each option."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pgimp.utilities.completion.words import Command, Value

_SCRIPT = r"""#compdef pgimp
# Completion of pgimp VERSION in zsh, as `pgimp completion zsh` prints it.

_pgimp_files() { # SUFFIX...
    if (( $# )); then _files -g "*.(${(j:|:)@})(-.)"; else _files; fi
}
_pgimp_holds() { # is the directory $REPLY one that holds a file of $marks?
    local mark
    for mark in $marks; do [[ ! -e $REPLY/$mark ]] || return 0; done
    return 1
}
_pgimp_folders() { # MARK...: directories that hold one of these files, else all
    local expl
    local -a marks=("$@")
    (( $# )) && _wanted directories expl directory _path_files -g '*(-/+_pgimp_holds)' && return
    _files -/
}
_pgimp_case() {
    (( $# )) && _describe -t commands command _pgimp_commands
    _pgimp_files yaml yml
}
_pgimp() {
    local curcontext=$curcontext name=run
    local -a _pgimp_commands=(
COMMANDS
    )
    if (( CURRENT > 2 && ${_pgimp_commands[(I)${words[2]}:*]} )); then
        name=$words[2]
        shift words
        (( CURRENT-- ))
    fi
    case $name in
CASES
    esac
}
if [[ ${funcstack[1]} = _pgimp ]]; then _pgimp "$@"; else compdef _pgimp pgimp; fi
"""


def script(commands: Sequence[Command], version: str) -> str:
    """Return the script.

    Parameters
    ----------
    commands : sequence of Command
        All of them, a run's among them.
    version : str
        That of pgimp.
    """
    described = (
        f"        {_quoted(f'{one.name}:{one.summary}')}" for one in commands if one.name != "run"
    )
    cases = (
        f"    {one.name}) _arguments -S \\\n"
        + " \\\n".join(f"        {s}" for s in _specs(one))
        + " ;;"
        for one in commands
    )
    return (
        _SCRIPT.replace("VERSION", version)
        .replace("COMMANDS", "\n".join(described))
        .replace("CASES", "\n".join(cases))
    )


def _specs(command: Command) -> Iterator[str]:
    """Yield the specifications of a command's options and places."""
    for option in command.options:
        others = "*" if option.repeatable else f"({' '.join(option.names)})"
        for name in option.names:
            equals = "=" if option.value and name.startswith("--") else ""
            taken = _action(option.value) if option.value else ""
            yield _quoted(f"{others}{name}{equals}[{_escaped(option.help)}]{taken}")
    for number, value in enumerate(command.places):
        last = command.repeats and number == len(command.places) - 1
        first = command.name == "run" and number == 0
        action = f":{_escaped(value.name)}: _pgimp_case first" if first else _action(value)
        yield _quoted(f"{'*' if last else number + 1}{action}")


def _action(value: Value) -> str:
    """Return message and action; the blank before a function keeps its words as they are."""
    kind, *details = value.kind
    action = {
        "words": f"({' '.join(map(_escaped, details))})",
        "files": " ".join([" _pgimp_files", *details]),
        "folders": " ".join([" _pgimp_folders", *details]),
        "any": " ",
    }[kind]
    return f":{_escaped(value.name)}:{action}"


def _escaped(text: str) -> str:
    """Return text without signs of a specification."""
    for sign in "\\[]:":
        text = text.replace(sign, f"\\{sign}")
    return text


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "'\\''") + "'"
