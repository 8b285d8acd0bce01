"""Progress of a run: a bar at a terminal, occasional lines elsewhere."""

from __future__ import annotations

import os
import shutil
import sys
from contextlib import suppress
from math import isnan
from time import perf_counter
from typing import TYPE_CHECKING

from pgimp.mpi.comm import launcher
from pgimp.running.log import Log
from pgimp.terminal import unescaped

if TYPE_CHECKING:
    from rich.progress import Progress as Bar
    from rich.progress import TaskID

    from pgimp.solver.simulation import Simulation

# Reading the clock after every step would cost time in tiny scenes; this interval is enough.
_LOOK_SECONDS = 0.1
_BAR_SECONDS = 0.25
_FIRST_LINE_SECONDS = 10.0
_LONGEST_PAUSE_SECONDS = 60.0
_PAUSE_GROWTH = 1.5
_SMOOTHING = 0.4
_DEFAULT_COLUMNS = 80
# In a narrower terminal the numbers replace the bar.
_BAR_COLUMNS = 90


def terminal_columns() -> int:
    """Return the width of the user's terminal.

    Under mpirun every rank's own output looks like a terminal even in a batch job, so the
    launcher's own output counts.

    Returns
    -------
    int
        0 without a terminal.
    """
    if os.environ.get("TERM", "dumb") == "dumb":
        return 0
    if launcher() is None:
        return shutil.get_terminal_size().columns if sys.stdout and sys.stdout.isatty() else 0
    try:
        name = os.readlink(f"/proc/{os.getppid()}/fd/1")
        if not name.startswith(("/dev/pts/", "/dev/tty")):
            return 0
        descriptor = os.open(name, os.O_RDONLY | os.O_NOCTTY)
        try:
            return os.get_terminal_size(descriptor).columns or _DEFAULT_COLUMNS
        finally:
            os.close(descriptor)
    except OSError:
        return 0


class Progress:
    """Shows the progress of a run, on rank 0; negligible cost while nothing is due.

    Parameters
    ----------
    log : Log
        Receives plain lines; its terminal lines appear above the bar.
    end : float
        Simulated time at the end of the run.
    columns : int
        Width of the terminal; 0 for plain lines.
    """

    def __init__(self, log: Log, sim: Simulation, end: float, columns: int) -> None:
        self._sim = sim
        self._log = log
        self._end = end
        self._active = log.speaks
        self._stride = self._left = 1
        self._looked = self._shown = perf_counter()
        self._shown_at = (sim.time, sim.step)
        self._pause = _FIRST_LINE_SECONDS
        self._rates: tuple[float, float] | None = None
        self._bar: Bar | None = None
        if self._active and columns and not log.quiet:
            self._bar, self._task = _make_bar(columns, end)
            self._pause = _BAR_SECONDS
            self._bar.start()
            console = self._bar.console
            log.show = lambda text: console.print(
                text, markup=False, highlight=False, soft_wrap=True
            )

    def step(self) -> None:
        """Record a step."""
        self._left -= 1
        if self._left == 0 and self._active:
            self._look()

    def _look(self) -> None:
        now = perf_counter()
        each = max((now - self._looked) / self._stride, 1e-9)
        self._stride = self._left = max(1, min(2 * self._stride, int(_LOOK_SECONDS / each)))
        self._looked = now
        if now - self._shown >= self._pause:
            self._show(now)

    def _show(self, now: float) -> None:
        time, step = self._sim.time, self._sim.step
        seconds = now - self._shown
        latest = (time - self._shown_at[0]) / seconds, (step - self._shown_at[1]) / seconds
        old = self._rates or latest
        self._rates = (
            old[0] + _SMOOTHING * (latest[0] - old[0]),
            old[1] + _SMOOTHING * (latest[1] - old[1]),
        )
        self._shown, self._shown_at = now, (time, step)
        left = (self._end - time) / self._rates[0] if self._rates[0] > 0.0 else float("inf")
        imbalance = self._sim.balance.imbalance
        load = "" if imbalance is None else f"imbalance {100.0 * imbalance:.0f} %  "
        text = (
            f"t {time:.6g}/{self._end:.6g}  step {step}  dt {self._sim.dt:.3g}  "
            f"{self._rates[1] * self._sim.known_count:.3g} particle-steps/s  {load}"
            f"{duration(left)} left"
        )
        if self._sim.settling:
            known = not isnan(self._sim.unbalanced)  # it is compared once in some steps
            force = f"unbalanced force {self._sim.unbalanced:.2g}  " if known else ""
            text = (
                f"settling: {force}step {step}  "
                f"{self._rates[1] * self._sim.known_count:.3g} particle-steps/s"
            )
        if self._bar is not None:
            try:
                self._bar.update(self._task, completed=time, text=text, refresh=True)
            except OSError:
                self._log.detach_terminal()
                self.close()
            return
        self._pause = min(_PAUSE_GROWTH * self._pause, _LONGEST_PAUSE_SECONDS)
        self._log.say(f"{100.0 * time / self._end:3.0f} %  {text}")

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            with suppress(OSError):
                self._bar.stop()
            self._bar = None
            self._log.show = print
        self._active = False


def _make_bar(columns: int, end: float) -> tuple[Bar, TaskID]:
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bar
    from rich.table import Column

    text = TextColumn("{task.fields[text]}", table_column=Column(no_wrap=True, overflow="ellipsis"))
    parts: list[ProgressColumn] = [TaskProgressColumn(), text]
    if columns >= _BAR_COLUMNS:
        parts.insert(0, BarColumn(bar_width=min(30, columns - _DEFAULT_COLUMNS)))
    bar = Bar(
        *parts,
        console=Console(file=unescaped(sys.stdout), force_terminal=True, width=columns),
        auto_refresh=False,
        transient=True,
    )
    return bar, bar.add_task("", total=end, text="starting")


def duration(seconds: float) -> str:
    """Format a time span: 4.2 s, 3:05 min or 1:02:03 h.

    Parameters
    ----------
    seconds : float
        The span.

    Returns
    -------
    str
        The text; a question mark if the span is unknown.
    """
    if not seconds < 1e9:
        return "?"
    if seconds < 60.0:
        return f"{seconds:.3g} s" if seconds < 9.995 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes}:{rest:02d} min"
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d} h"
