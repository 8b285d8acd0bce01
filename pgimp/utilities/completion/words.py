"""What may stand where on a command line: options, their values, and positional arguments.

Read from the parsers. A value's kind follows from its metavar: ``CASE.yaml`` is a file with that
suffix, ``DIR`` the directory of a run, ``FILE`` any file, ``FOLDER`` any directory.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import NamedTuple

#: By metavar: all other names are values that no shell can guess.
_FILES = {"FILE": (), "FIG": ()}
_FOLDERS = ("DIR", "DIR1", "DIR2", "FOLDER")
#: What else ends the name of such a file.
_ALSO = {"yaml": ("yaml", "yml"), "html": ("html", "htm")}


class Value(NamedTuple):
    """A value: one of `words`, or a file or a directory, or free."""

    name: str
    words: tuple[str, ...] = ()
    #: Suffixes of a file's name; empty: any. None: it is no file.
    suffixes: tuple[str, ...] | None = None
    #: Files of which a directory holds one; empty: any directory. None: it is none.
    marks: tuple[str, ...] | None = None

    @property
    def kind(self) -> list[str]:
        """Kind and details, as the scripts' functions take them."""
        if self.words:
            return ["words", *self.words]
        if self.suffixes is not None:
            return ["files", *self.suffixes]
        return ["any"] if self.marks is None else ["folders", *self.marks]


class Option(NamedTuple):
    """An option by its names, such as ``-o`` and ``--output``; without value, a switch."""

    names: tuple[str, ...]
    help: str
    value: Value | None
    repeatable: bool


class Command(NamedTuple):
    """A command; the last of its `places` may be repeated."""

    name: str
    summary: str
    options: tuple[Option, ...]
    places: tuple[Value, ...]
    repeats: bool


#: Words, or marks of directories, by command and argument, where a metavar does not tell.
Known = Mapping[tuple[str, str], Value]


def read(name: str, summary: str, parser: argparse.ArgumentParser, known: Known) -> Command:
    """Return a command's words.

    Parameters
    ----------
    name, summary : str
        The command.
    parser : argparse.ArgumentParser
        Its parser.
    known : mapping
        Values by command and destination in the parser.
    """
    options, places, repeats = [], [], False
    for action in _actions(parser):
        value = known.get((name, action.dest)) or _value(action)
        if not action.option_strings:
            places.append(value)
            repeats = action.nargs in ("+", "*")
            continue
        takes = None if action.nargs == 0 else value
        repeatable = isinstance(action, argparse._AppendAction)
        said = parser._get_formatter()._expand_help(action)
        options.append(Option(tuple(action.option_strings), said, takes, repeatable))
    return Command(name, summary, tuple(options), tuple(places), repeats)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        if action.help != argparse.SUPPRESS:
            yield action


def _value(action: argparse.Action) -> Value:
    name = action.metavar if isinstance(action.metavar, str) else action.dest.upper()
    if action.choices is not None:
        return Value(name, words=tuple(map(str, action.choices)))
    if name in _FILES:
        return Value(name, suffixes=_FILES[name])
    stem, dot, suffix = name.rpartition(".")
    if dot and stem.isalpha() and suffix.isalpha():
        return Value(name, suffixes=_ALSO.get(suffix, (suffix,)))
    return Value(name, marks=()) if name in _FOLDERS else Value(name)
