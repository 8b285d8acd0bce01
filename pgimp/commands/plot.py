"""``pgimp plot DIR...``: curves of history and probes, pictures of frames, fields along a line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pgimp.errors import UsageError
from pgimp.utilities.plot.curves.changes import add_arguments as add_changes
from pgimp.utilities.plot.curves.changes import changes
from pgimp.utilities.plot.curves.spectra import add_arguments as add_spectra
from pgimp.utilities.plot.curves.spectra import band
from pgimp.utilities.plot.look import Look, look, planes, rate, revolved, settings
from pgimp.utilities.plot.look import add_arguments as add_looks
from pgimp.utilities.plot.output import MOVIES, output_path, rendered, write
from pgimp.utilities.plot.runs import AXES, PlotFrame, PlotRun, every_snapshot, open_runs, snapshots
from pgimp.utilities.plot.tables import Table
from pgimp.utilities.plot.words import limits, listed, numbers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pgimp.utilities.plot.camera import Camera
    from pgimp.utilities.plot.selection import Selection

_PICTURE_ONLY = (
    "slice", "camera", "range", "map", "panels", "mirror", "contours", "outline", "revolve",
)  # fmt: skip
_CURVES_ONLY = (
    "columns", "x", "probe", "factor", "factor_x", "over", "mean", "fft", "frequencies", "between",
)  # fmt: skip
_NOT_OF_SURFACES = ("field", "slice", "at", "mirror", "contours", "outline", "revolve", "panels")
_LONGEST_NAME = 120


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
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
    add_changes(history)
    add_spectra(history)
    frame = parser.add_argument_group("a frame")
    frame.add_argument(
        "--field",
        metavar="NAME",
        help="field or component: von-mises, stress.xx, velocity (its magnitude), velocity.x",
    )
    frame.add_argument(
        "--surface",
        metavar="NAME",
        help="instead: a quantity of surfaces that meet, such as contact-pressure or traction.x: "
        "in 2D over the length of the outline, or --along an axis, in 3D as a map",
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
    add_looks(parser)
    parser.add_argument("--log", action="store_true", help="curves on a logarithmic axis")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FIG",
        help="a .png, .pdf, .svg or .csv, or .gif or .mp4, a movie of all frames (default: a .png "
        "named after runs and field, where pgimp is started)",
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

    _check(args)
    style: Any = STYLE | {"svg.hashsalt": "pgimp"} | settings(args)
    output = output_path(args.output) if args.output else None
    table_path = output_path(args.csv, ("csv",)) if args.csv else None
    if output and table_path and output.resolve() == table_path.resolve():
        raise UsageError(f"-o and --csv name the same file, {output}")
    runs = open_runs(args.directories)
    with matplotlib.rc_context(style):
        if output and (kind := output.suffix[1:].lower()) in MOVIES:
            write(output, _movie(args, runs, kind))
            print(f"wrote {output}")
            return 0
        if args.rate is not None:
            raise UsageError("--rate is for a movie: name one with -o, such as run.gif")
        if _wants_frame(args):
            figure, table, remarks, name = _frame(args, runs)
        else:
            from pgimp.utilities.plot.curves.curves import curves

            probes = listed(args.probe)
            figure, table, remarks = curves(
                runs,
                probes,
                listed(args.columns),
                args.x or "time",
                args.log,
                look(args, None),
                changes(args),
                band(args),
            )
            name = "-".join(dict.fromkeys(probes)) or "history"
            name += "-spectrum" * args.fft
        output = output or output_path(_default_name(runs, name))
        if output.suffix.lower() == ".csv":
            write(output, table.text())
        else:
            write(output, rendered(figure, output.suffix[1:].lower()))
    if table_path:
        write(table_path, table.text())
    for remark in remarks:
        print(f"note: {remark}")
    print(f"wrote {output}" + (f" and {table_path}" if table_path else ""))
    return 0


def _wants_frame(args: argparse.Namespace) -> bool:
    names = ("field", "surface", "frame", "time", "body", "along", "at", *_PICTURE_ONLY)
    return any(getattr(args, name) is not None for name in names)


def _check(args: argparse.Namespace) -> None:
    """Refuse incompatible options."""
    together = [("frame", "time"), ("along", "slice"), ("along", "camera"), ("along", "range")]
    for first, second in together:
        if getattr(args, first) is not None and getattr(args, second) is not None:
            raise UsageError(f"--{first} and --{second} do not go together")
    if args.at is not None and args.along is None:
        raise UsageError("--at is for a line: give --along too, or cut a slice with --slice")
    for name in _NOT_OF_SURFACES if args.surface is not None else ():
        if getattr(args, name) is not None:
            raise UsageError(f"--{name} is for particles, not for --surface")
    if _wants_frame(args):
        for name in _CURVES_ONLY:
            if getattr(args, name) not in (None, False):
                option = name.replace("_", "-")
                raise UsageError(
                    f"--{option} is for curves over time, the other options for a frame"
                )


def _frame(
    args: argparse.Namespace, runs: Sequence[PlotRun]
) -> tuple[Figure, Table, list[str], str]:
    from pgimp.utilities.plot.along import along
    from pgimp.utilities.plot.picture import picture
    from pgimp.utilities.plot.quantity import quantity
    from pgimp.utilities.plot.selection import Selection, parse_place

    times = numbers(args.time, "--time", float)
    places = numbers(args.frame, "--frame", int) or ([] if times else [-1])
    chosen = snapshots(runs, places, times)
    dimension = chosen[0].shown.dimension
    if args.surface is not None:
        return _surface(args, chosen)
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
        for option in ("range", "map", "panels", "mirror", "contours", "outline", "revolve"):
            if getattr(args, option) is not None:
                raise UsageError(f"--{option} is for a picture; in 1D, and --along, there is none")
        figure, table, remarks = along(chosen, quantities, Selection(bodies, place), axis, args.log)
        seen = look(args, None)
        if seen.title:
            figure.axes[0].set_title(seen.title, fontsize="medium")
        if seen.width:
            figure.set_figwidth(seen.width)
        label = f"{first.text}-along-{name}"
    else:
        figure, table, remarks = picture(chosen, quantities, *_seen(args, chosen[0].shown))
        label = first.text
    which = "-".join(str(number) for number in dict.fromkeys(s.frame.number for s in chosen))
    return figure, table, remarks, f"{label}-{which}"


def _surface(
    args: argparse.Namespace, chosen: Sequence[PlotFrame]
) -> tuple[Figure, Table, list[str], str]:
    """Draw a quantity of surfaces."""
    from pgimp.utilities.plot.surface import curves_of_surfaces, map_of_surfaces

    shown, bodies, name = chosen[0].shown, listed(args.body), args.surface
    if shown.dimension == 1:
        raise UsageError("--surface: in 1D a surface is a point; contact.* of the history has it")
    if shown.dimension == 3:
        if len(chosen) > 1 or args.along is not None:
            raise UsageError("--surface: in 3D it is a map of one frame")
        _, view, seen = _seen(args, shown)
        figure, table = map_of_surfaces(chosen[0], name, bodies, view, seen)
    else:
        if args.along not in (None, *AXES[:2]):
            raise UsageError(f"--along {args.along}: the axes are x, y")
        axis = None if args.along is None else AXES.index(args.along)
        figure, table = curves_of_surfaces(chosen, name, bodies, axis)
        seen = look(args, None)
        if seen.title:
            figure.axes[0].set_title(seen.title, fontsize="medium")
        if seen.width:
            figure.set_figwidth(seen.width)
    which = "-".join(str(number) for number in dict.fromkeys(s.frame.number for s in chosen))
    return figure, table, [], f"{name}-{which}"


def _seen(args: argparse.Namespace, shown: PlotRun) -> tuple[Selection, Camera, Look]:
    """Return what a picture shows of a run, from where, and its look."""
    from pgimp.utilities.plot.camera import camera
    from pgimp.utilities.plot.selection import Selection, parse_place

    dimension = shown.dimension
    if args.log:
        raise UsageError("--log is for curves, not for pictures")
    if args.slice and dimension < 3:
        raise UsageError(f"--slice is for three dimensions; this case has {dimension}")
    place = parse_place(args.slice, "--slice", range(dimension))
    if len(place) > 1:
        raise UsageError(f"--slice {args.slice}: one plane, such as y=0.5; a line is --along")
    if args.revolve is not None:
        view, angles = revolved(args, shown.case.get("geometry", "plane-strain"))
        selection = Selection(tuple(listed(args.body)), spacing=shown.spacing, angles=angles)
        return selection, view, look(args, limits(args.range, "--range"))
    view = camera(args.camera, dimension, next(iter(place), None))
    mirrored = planes(args.mirror, *shown.corners) if args.mirror is not None else ()
    selection = Selection(tuple(listed(args.body)), place, shown.spacing, mirrored)
    return selection, view, look(args, limits(args.range, "--range"))


def _movie(args: argparse.Namespace, runs: Sequence[PlotRun], kind: str) -> bytes:
    """Return the movie of all frames of a run."""
    from pgimp.utilities.movie.movie import movie
    from pgimp.utilities.plot.quantity import quantity

    wrong = [name for name in ("frame", "time", "along", "csv", "panels") if getattr(args, name)]
    if wrong or len(runs) > 1:
        option = f"--{wrong[0]}" if wrong else "several runs"
        raise UsageError(f"a movie shows all frames of one run: leave {option} out")
    (shown,) = runs
    if shown.dimension == 1:
        raise UsageError("a movie is of pictures; in 1D there are none")
    chosen = every_snapshot(shown)
    first = quantity(args.field, chosen[0].frame, shown.dimension)
    quantities = [quantity(first.text, each.frame, shown.dimension) for each in chosen]
    return movie(kind, chosen, quantities, *_seen(args, shown), rate(args))


def _default_name(runs: Sequence[PlotRun], name: str) -> str:
    names = "-".join(Path(shown.name).name for shown in runs)
    if len(names) > _LONGEST_NAME:
        names = f"{Path(runs[0].name).name}-and-{len(runs) - 1}-more"
    return f"{names}-{name}.png"
