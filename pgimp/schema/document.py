"""Reading YAML into plain data, with the line of every key.

YAML 1.2 core schema, built from parser events, one at a time. There are no tags, aliases or
recursion, so no file can build more than its own content or nest too deeply.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    CollectionEndEvent,
    DocumentStartEvent,
    Event,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceStartEvent,
)
from ruamel.yaml.scanner import Scanner

from pgimp.errors import CaseError
from pgimp.schema.messages import describe, dotted, shorten
from pgimp.schema.syntax import explain_syntax, position
from pgimp.schema.words import lookalikes
from pgimp.storage.plain import read_some

LARGEST_FILE = 4_000_000
"""Bytes; a case is a few thousand, a table of a whole earthquake record some 100,000."""

DEEPEST = 32
"""Levels of nesting."""

MOST_VALUES = 200_000
"""Keys, values and list entries: some seconds of reading; a table of 50,000 rows."""

_LONGEST_SHOWN = 70

MOST_MESSAGES = 9
"""Lines about what is wrong; the mistakes in the others are often the same."""

Path = tuple[str | int, ...]

_NULL = ("", "~", "null", "Null", "NULL")
_TRUE = ("true", "True", "TRUE")
_FALSE = ("false", "False", "FALSE")
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass
class Document:
    """Plain data (dict, list, str, int, float, bool, None) with the line of each part."""

    data: Any
    locations: dict[Path, int | str] = field(default_factory=dict)
    """By path: the line of the key or the list item, or the override that wrote it."""
    old_keys: dict[Path, str] = field(default_factory=dict)
    """By path: the older name by which a key was written, see `pgimp.schema.words.renamed`."""
    old_values: dict[Path, str] = field(default_factory=dict)
    """By path: the older word as which a value was written."""

    def as_written(self, path: Path) -> Path:
        """Return a path by the names with which its keys were written."""
        return tuple(self.old_keys.get(path[: n + 1], key) for n, key in enumerate(path))

    def location(self, path: Path) -> int | str | None:
        """Return the location of `path`, or of the nearest part around it."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.locations:
                return self.locations[path[:length]]
        return None


def read(name: str | FilePath) -> bytes:
    """Return the content of a file; of a too large file only enough to detect it.

    Raises
    ------
    OSError
        If it cannot be read, or is a pipe without a writer.
    """
    return read_some(name, LARGEST_FILE + 1)


def decode(content: bytes, filename: str) -> str:
    """Return the text of a case file.

    Raises
    ------
    CaseError
        When it is too large, binary, or not UTF-8.
    """
    if len(content) > LARGEST_FILE:
        raise CaseError(f"{filename}: too large for a case file (at most {LARGEST_FILE:,} bytes)")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise CaseError(f"{filename}: UTF-16 text; save the file as UTF-8 text")
    if b"\0" in content:
        raise CaseError(f"{filename}: a binary file, not a case file (YAML text in UTF-8)")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = content[error.start]
        raise CaseError(
            f"{filename}:{line}: the byte 0x{byte:02x} is not UTF-8; save the file as UTF-8 text"
        ) from None


def parse(text: str, filename: str) -> Document:
    """Read YAML `text`.

    Raises
    ------
    CaseError
        With file, line and column of the part that is no YAML, or not allowed in a case file.
    """
    if len(text) > LARGEST_FILE:
        raise CaseError(f"{filename}: too large for a case file (at most {LARGEST_FILE:,} bytes)")
    text = text.removeprefix("\ufeff")
    if strange := _UNPRINTABLE.search(text):
        line = text.count("\n", 0, strange.start()) + 1
        raise CaseError(
            f"{filename}:{line}: the character U+{ord(strange[0]):04X} does not belong in a text "
            "file; is this a case file?"
        )
    builder = _Builder(filename)
    try:
        reader = YAML(typ="safe", pure=True)
        reader.Scanner = _Scanner
        for event in reader.parse(text):
            builder.take(event)
    except _ForeignError as error:
        raise CaseError(f"{position(filename, error.mark)}: {error}") from None
    except MarkedYAMLError as error:
        raise CaseError(explain_syntax(error, text, filename)) from None
    except (YAMLError, ValueError) as error:
        raise CaseError(f"{filename}: not valid YAML: {shorten(str(error), 200)}") from None
    if builder.twice:
        raise CaseError(few(builder.twice, filename))
    return Document(builder.root, builder.locations)


def few(lines: list[str], filename: str) -> str:
    """Return the first `MOST_MESSAGES` lines, and the number of further ones."""
    more = len(lines) - MOST_MESSAGES
    return "\n".join([*lines[:MOST_MESSAGES], *[f"{filename}: and {more} more"] * (more > 0)])


