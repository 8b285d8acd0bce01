"""Ctrl-C, held back until nothing is half done."""

from __future__ import annotations

import signal
import threading
from typing import Any


class Interrupt:
    """Keeps Ctrl-C from striking within a write, where HDF5 may swallow it; a context manager.

    The first Ctrl-C is only noted, and a second one strikes at once, as usual. Where the program
    around has a handler of its own, that one stays.
    """

    def __init__(self) -> None:
        self.pending = False
        self._installed = False

    def __enter__(self) -> Interrupt:
        """Install the handler."""
        here = threading.current_thread() is threading.main_thread()
        if here and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._note)
            self._installed = True
        return self

    def __exit__(self, *_: object) -> None:
        """Give Ctrl-C its usual effect again."""
        if self._installed:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _note(self, *_: Any) -> None:
        self.pending = True
        signal.signal(signal.SIGINT, signal.default_int_handler)

    def check(self) -> None:
        """Raise if Ctrl-C was pressed.

        Raises
        ------
        KeyboardInterrupt
            If so.
        """
        if self.pending:
            raise KeyboardInterrupt
