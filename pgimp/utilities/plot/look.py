"""How a figure looks: its options on the command line, and their values."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.utilities.plot.camera import Camera, upright
from pgimp.utilities.plot.runs import AXES
from pgimp.utilities.plot.style import MAP

#: Widths in inches and sizes of letters in points that can be drawn.
_WIDTHS, _LETTERS = (1.0, 40.0), (3.0, 40.0)
#: Colours of contours: by default, and at most.
_COLOURS, _MOST_COLOURS = 12, 100
#: Angle of a ring's piece in a picture of a body of revolution.
_PIECE = np.pi / 60.0


#: By axis, the coordinate.
Planes = tuple[tuple[int, float], ...]


class Look(NamedTuple):
    """Options of a picture."""

    #: (float, float) or None: Values of the first and the last colour.
    limits: tuple[float, float] | None = None
    map: str = MAP  #: matplotlib's name of the colours.
    panels: int = 0  #: Pictures side by side; 0 chooses.
    width: float = 0.0  #: Width of the figure in inches; 0 chooses.
    title: str | None = None  #: Title in place of the times; of several pictures above all of them.
    #: ndarray, shape (2, 2), or None: Corners of what is shown, if it is not what the particles
    #: fill.
    inside: np.ndarray | None = None
    #: Number of colours of smooth contours in place of particles; 0 for particles.
    contours: int = 0
    outline: bool = False  #: Whether bodies have outlines, as contours always do.


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options that pictures and curves share, and those of pictures."""
    looks = parser.add_argument_group("looks, as for a paper")
    looks.add_argument("--title", metavar="TEXT", help="title of the figure, in place of the times")
    looks.add_argument("--width", metavar="INCHES", help="width of the figure")
    looks.add_argument("--letters", metavar="POINTS", help="size of the letters (default: 10)")
    looks.add_argument("--font", metavar="FAMILY", help="the font, such as serif or Arial")
    looks.add_argument(
        "--style", metavar="FILE", help="settings for all of it: a style file of matplotlib"
    )
    looks.add_argument("--rate", metavar="N", help="frames of a movie in a second (default: 10)")
    looks.add_argument("--map", metavar="NAME", help=f"a frame's colours (default: {MAP})")
    looks.add_argument("--panels", metavar="N", help="pictures of frames side by side")
    looks.add_argument(
        "--contours",
        metavar="N",
        nargs="?",
        const=str(_COLOURS),
        help="smooth contours within each body's outline in place of particles, in about N "
        f"colours (default: {_COLOURS}); in 3D of a --slice",
    )
    looks.add_argument(
        "--outline", action="store_true", default=None, help="also the outline of each body"
    )
    looks.add_argument(
        "--revolve",
        metavar="DEGREES",
        nargs="?",
        const="270",
        help="the whole body of an axisymmetric scene, open towards the eye (default: 270 of 360 "
        "degrees)",
    )
    looks.add_argument(
        "--mirror",
        metavar="FACE,...",
        help="show bodies whole that are cut by planes of symmetry at these faces: x-min,y-min",
    )


def settings(args: argparse.Namespace) -> dict[str, object]:
    """Return the settings of matplotlib that the options ask for.

    Raises
    ------
    UsageError
        If a value is wrong, or the file is none.
    """
    found: dict[str, object] = {}
    if args.style is not None:
        from matplotlib import rc_params_from_file

        try:
            found.update(rc_params_from_file(args.style, use_default_template=False).items())
        except (OSError, ValueError) as error:
            raise UsageError(f"--style {args.style}: {error}") from error
    if args.letters is not None:
        found["font.size"] = _positive(args.letters, "--letters", _LETTERS)
    if args.font is not None:
        found["font.family"] = [args.font, "DejaVu Sans"]
    return found


