"""Particles of a run's own file, a frame or a checkpoint: they go on with their whole state.

A checkpoint has all columns of the particles. A frame has those that its fields tell; it must have
`NEEDED` and the state variables. What either lacks is refused, not guessed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.points.block import BLOCK, STRESS, Block, Saved, States, VertexGrid
from pgimp.geometry.points.plainhdf5 import Kind, check_dataset, find
from pgimp.schema.messages import shorten

Reals = NDArray[np.float64]

#: Fields of a frame from which a run can go on, besides those that all frames have.
NEEDED = ("velocity", "stress", "deformation", "mass", "initial-volume")

#: Fields that a frame may have besides, and their components; widths of all by name.
_WIDTHS = {"position": 3, "displacement": 3, "velocity": 3, "stress": 6, "deformation": 9}
_WIDTHS |= {"velocity-gradient": 9, "volume": 0, "mass": 0, "initial-volume": 0}

#: Relative difference of densities that is rounding.
_ROUNDING = 1e-9

NO_BODY = "leave out `body`, which chooses one of those in a frame or a checkpoint"
_CHECKPOINT = "take a checkpoint of its run, checkpoints/step-*.h5"


class Wanted(NamedTuple):
    """What a body of a case needs of a run's own file."""

    #: body, named: Its name in the case; the name in the file, where the case gives one.
    body: str
    named: str | None
    #: model, states: str, mapping: Law of its material, and the state variables.
    model: str
    states: States
    geometry: str  #: The case's.
    initial: bool  #: Whether it is in the initial configuration.
    #: density, inertia: Initial density without mass scaling, None where it varies; the factor of
    #: mass scaling.
    density: float | None
    inertia: float
    #: sequence of (float, float): Low end and period by direction, 0 where the domain is not
    #: periodic.
    periods: tuple[tuple[float, float], ...]
    affine: bool  #: Whether its particles carry their velocity gradient.
    #: Columns of the particles that it takes from a checkpoint which has them.
    columns: tuple[str, ...]


def is_saved(file: Any) -> bool:
    """Whether an open HDF5 file is of a run; links are not followed."""
    has = file.id.links.exists
    frame = "bodies" in file.attrs and has(b"id") and has(b"body")
    return frame or all(map(has, (b"sigma", b"V0", b"layers")))


def require_room(count: int, most: int | None) -> None:
    """Refuse a file that claims more particles than memory holds."""
    if most is not None and count > most:
        raise CaseError(
            f"it claims {count:,} particles, but the memory that is here holds {most:,} at most"
        )


def read_saved(
    h5py: Any, file: Any, D: int, most: int | None, wanted: Wanted | None
) -> Iterator[Block]:
    """Yield the particles of a body in a run's own file; see `pgimp.geometry.points.file.blocks`.

    Raises
    ------
    CaseError
        If they cannot go on in this body.
    """
    if wanted is None:
        raise CaseError("it is a run's own file, which only a body of a case can go on from")
    saved = _describe(file, D, wanted)
    if saved.checkpoint:
        data = _checkpoint_data(h5py, file, D, wanted, saved)
    else:
        data = _frame_data(h5py, file, D, wanted)
    data |= {name: find(h5py, file, name) for name in ("id", "body")}
    for name in ("id", "body"):
        check_dataset(h5py, data[name], name, Kind(((),), [0]))
    count = len(data["id"])
    require_room(count, most)
    for name, dataset in data.items():
        if len(dataset) != count:
            raise CaseError(f"{len(dataset):,} rows of {name}, but {count:,} of id")
    taken = 0
    for begin in range(0, count, BLOCK):
        rows = np.flatnonzero(data["body"][begin : begin + BLOCK] == saved.number)
        if not len(rows):
            continue
        table = {name: dataset[begin : begin + BLOCK][rows] for name, dataset in data.items()}

        def line(row: int, lines: NDArray = begin + rows) -> str:
            return f"row {lines[row]} (from 0)"

        columns, states = (_of_checkpoint if saved.checkpoint else _of_frame)(
            table, D, wanted, saved
        )
        _finish(columns, D, wanted, saved, line)
        x = columns["origin" if wanted.initial else "x"]
        L = columns["L"][:, : D * D] if "L" in columns else np.zeros((len(x), D * D))
        yield Block(
            taken, x, columns["V"], columns["v"], columns["sigma"], L, states, line, columns, saved
        )
        taken += len(rows)


