"""Style of all figures, with colours for the colour-blind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axis import Axis

BLUE, RED, GREEN, ORANGE, PURPLE, SKY, GREY, BROWN = (
    "#0067b1",
    "#d0500b",
    "#00936d",
    "#e0a000",
    "#b6579a",
    "#4aa8df",
    "#8a8a8a",
    "#5d4037",
)
COLOURS = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, GREY, BROWN)
"""Colours of curves in their order, of different lightness where their hues are confused."""

MARKERS = "os^vDPX*"
"""Markers of curves in their order."""

DASHES = ("-", "--", ":", "-.")
"""Line styles of curves, for those beyond the number of colours."""

MAP = "viridis"
"""Colours of values: as even in lightness as in hue."""

STYLE: dict[str, Any] = {
    "font.size": 10,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.limits": (-4, 5),
    "axes.formatter.use_mathtext": True,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.h_pad": 0.07,
    "savefig.dpi": 110,
}
"""Settings of matplotlib, its ``rcParams``."""


def plain(text: str) -> str:
    """Return a name with escaped dollar signs, which matplotlib would read as mathematics."""
    return text.replace("$", r"\$")


_FEW_DECADES = 2.3
_LEAST_DECADES = 1.0


def log_ticks(ticks: Axis) -> None:
    """Label a logarithmic axis without collisions, and with more than one label.

    Parameters
    ----------
    ticks : matplotlib.axis.Axis
        The axis, with its final limits. Labels are powers of ten over many decades, 1, 2 and 5 of
        each over few, round numbers over less than a decade.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    low, high = sorted(ticks.get_view_interval())
    if low <= 0.0:
        return
    decades = math.log10(high / low)
    ticks.set_minor_formatter(NullFormatter())
    if decades < _FEW_DECADES:
        few = decades < _LEAST_DECADES
        ticks.set_major_locator(MaxNLocator(4) if few else LogLocator(subs=(1.0, 2.0, 5.0)))
        ticks.set_major_formatter(FuncFormatter(lambda value, _: _number(value)))


def _number(value: float) -> str:
    """Return a number in the simplest form: 20, 0.005, or with a power of ten."""
    if 1.0e-3 <= value < 1.0e4:
        return f"{value:g}"
    mantissa, _, exponent = f"{value:e}".partition("e")
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if float(mantissa) == 1.0 else f"${float(mantissa):g}\\times {power}$"
