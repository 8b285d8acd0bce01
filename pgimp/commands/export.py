"""``pgimp export FORMAT DIR``: frames for VTK and ParaView in place, or as CSV or VTU files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from pgimp.errors import UsageError, explain
from pgimp.utilities.plot.runs import frames_of, open_runs
from pgimp.utilities.plot.words import listed, numbers

_CHOICES = ("field", "frame", "time", "output", "revolve")

#: Fewest and most parts round the axis.
_PARTS = (3, 3600)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        "format",
        metavar="FORMAT",
        choices=("vtkhdf", "csv", "vtu"),
        help="vtkhdf: in place, what VTK needs to read the frames themselves, and DIR/*.vtkhdf, "
        "as runs have it from the start; csv: a table of each frame; vtu: a file of each frame "
        "for any reader, with .pvd for ParaView, also of the grid and of rigid bodies",
    )
    parser.add_argument("directory", metavar="DIR", help="a run directory")
    copies = parser.add_argument_group("for csv and vtu")
    copies.add_argument(
        "--field",
        metavar="NAME,...",
        help="only these fields of the particles, also what follows from their stress (default: "
        "all of the frame)",
    )
    copies.add_argument(
        "--frame", metavar="INDEX,...", help="only these frames (default: all); -1 is the last"
    )
    copies.add_argument(
        "--time", metavar="T,...", help="instead: the frames nearest to these times"
    )
    copies.add_argument(
        "--revolve",
        metavar="N",
        help="vtu of an axisymmetric scene: the particles revolved about the axis, each as a ring "
        "of N hexahedra, in 3D",
    )
    copies.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        help="where they go (default: a folder named after run and format, where pgimp is "
        "started); files of the same names are replaced",
    )


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        0, or 1 if a frame could not be read.

    Raises
    ------
    UsageError
        If the command line is wrong, or the run still writes frames; nothing is written.
    RunError
        If a file cannot be read or written.
    """
    if args.format == "vtkhdf":
        return _in_place(args)
    if args.frame is not None and args.time is not None:
        raise UsageError("--frame and --time do not go together")
    shown = open_runs([args.directory])[0]
    times = numbers(args.time, "--time", float)
    which = numbers(args.frame, "--frame", int)
    chosen = frames_of(shown, which, times) or shown.run.frames
    frames = [frame for _, frame in sorted({frame.number: frame for frame in chosen}.items())]
    fields = listed(args.field)
    parts = _parts(args, shown.case) if args.revolve is not None else 0

    from pgimp.utilities.export.files import grids, require_fields, tables

    require_fields(frames, fields)
    folder = Path(args.output or f"{Path(shown.name).name}-{args.format}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write = tables if args.format == "csv" else grids
        if parts:
            from pgimp.utilities.export.revolved import solids

            written = list(solids(folder, frames, fields, parts))
        else:
            written = list(write(folder, frames, fields))
    except OSError as error:
        raise UsageError(f"cannot write to {folder}: {explain(error)}") from error
    lists = [str(path) for path in written if path.suffix == ".pvd"]
    number = len(written) - len(lists)
    print(
        f"wrote {number} file{'s' * (number != 1)} to {folder}"
        + (f"; open {' or '.join(lists)}" if lists else "")
    )
    return 0


def _parts(args: argparse.Namespace, case: dict[str, Any]) -> int:
    if args.format != "vtu":
        raise UsageError(f"--revolve is for vtu, not for {args.format}")
    if case.get("geometry") != "axisymmetric":
        raise UsageError(
            f"--revolve is for axisymmetric scenes; the geometry of {args.directory} is "
            f"{case.get('geometry')}"
        )
    (count, *more) = numbers(args.revolve, "--revolve", int)
    if more or not _PARTS[0] <= count <= _PARTS[1]:
        raise UsageError(f"--revolve: expected one number from {_PARTS[0]} to {_PARTS[1]}")
    return count


def _in_place(args: argparse.Namespace) -> int:
    for name in _CHOICES:
        if getattr(args, name) is not None:
            option = "-o" if name == "output" else f"--{name}"
            raise UsageError(f"{option} is for csv and vtu; vtkhdf goes to all frames themselves")
    from pgimp.utilities.export.vtkseries import export

    open_runs([args.directory])
    wrong = False
    for line in export(Path(args.directory)):
        print(line)
        wrong = wrong or line.startswith("note: ")
    return int(wrong)
