"""The script of bash: tables of the commands, and functions that look words up in them."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from itertools import chain

from pgimp.utilities.completion.words import Command

_SCRIPT = r"""# Completion of pgimp VERSION in bash >= 4.3, as `pgimp completion bash` prints it.

_pgimp_takes() { # what takes a value in a command (an option, or a place from 0): its kind
    case "$1 $2" in
TAKES
    *) return 1 ;;
    esac
}
_pgimp_options() {
    case $1 in
OPTIONS
    esac
}
_pgimp_offer() { # words WORD... | files SUFFIX... | folders MARK... | any
    local kind=$1 name path fits mark
    local -a all=() found=()
    shift
    case $kind in
    words) mapfile -t found < <(compgen -W "$*" -- "$current") ;;
    files)
        mapfile -t all < <(compgen -f -- "$current")
        for name in "${all[@]}"; do
            path=${name/#\~\//$HOME/} fits=false
            [[ $# -gt 0 && ! -d $path ]] || fits=true
            for mark in "$@"; do [[ $name != *."$mark" ]] || fits=true; done
            ! $fits || found+=("$name")
        done ;;
    folders)
        mapfile -t all < <(compgen -d -- "$current")
        for name in "${all[@]}"; do
            path=${name/#\~\//$HOME/}
            for mark in "$@"; do [[ ! -e $path/$mark ]] || { found+=("$name"); break; }; done
        done
        [ ${#found[@]} -gt 0 ] || found=("${all[@]}") ;;
    esac
    case $kind in files | folders) compopt -o filenames 2>/dev/null ;; esac
    COMPREPLY+=("${found[@]}")
}
_pgimp() {
    local command=run current wanted="" place=0 glue=false word
    local -a words=()
    COMPREPLY=()
    # Readline has broken words at = and :, of which only that after an option ends one.
    for word in "${COMP_WORDS[@]:1:COMP_CWORD}"; do
        if [[ $word = "=" && ${#words[@]} -gt 0 && ${words[-1]} == --* ]]; then
            words+=("") glue=true
        elif $glue || [[ ${#words[@]} -gt 0 && ( $word = "=" || $word = : ) ]]; then
            words[-1]+=$word
            [[ $word = "=" || $word = : ]] && glue=true || glue=false
        else
            words+=("$word")
        fi
    done
    current=${words[-1]}
    unset "words[-1]"
    if [[ ${#words[@]} -gt 0 && " COMMANDS " == *" ${words[0]} "* ]]; then
        command=${words[0]}
        words=("${words[@]:1}")
    fi
    for word in "${words[@]}"; do
        if [[ -n $wanted ]]; then
            wanted=""
        elif [[ $word == -* ]]; then
            ! _pgimp_takes "$command" "$word" >/dev/null || wanted=$word
        else
            place=$((place + 1))
        fi
    done
    if [[ -n $wanted ]]; then
        _pgimp_offer $(_pgimp_takes "$command" "$wanted")
    elif [[ $current == -* ]]; then
        _pgimp_offer words $(_pgimp_options "$command")
    else
        [[ $command != run || ${#words[@]} -gt 0 ]] || _pgimp_offer words COMMANDS
        _pgimp_offer $(_pgimp_takes "$command" "$place" || echo any)
    fi
}
complete -F _pgimp pgimp
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
    options = (
        f"    {one.name}) echo {' '.join(chain(*(option.names for option in one.options)))} ;;"
        for one in commands
    )
    names = " ".join(one.name for one in commands if one.name != "run")
    return (
        _SCRIPT.replace("VERSION", version)
        .replace("TAKES", "\n".join(line for one in commands for line in _takes(one)))
        .replace("OPTIONS", "\n".join(options))
        .replace("COMMANDS", names)
    )


def _takes(command: Command) -> Iterator[str]:
    """Yield the cases of the options and places that take a value."""
    for option in command.options:
        if option.value:
            names = " | ".join(f'"{command.name} {name}"' for name in option.names)
            yield f"    {names}) echo {shlex.join(option.value.kind)} ;;"
    for number, value in enumerate(command.places):
        last = command.repeats and number == len(command.places) - 1
        place = f'"{command.name} "[0-9]*' if last else f'"{command.name} {number}"'
        yield f"    {place}) echo {shlex.join(value.kind)} ;;"
