"""Ctrl-C, held back until nothing is half done."""

from __future__ import annotations

import signal
import threading
from typing import Any


class Interrupt:
    """Keeps Ctrl-C from striking within a write, where HDF5 may swallow it; a context manager.

    The first Ctrl-C is only noted, and a second one strikes at once, as usual. Where the program
    around has a handler of its own, that one stays.

    Parameters
    ----------
    *also : int
        Further signals that are to act like Ctrl-C.
    """

    def __init__(self, *also: int) -> None:
        self.pending = False
        self._signals = (signal.SIGINT, *also)
        self._usual: dict[int, Any] = {}

    def __enter__(self) -> Interrupt:
        """Install the handler."""
        if threading.current_thread() is threading.main_thread():
            for number in self._signals:
                usual = signal.getsignal(number)
                if usual in (signal.default_int_handler, signal.SIG_DFL):
                    self._usual[number] = usual
                    signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        """Give the signals their usual effect again."""
        for number, usual in self._usual.items():
            signal.signal(number, usual)

    def _note(self, number: int, _: Any) -> None:
        self.pending = True
        signal.signal(number, self._usual[number])

    def check(self) -> None:
        """Raise if Ctrl-C was pressed, or one of the other signals came.

        Raises
        ------
        KeyboardInterrupt
            If so.
        """
        if self.pending:
            raise KeyboardInterrupt
