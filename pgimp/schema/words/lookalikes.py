"""Characters that look like a space or a minus and are none, as in text from a web page."""

from __future__ import annotations

import re

_SPACES = "\u00a0\u1680\u2000-\u200d\u202f\u205f\u2060\u3000\ufeff"
_DASHES = "\u2010-\u2015\u2212\ufe63\uff0d"
_NAMES = {"\u00a0": "a non-breaking space", "\u2212": "a typographic minus"}

SPACE, DASH = re.compile(f"[{_SPACES}]"), re.compile(f"[{_DASHES}]")

#: In a line of YAML: a space of another kind where the structure is.
IN_STRUCTURE = re.compile(rf"(?:^|[:,\[{{-])[ \t]*([{_SPACES}])|^[^#]*([{_SPACES}])[ \t]*:")


def named(character: str) -> str:
    """Return what a character is, with its code: ``a non-breaking space (U+00A0)``."""
    kind = "a space of another kind" if SPACE.match(character) else "a dash of another kind"
    return f"{_NAMES.get(character, kind)} (U+{ord(character):04X})"


def at_an_end(text: str) -> str:
    """Return the first space of another kind at either end of `text`; empty without one."""
    found = SPACE.match(text) or SPACE.match(text[-1:])
    return found[0] if found else ""


def within(text: str) -> str:
    """Return the first space or dash of another kind in `text`; empty without one."""
    found = SPACE.search(text) or DASH.search(text)
    return found[0] if found else ""


def plain(text: str) -> str:
    """Return `text` with dashes as ASCII writes them, and without spaces of another kind."""
    return DASH.sub("-", SPACE.sub("", text))
