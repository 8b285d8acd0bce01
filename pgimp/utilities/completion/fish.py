"""The script of fish: a line for each option, place and command, with a condition."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pgimp.utilities.completion.words import Command, Value

_SCRIPT = r"""# Completion of pgimp VERSION in fish, as `pgimp completion fish` prints it.

function __pgimp_takes -a command option # does this option of the command take a value?
    switch "$command $option"
TAKES
            return 0
    end
    return 1
end
function __pgimp_state # the command, and how many positional arguments precede
    set -l tokens (commandline -opc)[2..]
    set -l command run
    set -l place 0
    set -l wanted 0
    if contains -- "$tokens[1]" COMMANDS
        set command $tokens[1]
        set -e tokens[1]
    end
    for token in $tokens
        if test $wanted = 1
            set wanted 0
        else if string match -q -- '-*' $token
            __pgimp_takes $command $token; and set wanted 1
        else
            set place (math $place + 1)
        end
    end
    echo $command
    echo $place
end
function __pgimp_is -a command
    set -l state (__pgimp_state)
    test $state[1] = $command
end
function __pgimp_at -a command least most
    set -l state (__pgimp_state)
    test $state[1] = $command -a $state[2] -ge $least -a $state[2] -le $most
end
function __pgimp_begins
    test (count (commandline -opc)) = 1
end
function __pgimp_paths # files and directories that complete the value
    set -l token (string replace -r -- '^--[a-z-]+=' '' (commandline -ct))
    complete -C "__fish_command_without_completions $token" | string replace -r '\t.*' ''
end
function __pgimp_files # SUFFIX...
    set -l ends (string join '|' -- (string escape --style=regex -- .$argv))
    if test (count $argv) = 0
        __pgimp_paths
    else
        __pgimp_paths | string match -r -- "^.*(?:/|$ends)\$"
    end
end
function __pgimp_folders # MARK...: directories that hold one of these files, else all
    set -l all (__pgimp_paths | string match -- '*/')
    set -l found
    for path in $all
        for mark in $argv
            if test -e (string replace -r '^~/' "$HOME/" -- $path)$mark
                set -a found $path
                break
            end
        end
    end
    test (count $found) -gt 0; or set found $all
    string join \n -- $found
end
complete -c pgimp -e
complete -c pgimp -f
LINES
"""
_MANY = 9999


def script(commands: Sequence[Command], version: str) -> str:
    """Return the script.

    Parameters
    ----------
    commands : sequence of Command
        All of them, a run's among them.
    version : str
        That of pgimp.
    """
    others = [one for one in commands if one.name != "run"]
    takes = " ".join(
        f"'{one.name} {name}'"
        for one in commands
        for option in one.options
        if option.value
        for name in option.names
    )
    lines = [
        f"complete -c pgimp -n __pgimp_begins -a {one.name} -d {_quoted(one.summary)}"
        for one in others
    ]
    lines += [line for one in commands for line in _lines(one)]
    return (
        _SCRIPT.replace("VERSION", version)
        .replace("TAKES", f"        case {takes}")
        .replace("COMMANDS", " ".join(one.name for one in others))
        .replace("LINES", "\n".join(lines))
    )


def _lines(command: Command) -> Iterator[str]:
    """Yield the lines of a command's options and places."""
    for option in command.options:
        names = " ".join(
            f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names
        )
        value = f" -x{_offer(option.value)}" if option.value else ""
        condition = f"-n '__pgimp_is {command.name}'"
        yield f"complete -c pgimp {condition} {names}{value} -d {_quoted(option.help)}"
    for number, place in enumerate(command.places):
        last = command.repeats and number == len(command.places) - 1
        condition = f"-n '__pgimp_at {command.name} {number} {_MANY if last else number}'"
        if offer := _offer(place):
            yield f"complete -c pgimp {condition}{offer}"


def _offer(value: Value) -> str:
    kind, *details = value.kind
    if kind == "any":
        return ""
    words = " ".join(details)
    return f" -a {_quoted(words if kind == 'words' else f'(__pgimp_{kind} {words})')}"


def _quoted(text: str) -> str:
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
