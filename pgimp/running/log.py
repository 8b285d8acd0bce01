"""log.txt: the terminal's lines, and at the end the time of each phase."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from pgimp.terminal import escape, silence

#: How lines of warnings begin.
_WARNING = "warning: "


class Log:
    """Writes lines to the terminal and to a file, only on rank 0.

    Parameters
    ----------
    speaks : bool
        Whether this is rank 0.
    quiet : bool
        Whether the terminal gets nothing.

    Attributes
    ----------
    warnings : list of str
        The warnings shown so far, on rank 0.
    show : callable
        Writes a line to the terminal; a progress bar replaces it to stay below the line.
    """

    def __init__(self, speaks: bool, quiet: bool = False) -> None:
        self.speaks = speaks
        self.quiet = quiet
        self.warnings: list[str] = []
        self.show: Callable[[str], object] = print
        self._file: TextIO | None = None
        self._early: list[str] = []

    def say(self, text: str) -> None:
        """Show a line and write it to the file."""
        if not self.speaks:
            return
        text = escape(text)
        if text.startswith(_WARNING):
            self.warnings.append(text.removeprefix(_WARNING))
        if not self.quiet and sys.stdout is not None:
            try:
                self.show(text)
                sys.stdout.flush()
            except OSError:
                self.detach_terminal()
        self.note(text)

    def detach_terminal(self) -> None:
        """Continue without the terminal: it was closed, or the reader of a pipe has ended."""
        self.quiet = True
        silence(sys.stdout)

    def note(self, text: str) -> None:
        """Write a line to the file without showing it."""
        if not self.speaks:
            return
        if self._file is None:
            self._early.append(text)
            return
        try:
            self._file.write(f"{escape(text)}\n")
            self._file.flush()
        except OSError:
            # A disk too full for this line stops the run at the next frame, with its message.
            self.close()

    def write_to(self, path: Path) -> None:
        """Write lines to a file from now on, with all previous lines."""
        if self.speaks:
            with suppress(OSError):
                self._file = open(path, "a", encoding="utf-8")
            early, self._early = self._early, []
            for text in early:
                self.note(text)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            with suppress(OSError):
                self._file.close()
            self._file = None


#: Phases in which no rank waits for another.
_BUSY = ("P2G", "momentum", "G2P", "order", "sort")


def timing_table(timings: Sequence[Mapping[str, float]] | None, total: float) -> str:
    """Format the time of each phase of a run.

    Parameters
    ----------
    timings : sequence of mapping, or None
        Seconds of each phase, rank by rank; None except on rank 0.
    total : float
        Wall time of the run in seconds; the remainder after all phases is the line "other".

    Returns
    -------
    str
        A line per phase: minimum, mean and maximum over the ranks, and share of the wall time. On
        several ranks also the imbalance of the phases without waiting. Empty except on rank 0.
    """
    if timings is None:
        return ""
    gathered = [{**seconds, "other": total - sum(seconds.values())} for seconds in timings]
    phases = list(dict.fromkeys(phase for rank in gathered for phase in rank))
    width = max(len("phase"), *(len(phase) for phase in phases))
    lines = [
        f"Seconds by phase over {len(gathered)} rank{'s' if len(gathered) > 1 else ''}:",
        f"{'phase':<{width}} {'min':>11} {'mean':>11} {'max':>11} {'share':>8}",
    ]
    for phase in phases:
        values = [rank.get(phase, 0.0) for rank in gathered]
        mean = sum(values) / len(values)
        share = 100.0 * mean / total if total > 0.0 else 0.0
        lines.append(
            f"{phase:<{width}} {min(values):>11.4f} {mean:>11.4f} {max(values):>11.4f} "
            f"{share:>6.1f} %"
        )
    lines.append(f"{'total':<{width}} {'':>11} {total:>11.4f} {'':>11} {100:>6.1f} %")
    busy = [sum((rank.get(phase, 0.0) for phase in _BUSY), 0.0) for rank in gathered]
    if len(gathered) > 1 and any(busy):
        excess = 100.0 * (max(busy) * len(busy) / sum(busy) - 1.0)
        names = ", ".join(_BUSY[:-1])
        lines.append(
            f"imbalance {excess:.0f} %: the busiest rank's {names} and {_BUSY[-1]} over the mean"
        )
    return "\n".join(lines)