def look(args: argparse.Namespace, limits: tuple[float, float] | None) -> Look:
    """Return the look of a picture.

    Parameters
    ----------
    args : argparse.Namespace
        With the options of `add_arguments`.
    limits : tuple of float, or None
        Ends of the colours.

    Raises
    ------
    UsageError
        If a value is wrong.
    """
    from matplotlib import colormaps

    name = args.map or MAP
    if name not in colormaps:
        raise UsageError(f"--map {name}: matplotlib has none of this name; such as magma, coolwarm")
    panels = 0
    if args.panels is not None:
        if not args.panels.isdecimal() or not 1 <= int(args.panels) <= 12:
            raise UsageError(f"--panels {args.panels}: a whole number from 1 to 12")
        panels = int(args.panels)
    count = 0
    if args.contours is not None:
        if not args.contours.isdecimal() or not 2 <= int(args.contours) <= _MOST_COLOURS:
            raise UsageError(
                f"--contours {args.contours}: a number of colours from 2 to {_MOST_COLOURS}, or "
                "none, behind the directories"
            )
        count = int(args.contours)
    return Look(
        limits, name, panels, width(args), args.title, contours=count, outline=bool(args.outline)
    )


def planes(text: str | None, origin: Sequence[float], corner: Sequence[float]) -> Planes:
    """Return the planes of symmetry of ``--mirror``.

    Parameters
    ----------
    text : str or None
        Faces of the domain, with commas between them.
    origin, corner : sequence of float
        Corners of the domain.

    Raises
    ------
    UsageError
        If there is no such face.
    """
    found = []
    for face in text.split(",") if text is not None else ():
        axis, _, end = face.strip().partition("-")
        if not axis or axis not in AXES[: len(origin)] or end not in ("min", "max"):
            raise UsageError(f"--mirror {text}: faces of the domain, such as x-min,y-min")
        number = AXES.index(axis)
        found.append((number, float((origin if end == "min" else corner)[number])))
    return tuple(found)


def revolved(args: argparse.Namespace, geometry: str) -> tuple[Camera, tuple[float, ...]]:
    """Return the camera of ``--revolve``, and the angles of `pieces`.

    Raises
    ------
    UsageError
        If the scene has another geometry, or other options do not go with it.
    """
    if geometry != "axisymmetric":
        raise UsageError(f"--revolve is for axisymmetric scenes; the geometry is {geometry}")
    for option in ("mirror", "contours", "outline", "csv"):
        if getattr(args, option) is not None:
            raise UsageError(f"--revolve and --{option} do not go together")
    if args.output and args.output.lower().endswith(".csv"):
        raise UsageError("--revolve is for pictures, not for a .csv")
    view = upright(args.camera)
    return view, pieces(args.revolve, view.towards)


def pieces(text: str, towards: np.ndarray) -> tuple[float, ...]:
    """Return the angles of ``--revolve`` about y, of pieces of rings; the gap is towards the eye.

    Parameters
    ----------
    text : str
        Degrees that are drawn.
    towards : (3,) float
        Unit vector towards the eye.

    Raises
    ------
    UsageError
        If the degrees are wrong.
    """
    whole = np.radians(_positive(text, "--revolve", (10.0, 360.0)))
    count = max(2, round(whole / _PIECE))
    eye = np.arctan2(-towards[2], towards[0])
    opens = eye + np.pi - 0.5 * whole
    return tuple(opens + whole * (np.arange(count) + 0.5) / count)


def rate(args: argparse.Namespace) -> float:
    """Return the frames of a movie in a second."""
    return 10.0 if args.rate is None else _positive(args.rate, "--rate", (0.1, 100.0))


def width(args: argparse.Namespace) -> float:
    """Return the width of the figure in inches; 0 without one."""
    return 0.0 if args.width is None else _positive(args.width, "--width", _WIDTHS)


def _positive(text: str, option: str, bounds: tuple[float, float]) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not bounds[0] <= value <= bounds[1]:
        raise UsageError(f"{option} {text}: a number from {bounds[0]:g} to {bounds[1]:g}")
    return value