def _describe(file: Any, D: int, wanted: Wanted) -> Saved:
    """What the file says of the body, if that can go on in the case."""
    about, checkpoint = file.attrs, bool(file.id.links.exists(b"layers"))
    if "models" not in about:
        raise CaseError(
            "an earlier version of pgimp wrote it, without all that a run goes on from; resume "
            "that run with --resume and a later time.end, and take its last file"
        )
    names, models = (list(map(str, about[name])) for name in ("bodies", "models"))
    chosen = wanted.named or (names[0] if len(names) == 1 else wanted.body)
    if chosen not in names:
        raise CaseError(
            f"it has no body '{chosen}', but {', '.join(shorten(name) for name in names)}; name "
            "the one to go on with, region: {points: {file: .., body: ..}}"
        )
    number = names.index(chosen)
    if int(about["dimensions"]) != D or str(about["geometry"]) != wanted.geometry:
        raise CaseError(
            f"it is of a case in {int(about['dimensions'])}D, {about['geometry']}, and this one "
            f"is in {D}D, {wanted.geometry}: its state has no meaning here"
        )
    if models[number] != wanted.model:
        raise CaseError(
            f"'{chosen}' was of the law {models[number]}, and is of {wanted.model} here: the state "
            "of one law has no meaning for another; take the same, or particles of your own"
        )
    if wanted.initial and not checkpoint:
        raise CaseError(
            f"it is a frame, and the motion of '{wanted.body}', in the initial configuration, is "
            f"that of vertices, which frames do not have: {_CHECKPOINT}"
        )
    if wanted.initial and str(about["configurations"][number]) != "initial":
        raise CaseError(
            f"'{chosen}' was in the current configuration, and its vertices have no motion to go "
            f"on with: bodies.{wanted.body}.formulation: updated-lagrangian"
        )
    states, grid = dict[str, tuple[int, int]](), None
    if checkpoint:
        for state in str(about["states"][number]).split():
            name, first, width = state.rsplit(":", 2)
            states[name] = int(first), int(width)
        grid = VertexGrid(
            tuple(map(float, about["origin"])), tuple(map(float, about["cell"])),
            tuple(map(int, about["cells"])), int(about["ghost"]), tuple(map(int, about["fields"])),
        )  # fmt: skip
    when = float(about["time"]), int(about["step"]), float(about["mass-scaling"])
    return Saved(checkpoint, number, len(names), *when, states, grid)


def _checkpoint_data(h5py: Any, file: Any, D: int, wanted: Wanted, saved: Saved) -> dict[str, Any]:
    """Datasets of a checkpoint, by column."""
    if missing := [name for name in wanted.states if name not in saved.states]:
        raise CaseError(f"its particles have no {', '.join(missing)}, which {wanted.model} needs")
    names = [*"x V V0 m v F sigma origin".split(), *wanted.columns]
    names += ["state"] if wanted.states else []
    data = {name: find(h5py, file, name) for name in names}
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(("V", "V0", "m"), ())
    shapes |= dict.fromkeys(("x", "v", "origin"), (D,)) | {"sigma": (STRESS[D],)}
    shapes["F"] = (D * D + (wanted.geometry != "plane-strain"),)
    for name in (*shapes, *(["state"] if wanted.states else [])):
        if data[name] is None and name != "origin":
            raise CaseError(f"it has no {name}: it is damaged")
    found = {name: dataset for name, dataset in data.items() if dataset is not None}
    for name, dataset in found.items():
        _check_width(h5py, dataset, name, shapes.get(name))
    for first, width in (saved.states[name] for name in wanted.states):
        if not 0 <= first <= first + width <= found["state"].shape[1]:
            raise CaseError("its states are not where it says: it is damaged")
    if wanted.initial and "origin" not in found:
        raise CaseError("it has no origin: it is damaged")
    return found


