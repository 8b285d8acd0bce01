"""``pgimp element CASE.yaml MATERIAL``: response of a material along a path, without a grid."""

from __future__ import annotations

import argparse
import io
import math
import re
from pathlib import Path

from pgimp.case.load import load
from pgimp.errors import UsageError, explain
from pgimp.schema.messages import unknown
from pgimp.storage import atomic
from pgimp.utilities.element.paths import PATHS, Array, path_of

_MOST_STEPS = 1_000_000
_BEGINNINGS = {"png": rb"\x89PNG\r\n", "csv": rb"value,time,det-F"}
_DEFAULT_STEPS = 100
_SHOWN_ROWS = 10
_OTHERS = ("stress-", "exact-")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument("case", metavar="CASE.yaml", help="the case file")
    parser.add_argument("material", metavar="MATERIAL", help="the name of one of its materials")
    parser.add_argument("--path", required=True, metavar="PATH", help=f"one of {', '.join(PATHS)}")
    parser.add_argument(
        "--to",
        required=True,
        metavar="VALUE,...",
        help="where the path leads, one value after the other: logarithmic strain (below 0 in "
        "compression; --to=-0.1 with a minus), of simple-shear the shear, of isotropic the "
        "logarithm of the volume ratio",
    )
    parser.add_argument(
        "--steps",
        type=int,
        default=_DEFAULT_STEPS,
        metavar="N",
        help=f"to each value (default: {_DEFAULT_STEPS})",
    )
    parser.add_argument(
        "--confine",
        type=float,
        default=0.0,
        metavar="P",
        help="pressure from all sides before (default: that at which the material starts, 0 for "
        "most)",
    )
    parser.add_argument(
        "--rate",
        type=float,
        default=1.0,
        metavar="R",
        help="of the value, 1/time, for materials whose stress depends on it (default: 1)",
    )
    parser.add_argument(
        "--at",
        metavar="X,Y,..",
        help="a place at the start, where the material varies in space; what is a column of "
        "particles takes a number, --set materials.NAME.KEY=NUMBER",
    )
    parser.add_argument(
        "--set",
        metavar="KEY.PATH=VALUE",
        action="append",
        default=[],
        help="change a value of the case; repeatable",
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="a .csv with all digits, or a .png")


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
        If the material cannot follow the path.
    """
    from pgimp.utilities.element.table import curve, draw, errors, text

    values = _values(args.to)
    path = path_of(args.path)
    if not 1 <= args.steps * len(values) <= _MOST_STEPS:
        text_of = f"expected at least 1, and at most {_MOST_STEPS:,} in all"
        raise UsageError(f"--steps {args.steps}: {text_of}")
    if not (math.isfinite(args.confine) and args.confine >= 0.0):
        raise UsageError(f"--confine {args.confine:g}: expected a pressure of at least 0")
    if not (math.isfinite(args.rate) and args.rate > 0.0):
        raise UsageError(f"--rate {args.rate:g}: expected a rate above 0")
    output = _output(args.output) if args.output else None
    case = load(args.case, args.set)
    if args.material not in case.materials:
        raise UsageError(unknown("material", args.material, case.materials))
    material = case.materials[args.material]
    if material.DIMENSIONS == (1,) and args.path not in ("uniaxial-strain", "oedometer"):
        raise UsageError(f"{args.material} exists in 1D only: --path uniaxial-strain is left")
    if args.at:
        material = material.at(_place(args.at, case.dimensions))
    table = curve(material, args.path, values, args.steps, args.confine, args.rate)
    _print(table, path.component)
    for column, error in errors(table).items():
        print(f"{column}: differs from the exact curve by at most {error:.2g} of the maximum")
    if output is None:
        return 0
    if output.suffix.lower() == ".csv":
        _write(output, text(table).encode())
    else:
        import matplotlib

        from pgimp.utilities.plot.style import STYLE

        with matplotlib.rc_context(STYLE):  # type: ignore[arg-type]
            stream = io.BytesIO()
            figure = draw(table, args.path, f"{args.material}, {args.path}")
            figure.savefig(stream, format="png")
        _write(output, stream.getvalue())
    print(f"wrote {output}")
    return 0


def _values(words: str) -> list[float]:
    try:
        values = [float(word) for word in words.split(",")]
    except ValueError:
        raise UsageError(f"--to {words}: numbers, with commas between them") from None
    if not all(math.isfinite(value) and abs(value) <= 100.0 for value in values):
        raise UsageError(f"--to {words}: expected strains, at most 100 in size")
    return values


def _place(words: str, dimensions: int) -> list[float]:
    try:
        place = [float(word) for word in words.split(",")]
    except ValueError:
        place = []
    if len(place) != dimensions or not all(map(math.isfinite, place)):
        text = "one number" if dimensions == 1 else f"{dimensions} numbers, with commas"
        raise UsageError(f"--at {words}: expected {text}, a place of the case")
    return place


def _output(name: str) -> Path:
    """Return the output path, after checking for an existing file."""
    path = Path(name)
    kind = path.suffix[1:].lower()
    if kind not in _BEGINNINGS:
        raise UsageError(f"{name}: the name must end in .csv or .png")
    if not path.parent.is_dir():
        raise UsageError(f"{name}: there is no folder {path.parent}")
    try:
        if path.exists() and not path.is_file():
            raise UsageError(f"{name} exists and is no file")
        beginning = path.read_bytes()[:32] if path.exists() else b""
    except OSError as error:
        raise UsageError(f"cannot read {name}: {explain(error)}") from error
    if beginning and not re.match(_BEGINNINGS[kind], beginning):
        raise UsageError(f"{name} exists and is none of pgimp element's; it is left as it is")
    return path


def _write(path: Path, content: bytes) -> None:
    try:
        atomic.write(path, content)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {explain(error)}") from error


def _print(table: dict[str, Array], component: str) -> None:
    """Print some rows: the path's main stress, and the material's state."""
    known = ("value", "time", "det-F", "pressure", "q", component)
    states = [name for name in table if name not in known and not name.startswith(_OTHERS)]
    columns = ["value", component, *states]
    columns += [f"exact-{name}" for name in columns if f"exact-{name}" in table]
    last = len(table["value"]) - 1
    print("  ".join(f"{name:>14}" for name in columns))
    for k in sorted({*range(0, last, max(1, last // _SHOWN_ROWS)), last}):
        texts = {name: f"{table[name][k]:.6g}".replace("nan", "-") for name in columns}
        print("  ".join(f"{texts[name]:>{max(14, len(name))}}" for name in columns))
