"""``pgimp plot DIR...``: curves of history and probes, pictures of frames, fields along a line."""

from __future__ import annotations

import argparse
import io
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pgimp.errors import UsageError, explain
from pgimp.storage import atomic
from pgimp.storage.plain import open_plain
from pgimp.utilities.plot.runs import AXES, PlotRun, open_runs, snapshots
from pgimp.utilities.plot.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FORMATS = ("png", "pdf", "svg")
_BEGINNINGS = {"png": rb"\x89PNG\r\n", "pdf": rb"%PDF-", "svg": rb"(<\?xml|<svg|\s)"}
_PICTURE_ONLY = ("slice", "camera", "range")
_LONGEST_NAME = 120


N = TypeVar("N")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The parser to add to.
    """
    parser.add_argument("directories", metavar="DIR", nargs="+", help="run directories")
    history = parser.add_argument_group("curves over time, unless a frame is asked for")
    history.add_argument(
        "--columns",
        "--y",
        metavar="NAME,...",
        help="columns of history.csv, also patterns as 'reaction.*' (default: energies, and what "
        "there is of work, errors, and the greatest component of each face's force)",
    )
    history.add_argument(
        "--probe",
        metavar="NAME,...",
        help="probes of the case, whose columns are then there beside those of the history",
    )
    history.add_argument(
        "--x",
        metavar="NAME",
        help="column along the axis (default: time), such as displacement.top-y with "
        "--y constraint.top-y",
    )
    frame = parser.add_argument_group("a frame")
    frame.add_argument(
        "--field",
        metavar="NAME",
        help="field or component: von-mises, stress.xx, velocity (its magnitude), velocity.x",
    )
    frame.add_argument(
        "--frame", metavar="INDEX,...", help="which frames; -1, the default, is the last"
    )
    frame.add_argument("--time", metavar="T,...", help="instead: the frames nearest to these times")
    frame.add_argument("--body", metavar="NAME,...", help="only these bodies")
    frame.add_argument("--slice", metavar="y=0.5", help="3D: only particles that this plane cuts")
    frame.add_argument(
        "--camera",
        metavar="FROM",
        help="3D: the face of the domain to look from, such as y-min, or corner (default), or a "
        "direction X,Y,Z; with = before a minus: --camera=-1,-2,1",
    )
    frame.add_argument(
        "--range", metavar="LOW,HIGH", help="ends of the colours; --range=-1,1 with a minus"
    )
    line = parser.add_argument_group("a frame's field along a line")
    line.add_argument(
        "--along", metavar="AXIS", help="x, y or z: the mean over the particles across"
    )
    line.add_argument(
        "--at", metavar="y=0.5,z=0.1", help="instead of the mean: each particle that reaches there"
    )
    parser.add_argument("--log", action="store_true", help="curves on a logarithmic axis")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FIG",
        help="a .png, .pdf, .svg or .csv (default: a .png named after runs and field, where pgimp "
        "is started)",
    )
    parser.add_argument("--csv", metavar="FILE", help="also a table of exactly what is drawn")


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        0.

    Raises
    ------
    UsageError
        If the command line is wrong; nothing is written.
    RunError
        If a file of a run cannot be read.
    """
    import matplotlib

    matplotlib.use("Agg")
    from pgimp.utilities.plot.style import STYLE

    style: Any = STYLE | {"svg.hashsalt": "pgimp"}
    _check(args)
    output = _output(args.output) if args.output else None
    table_path = _output(args.csv, ("csv",)) if args.csv else None
    if output and table_path and output.resolve() == table_path.resolve():
        raise UsageError(f"-o and --csv name the same file, {output}")
    runs = open_runs(args.directories)
    with matplotlib.rc_context(style):
        if _wants_frame(args):
            figure, table, remarks, name = _frame(args, runs)
        else:
            from pgimp.utilities.plot.curves import curves

            probes = listed(args.probe)
            figure, table, remarks = curves(
                runs, probes, listed(args.columns), args.x or "time", args.log
            )
            name = "-".join(dict.fromkeys(probes)) or "history"
        output = output or _output(_default_name(runs, name))
        if output.suffix.lower() == ".csv":
            _write(output, table.text())
        else:
            _write(output, _rendered(figure, output.suffix[1:].lower()))
    if table_path:
        _write(table_path, table.text())
    for remark in remarks:
        print(f"note: {remark}")
    print(f"wrote {output}" + (f" and {table_path}" if table_path else ""))
    return 0


def _wants_frame(args: argparse.Namespace) -> bool:
    names = ("field", "frame", "time", "body", "along", "at", *_PICTURE_ONLY)
    return any(getattr(args, name) is not None for name in names)


def _check(args: argparse.Namespace) -> None:
    """Refuse incompatible options."""
    together = [("frame", "time"), ("along", "slice"), ("along", "camera"), ("along", "range")]
    for first, second in together:
        if getattr(args, first) is not None and getattr(args, second) is not None:
            raise UsageError(f"--{first} and --{second} do not go together")
    if args.at is not None and args.along is None:
        raise UsageError("--at is for a line: give --along too, or cut a slice with --slice")
    if _wants_frame(args):
        for name in ("columns", "x", "probe"):
            if getattr(args, name) is not None:
                raise UsageError(f"--{name} is for curves over time, the other options for a frame")


