"""The look of every figure: one style, and colours that the colour-blind tell apart."""

from __future__ import annotations

from typing import Any

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
    "savefig.dpi": 110,
}
"""Settings of matplotlib, its ``rcParams``."""