def _frame_data(h5py: Any, file: Any, D: int, wanted: Wanted) -> dict[str, Any]:
    """Datasets of a frame, by field."""
    needed = [*NEEDED, *(["velocity-gradient"] if wanted.affine else []), *wanted.states]
    names = dict.fromkeys(("position", "volume", "displacement", *needed))
    data = {name: find(h5py, file, name) for name in names}
    if missing := [name for name in needed if data[name] is None]:
        raise CaseError(
            f"it is a frame without {', '.join(missing)}: a case goes on from one with output: "
            f"{{fields: [{', '.join(needed)}]}}, or {_CHECKPOINT}, which has all. For particles "
            "without their state, copy position and volume into a file of their own"
        )
    found = {name: dataset for name, dataset in data.items() if dataset is not None}
    for name, dataset in found.items():
        width = _WIDTHS.get(name, 6 if wanted.states.get(name) else 0)
        _check_width(h5py, dataset, name, (width,) if width else ())
        if dataset.dtype.itemsize < 8:
            raise CaseError(
                f"its {name} is rounded to {8 * dataset.dtype.itemsize} bits, and stresses would "
                "change; a case goes on from frames with output.precision: float64"
            )
    return found


def _check_width(h5py: Any, data: Any, name: str, shape: tuple[int, ...] | None) -> None:
    """Check a dataset of rows of a shape; None: of any number of components."""
    if shape is None:
        shape = data.shape[1:] if getattr(data, "ndim", 0) == 2 else (1,)
    check_dataset(h5py, data, name, Kind((shape,), []))


def _of_checkpoint(
    table: dict[str, NDArray], D: int, wanted: Wanted, saved: Saved
) -> tuple[dict[str, NDArray], dict[str, Reals]]:
    """Columns of the particles, and their states by name."""
    states = {}
    for name in wanted.states:
        first, width = saved.states[name]
        states[name] = table["state"][:, first : first + width]
    return {name: values for name, values in table.items() if name != "state"}, states


def _of_frame(
    table: dict[str, NDArray], D: int, wanted: Wanted, saved: Saved
) -> tuple[dict[str, NDArray], dict[str, Reals]]:
    """Columns of the particles, and their states by name."""

    def matrix(values: Reals, stretches: bool) -> Reals:
        full = values.reshape(-1, 3, 3)
        own = full[:, :D, :D].reshape(len(full), -1)
        return np.hstack([own, full[:, 2, 2:]]) if stretches else own

    plane = wanted.geometry == "plane-strain"
    columns = {
        "x": table["position"][:, :D],
        "v": table["velocity"][:, :D],
        "sigma": table["stress"][:, : STRESS[D]],
        "F": matrix(table["deformation"], not plane),
        "V": table["volume"],
        "V0": table["initial-volume"],
        "m": table["mass"],
        "id": table["id"],
    }
    if "displacement" in table:
        columns["origin"] = columns["x"] - table["displacement"][:, :D]
    if "velocity-gradient" in table:
        ring = wanted.geometry == "axisymmetric"
        columns["L"] = matrix(table["velocity-gradient"], ring)
    width = STRESS[D]
    states = {
        name: table[name][:, :width] if tensor else table[name][:, None]
        for name, tensor in wanted.states.items()
    }
    return columns, states


def _finish(columns: dict[str, NDArray], D: int, wanted: Wanted, saved: Saved, line: Any) -> None:
    """Bring particles into the domain and to the case's inertia; refuse those that are none."""
    for name, values in columns.items():
        sound = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        if name in ("m", "V", "V0"):
            sound &= values > 0.0
        elif name == "F":
            J = np.linalg.det(values[:, : D * D].reshape(-1, D, D)) * values[:, D * D :].prod(1)
            sound &= J > 0.0
        if not sound.all():
            row = int(np.argmin(sound))
            raise CaseError(f"{line(row)}: its {name} is that of no particle: {values[row]}")
    columns["x"] = columns["x"].copy()
    for d, (low, period) in enumerate(wanted.periods if not wanted.initial else ()):
        if period > 0.0:
            shift = np.floor((columns["x"][:, d] - low) / period) * period
            columns["x"][:, d] -= shift
            if "origin" in columns:
                columns["origin"] = columns["origin"].copy()
                columns["origin"][:, d] -= shift
    density = columns["m"] / columns["V0"] / saved.inertia
    if wanted.density is not None:
        wrong = np.abs(density / wanted.density - 1.0) > _ROUNDING
        if wrong.any():
            row = int(np.argmax(wrong))
            raise CaseError(
                f"{line(row)}: mass over initial volume is {density[row]:.9g}, and the density "
                f"of '{wanted.body}' {wanted.density:.9g}: mass goes on as it is; give the "
                "material that density"
            )
    if wanted.inertia != saved.inertia:
        columns["m"] = columns["m"] * (wanted.inertia / saved.inertia)