def _frame(
    args: argparse.Namespace, runs: Sequence[PlotRun]
) -> tuple[Figure, Table, list[str], str]:
    from pgimp.utilities.plot.along import along
    from pgimp.utilities.plot.camera import camera
    from pgimp.utilities.plot.picture import picture
    from pgimp.utilities.plot.quantity import quantity
    from pgimp.utilities.plot.selection import Selection, parse_place

    times = numbers(args.time, "--time", float)
    places = numbers(args.frame, "--frame", int) or ([] if times else [-1])
    chosen = snapshots(runs, places, times)
    dimension = chosen[0].shown.dimension
    first = quantity(args.field, chosen[0].frame, dimension)
    quantities = [quantity(first.text, snapshot.frame, dimension) for snapshot in chosen]
    bodies = tuple(listed(args.body))
    if args.along is not None or (dimension == 1 and not args.slice and not args.camera):
        axes = range(dimension)
        name = args.along or "x"
        if name not in [AXES[axis] for axis in axes]:
            raise UsageError(f"--along {name}: the axes are {', '.join(AXES[:dimension])}")
        axis = AXES.index(name)
        place = parse_place(args.at, "--at", [one for one in axes if one != axis])
        if args.range is not None:
            raise UsageError("--range is for the colours of a picture; in 1D there are none")
        figure, table, remarks = along(chosen, quantities, Selection(bodies, place), axis, args.log)
        label = f"{first.text}-along-{name}"
    else:
        if args.log:
            raise UsageError("--log is for curves, not for pictures")
        if args.slice and dimension < 3:
            raise UsageError(f"--slice is for three dimensions; this case has {dimension}")
        place = parse_place(args.slice, "--slice", range(dimension))
        if len(place) > 1:
            raise UsageError(f"--slice {args.slice}: one plane, such as y=0.5; a line is --along")
        view = camera(args.camera, dimension, next(iter(place), None))
        figure, table, remarks = picture(
            chosen, quantities, Selection(bodies, place), view, _limits(args.range)
        )
        label = first.text
    which = "-".join(str(number) for number in dict.fromkeys(s.frame.number for s in chosen))
    return figure, table, remarks, f"{label}-{which}"


def listed(text: str | None) -> list[str]:
    """Return the words of an option, with commas between them."""
    return [part.strip() for part in text.split(",") if part.strip()] if text else []


def numbers(text: str | None, option: str, kind: Callable[[str], N]) -> list[N]:
    """Return the numbers of an option, with commas between them; a UsageError if they are none."""
    if text is None:
        return []
    try:
        return [kind(part) for part in text.split(",")]
    except ValueError:
        what = "whole numbers" if kind is int else "numbers"
        raise UsageError(f"{option} {text}: {what}, with commas between them") from None


def _limits(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    found = numbers(text, "--range", float)
    if len(found) != 2 or not float("-inf") < found[0] < found[1] < float("inf"):
        raise UsageError(f"--range {text}: two numbers, the lower one first, such as 0,5e4")
    return found[0], found[1]


def _default_name(runs: Sequence[PlotRun], name: str) -> str:
    names = "-".join(Path(shown.name).name for shown in runs)
    if len(names) > _LONGEST_NAME:
        names = f"{Path(runs[0].name).name}-and-{len(runs) - 1}-more"
    return f"{names}-{name}.png"


def _output(name: str, formats: Sequence[str] = (*_FORMATS, "csv")) -> Path:
    """Return the output path, after checking for an existing file."""
    path = Path(name)
    kind = path.suffix[1:].lower()
    if kind not in formats:
        endings = ", ".join(f".{one}" for one in formats)
        raise UsageError(f"{name}: the name must end in {endings}")
    if not path.parent.is_dir():
        raise UsageError(f"{name}: there is no folder {path.parent}")
    try:
        if path.is_dir():
            raise UsageError(f"{name} is a directory")
        if path.exists():
            with open_plain(path) as stream:
                beginning = stream.read(16)
            fits = (
                Table.is_one(beginning)
                if kind == "csv"
                else re.match(_BEGINNINGS[kind], beginning) is not None
            )
            if beginning and not fits:
                what = "table of pgimp plot" if kind == "csv" else f"{kind.upper()} file"
                raise UsageError(f"{name} exists and is no {what}; it is left as it is")
    except OSError as error:
        raise UsageError(f"cannot read {name}: {explain(error)}") from error
    return path


def _rendered(figure: Figure, kind: str) -> bytes:
    """Return the file of a figure; the same figure gives the same bytes."""
    stream = io.BytesIO()
    dates = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
    # Titles of a first row of pictures may exceed the layout's estimate.
    room, about = 0.08, dates.get(kind)
    figure.savefig(stream, format=kind, metadata=about, bbox_inches="tight", pad_inches=room)
    return stream.getvalue()


def _write(path: Path, content: str | bytes) -> None:
    try:
        atomic.write(path, content)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {explain(error)}") from error
