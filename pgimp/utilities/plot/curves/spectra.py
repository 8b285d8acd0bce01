"""Spectra in place of curves over time: the options, and what is drawn."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.utilities.plot.curves.series import Series
from pgimp.utilities.plot.curves.spectrum import MIN_LINES, Spectrum, spectrum
from pgimp.utilities.plot.words import limits

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = np.ndarray
Peak = tuple[float, float]

#: Name of the column along the axis.
FREQUENCY = "frequency"
#: Peaks of a curve that are labelled at most.
_PEAKS = 5
#: Shown frequencies over that of the last peak, where the command line names none.
_BEYOND = 4.0
#: Width of a label over that of the frequencies.
_LABEL = 0.1
#: Greatest over mean time between lines, above which a remark tells what is lost.
_UNEVEN = 1.5


class Band(NamedTuple):
    """What of the curves is transformed, and what of the spectra is shown."""

    #: times, frequencies: (float, float) or None: Ends of the times and of the frequencies; None
    #: for all, and for those around the peaks.
    times: tuple[float, float] | None = None
    frequencies: tuple[float, float] | None = None


class Spectra(NamedTuple):
    """The spectra of the columns of a run or probe."""

    values: dict[str, Array]  #: `FREQUENCY` and amplitudes by column, each of shape (n,).
    #: dict of str to list of (float, float): Frequency and amplitude of the shown peaks, by column.
    peaks: dict[str, list[Peak]]
    remarks: list[str]  #: What was found, and what was done with the lines.


def add_arguments(group: argparse._ArgumentGroup) -> None:
    """Declare the options of spectra."""
    group.add_argument(
        "--fft",
        action="store_true",
        help="the amplitude spectrum of the columns in place of them, with its peaks",
    )
    group.add_argument(
        "--frequencies", metavar="LOW,HIGH", help="of a spectrum, the frequencies that are shown"
    )
    group.add_argument(
        "--between", metavar="T,T", help="of a spectrum, the times of the lines that are taken"
    )


def band(args: argparse.Namespace) -> Band | None:
    """Return what the options ask for, None for curves over time.

    Raises
    ------
    UsageError
        If ends are none, or without ``--fft``.
    """
    for option in ("between", "frequencies"):
        if not args.fft and getattr(args, option) is not None:
            raise UsageError(f"--{option} is for a spectrum: give --fft too")
    if not args.fft:
        return None
    return Band(limits(args.between, "--between"), limits(args.frequencies, "--frequencies"))


def spectra(
    one: Series, values: Mapping[str, Array], names: Sequence[str], chosen: Band
) -> Spectra:
    """Return the spectra of columns over time.

    Parameters
    ----------
    one : Series
        Where they are from.
    values : mapping of str to ndarray
        ``time`` and the columns, each of shape (lines,).
    names : sequence of str
        The columns.
    chosen : Band
        The times that count, and the frequencies that are shown.

    Raises
    ------
    UsageError
        If no column has enough lines.
    """
    time = np.asarray(values["time"], float)
    low, high = chosen.times or (-np.inf, np.inf)
    within = np.isfinite(time) & (time >= low) & (time <= high)
    finite = {name: within & np.isfinite(values[name]) for name in names}
    enough = [name for name in names if finite[name].sum() >= MIN_LINES]
    rows = within & np.all([finite[name] for name in enough], axis=0) if enough else within
    rows = _increasing(time, rows)
    if not enough or len(rows) < MIN_LINES:
        raise UsageError(
            f"{one.shown.path}: a spectrum needs {MIN_LINES} lines or more with values"
            f"{' at these times' if chosen.times else ''}; there are {len(rows)}"
        )
    found = {name: spectrum(time[rows], np.asarray(values[name])[rows]) for name in enough}
    peaks = {name: each.peaks(_PEAKS) for name, each in found.items()}
    first = found[enough[0]]
    unit = one.shown.unit(FREQUENCY)
    label = f"{one.shown.path}{f', probe {one.probe}' if one.probe else ''}"
    remarks = [f"{label}: {text}" for text in _told(first, peaks, unit)]
    for name in names:
        if name not in enough:
            count = finite[name].sum()
            remarks.append(f"{label}: {name} has {count} lines with values, too few for a spectrum")
    last = max((f for each in peaks.values() for f, _ in each), default=np.inf)
    least, most = chosen.frequencies or (0.0, _BEYOND * last)
    shown = (first.frequency >= least) & (first.frequency <= most)
    if not shown.any():
        raise UsageError(
            f"--frequencies: the spectrum of {label} goes from 0 to "
            f"{first.frequency[-1]:.4g} {unit}".rstrip()
        )
    none = np.full(len(first.frequency), np.nan)
    curves = {name: found[name].amplitude if name in found else none for name in names}
    drawn = {FREQUENCY: first.frequency} | curves
    values = {name: column[shown] for name, column in drawn.items()}
    inside = {
        name: [peak for peak in each if least <= peak[0] <= most] for name, each in peaks.items()
    }
    return Spectra(values, inside, remarks)


def label_peaks(axis: Axes, peaks: Sequence[tuple[Peak, str]], deep: int) -> None:
    """Write their frequencies above peaks.

    Parameters
    ----------
    axis : matplotlib.axes.Axes
        The panel, with its final limits.
    peaks : sequence of ((float, float), str)
        Frequency and amplitude, and the colour of the curve.
    deep : int
        Most labels above each other; a further one at the place of a higher peak is left out.
    """
    low, high = axis.get_xlim()
    placed: list[tuple[float, float]] = []
    for (frequency, amplitude), colour in sorted(peaks, key=lambda one: -one[0][1]):
        near = [y for x, y in placed if abs(frequency - x) < _LABEL * (high - low)]
        if len(near) >= deep:
            continue
        y = near[0] if near else amplitude
        placed.append((frequency, y))
        axis.annotate(
            f"{frequency:#.4g}",
            (frequency, y),
            xytext=(0.0, 3.0 + 10.0 * len(near)),
            textcoords="offset points",
            ha="center",
            fontsize=8.5,
            color=colour,
        )


def _increasing(time: Array, rows: Array) -> Array:
    """Return numbers of rows whose times increase: of lines at one time, as of stages, the last."""
    found = np.flatnonzero(rows)[::-1]
    return np.sort(found[np.unique(time[found], return_index=True)[1]])


def _told(one: Spectrum, peaks: Mapping[str, Sequence[Peak]], unit: str) -> list[str]:
    """Describe the peaks, and what was done with uneven lines."""
    told = []
    for name, each in peaks.items():
        text = ", ".join(f"{f:#.4g} {unit}".rstrip() + f" (amplitude {a:.4g})" for f, a in each)
        told.append(f"peaks of {name}: {text or 'none'}")
    told[-1] += f"; resolution {one.resolution:.3g} {unit}".rstrip()
    if not one.even:
        least, most = one.gaps
        text = f"its lines are {least:.4g} to {most:.4g} apart: resampled to even steps by cubics"
        if most > _UNEVEN * 0.5 / one.frequency[-1]:
            text += f"; what is above {0.5 / most:.4g} {unit} may be wrong"
        told.append(text)
    return told