def scalar(text: str) -> object:
    """Return the value of an unquoted scalar by the core schema of YAML 1.2."""
    if text in _NULL:
        return None
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if _INTEGER.fullmatch(text):
        base = {"0o": 8, "0x": 16}.get(text[:2], 10)
        # Python converts no integers of thousands of digits; as float64 they are infinite anyway.
        return int(text, base) if len(text) <= 400 else float("inf")
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text


class _ForeignError(Exception):
    """YAML that is not allowed in a case file, with its location."""

    def __init__(self, text: str, mark: Any) -> None:
        super().__init__(text)
        self.mark = mark


class _Scanner(Scanner):
    """Refuses anchors, aliases and tags at their beginning: a tag of megabytes takes minutes."""

    def fetch_anchor(self) -> None:
        self._refuse("", "anchors and aliases; write it out")

    fetch_alias = fetch_anchor

    def fetch_tag(self) -> None:
        self._refuse("the tag ", "tags; leave it out")

    def _refuse(self, kind: str, why: str) -> None:
        found = re.match(r"[^\s\0,\[\]{}]*", self.reader.prefix(_LONGEST_SHOWN))
        name = shorten(found[0] if found else "")
        raise _ForeignError(f"{kind}'{name}': a case file has no {why}", self.reader.get_mark())


class _Builder:
    """Builds the data from events, with the open mappings and lists on its own stack."""

    def __init__(self, filename: str):
        self.filename = filename
        self.root: object = None
        self.locations: dict[Path, int | str] = {}
        self.twice: list[str] = []
        self.documents = self.values = 0
        self.open: list[tuple[object, Path]] = []
        self.key: str | None = None
        self.keys: list[str | None] = []

    def fail(self, event: Event, text: str) -> CaseError:
        return CaseError(f"{position(self.filename, event.start_mark)}: {text}")

    def take(self, event: Event) -> None:
        """Consume the next event of the parser."""
        if isinstance(event, DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                raise self.fail(event, "a case file holds one document; remove this '---'")
        elif isinstance(event, CollectionEndEvent):
            self.open.pop()
            self.key = self.keys.pop()
        elif isinstance(event, NodeEvent):
            self.values += 1
            if self.values > MOST_VALUES:
                raise self.fail(
                    event, f"more than {MOST_VALUES:,} keys and values are too many for a case"
                )
            self._node(event)

    def _node(self, event: NodeEvent) -> None:
        container, path = self.open[-1] if self.open else (None, ())
        if isinstance(container, dict) and self.key is None:
            if not isinstance(event, ScalarEvent) or not event.value:
                raise self.fail(event, "a key is a plain word before a colon")
            self._take_key(event, container, path)
            return
        value = self._value(event)
        if isinstance(container, dict) and self.key is not None:
            path = (*path, self.key)
            container[self.key] = value
            self.key = None
        elif isinstance(container, list):
            path = (*path, len(container))
            container.append(value)
            self.locations[path] = event.start_mark.line + 1
        else:
            self.root = value
        if isinstance(value, dict | list):
            if len(self.open) == DEEPEST:
                raise self.fail(event, f"nested deeper than {DEEPEST} levels")
            self.open.append((value, path))
            self.keys.append(None)

    def _take_key(self, event: ScalarEvent, container: dict[str, object], path: Path) -> None:
        self.key, line = event.value, event.start_mark.line + 1
        if strange := lookalikes.within(self.key):
            raise self.fail(event, _foreign(strange, f"the key '{_bare(self.key)}'"))
        if self.key in container:
            first = self.locations[(*path, self.key)]
            self.twice.append(
                f"{self.filename}:{line}: {dotted((*path, self.key))}: the key is there already, "
                f"in line {first}; remove one of them"
            )
        self.locations[(*path, self.key)] = line

    def _value(self, event: NodeEvent) -> object:
        if isinstance(event, MappingStartEvent):
            return {}
        if isinstance(event, SequenceStartEvent):
            return []
        assert isinstance(event, ScalarEvent)
        if event.style is not None:
            return event.value
        if strange := lookalikes.at_an_end(event.value):
            raise self.fail(event, _foreign(strange, f"'{_bare(event.value)}'"))
        return scalar(event.value)


def _bare(text: str) -> str:
    return shorten(lookalikes.SPACE.sub("", text))


def _foreign(character: str, what: str) -> str:
    instead = "a hyphen" if lookalikes.DASH.match(character) else "ordinary spaces"
    return (
        f"{lookalikes.named(character)} in or beside {what}, as text from a web page has; "
        f"type {instead} instead"
    )


def top_level(document: Document, filename: str) -> dict[str, object]:
    """Return the data of a case file, which is a mapping.

    Raises
    ------
    CaseError
        When the file is empty or no mapping.
    """
    data = document.data
    if data is None:
        raise CaseError(f"{filename}: the file is empty; a case starts with 'format: 1'")
    if not isinstance(data, dict):
        raise CaseError(
            f"{filename}: expected keys with values, such as 'format: 1', got {describe(data)}"
        )
    return data
