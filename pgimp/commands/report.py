"""``pgimp report DIR``: one page of HTML of a run, also while it goes on, or of a study."""

from __future__ import annotations

import argparse
from pathlib import Path

from pgimp.errors import UsageError
from pgimp.io.rundir.ownfiles import REPORT, RUN


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument("directory", metavar="DIR", help="the directory of a run, or of a study")
    parser.add_argument(
        "-o", "--output", metavar="FILE.html", help=f"the page (default: {REPORT} in DIR)"
    )
    parser.add_argument(
        "--field",
        metavar="NAME",
        help="field or component of the pictures, as for pgimp plot: von-mises, stress.xx",
    )
    parser.add_argument("--open", action="store_true", help="show the page in a browser")


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        0.

    Raises
    ------
    UsageError
        If there is no run or study, or the page cannot be written; nothing is written then.
    RunError
        If a file of the run cannot be read.
    """
    import matplotlib

    matplotlib.use("Agg")
    from pgimp.utilities.report.file import write
    from pgimp.utilities.report.run import report_of_run
    from pgimp.utilities.report.study import TABLE, report_of_study

    directory = Path(args.directory)
    output = _output(args.output, directory)
    if (directory / TABLE).is_file() and not (directory / RUN).exists():
        content = report_of_study(directory, args.field)
    else:
        content = report_of_run(directory, args.field)
    write(output, content)
    print(f"wrote {output} ({len(content.encode()) / 1e6:.2g} MB)")
    if args.open:
        _show(output)
    return 0


def _output(name: str | None, directory: Path) -> Path:
    """Return the path of the page, after checking for an existing file."""
    path = directory / REPORT if name is None else Path(name)
    if name is not None and path.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{name}: the name must end in .html")
    if not directory.is_dir():
        raise UsageError(f"there is no run directory {directory}")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {path.parent}")
    return path


def _show(path: Path) -> None:
    import webbrowser

    try:
        shown = webbrowser.open(path.resolve().as_uri())
    except webbrowser.Error:
        shown = False
    if not shown:
        print("note: no browser can be started here")
