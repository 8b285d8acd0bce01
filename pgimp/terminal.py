"""The standard streams of the command: always open, without control characters, allowed to break.

Names, titles and messages may come from files of others, and a terminal obeys escape sequences in
them; so all output is escaped here, on its way out.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from typing import Any, cast

# Control characters but newline and tab, characters that turn the direction of text or are
# invisible, other line separators, surrogates (which names of files may have).
_UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    "\ufeff\ufff9-\ufffb\ud800-\udfff\U000e0000-\U000e007f]"
)


def escape(text: str) -> str:
    r"""Return text that a terminal only shows: an escape character becomes ``\x1b``.

    Parameters
    ----------
    text : str
        Any text; newlines and tabs stay.
    """
    return _UNSAFE.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def reopen() -> None:
    """Open the null device in place of each standard stream that is closed.

    Cron jobs and daemons may start without. The next file that is opened would get the stream's
    number, and output would end up among its data.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            # The lowest free number, which is this one; other programs are to have it too.
            flags = os.O_RDONLY if mode == "r" else os.O_WRONLY
            os.set_inheritable(os.open(os.devnull, flags), True)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, closefd=False))


class Escaping:
    """A text stream that escapes characters that control a terminal.

    Parameters
    ----------
    raw : text stream
        The stream behind it.
    last : bool
        Whether it is the last one, whose failure cannot be reported; it then goes silent.

    Attributes
    ----------
    error : OSError or None
        The last error of the stream behind it.
    """

    def __init__(self, raw: Any, last: bool = False) -> None:
        self.raw = raw
        self.error: OSError | None = None
        self._last = last

    def write(self, text: str) -> int:
        """Write text, escaped."""
        self._try(self.raw.write, escape(text))
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        self._try(self.raw.flush)

    def _try(self, action: Callable[..., object], *text: str) -> None:
        try:
            action(*text)
        except OSError as error:
            self.error = error
            if not self._last:
                raise
            silence(self.raw)

    def __getattr__(self, name: str) -> object:
        """Delegate everything else to the stream."""
        return getattr(self.raw, name)


def unescaped(stream: Any) -> Any:
    """Return the stream behind one that escapes, for progress bars; another one as it is."""
    return stream.raw if isinstance(stream, Escaping) else stream


def silence(stream: Any) -> None:
    """Redirect a broken stream to the null device, with its pending output."""
    with suppress(OSError, ValueError, AttributeError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())
        os.close(null)
        stream.flush()


@contextmanager
def guarded() -> Iterator[Escaping]:
    """Escape the output to stdout and stderr; a context manager that gives the first.

    At its end they are flushed, so that the interpreter cannot fail on them when it exits.
    """
    streams = sys.stdout, sys.stderr
    for stream in streams:
        # Another program's stream may have no such method; a title may have any character.
        with suppress(AttributeError, ValueError):
            cast(TextIOWrapper, stream).reconfigure(errors="backslashreplace")
    out = Escaping(sys.stdout)
    sys.stdout, sys.stderr = out, Escaping(sys.stderr, last=True)  # type: ignore[assignment]
    try:
        yield out
    finally:
        sys.stdout, sys.stderr = streams
        for stream in streams:
            try:
                stream.flush()
            except (OSError, ValueError):
                silence(stream)
