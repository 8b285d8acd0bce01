"""Files of a failed run: particles at fault, their neighbours, and a report."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.case.stepping.courant import largest_courant
from pgimp.errors import RunError, explain
from pgimp.io.frames.particlefile import ParticleFile
from pgimp.io.frames.xdmf import Collection
from pgimp.io.rundir.ownfiles import FAILURE as FOLDER
from pgimp.kernels.data.frame import volume_ratio
from pgimp.kernels.order.order import vertices_of
from pgimp.kernels.step.checks import OUTSIDE
from pgimp.mpi.collective import on_root
from pgimp.physics.derived import DERIVED, FITTED
from pgimp.physics.fields import BY_RANKS, FIELDS, Source
from pgimp.solver.lagrangian.pieces import source_at
from pgimp.solver.particle_groups import fastest
from pgimp.solver.start.particle_errors import Failure, explanation
from pgimp.solver.time.stability import stable_courant
from pgimp.storage.atomic import write as write_file

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation

Array = np.ndarray

#: Distances in cells, per direction, within which particles are neighbours of one of the first
#: particles at fault. Smaller distances apply if there would be too many.
RADII = (3.0, 2.5, 2.0, 1.5, 1.0, 0.5)
_MOST_CENTRES = 32
_MOST_FAULTS = 1000
_MOST_NEIGHBOURS = 4000
_MOST_STATES = 20
_LINES = 20
_TAIL = 1 << 18


def write(directory: Path, sim: Simulation, text: str, history: Path) -> Path | None:
    """Write the folder ``failure`` of a run that a particle has stopped; collective.

    It has ``particles.xdmf`` with ``particles.h5``, for ParaView, and ``report.txt``; an older one
    is replaced. Particles farther than a cell from the domain cannot be drawn; they are shown at
    their previous position.

    Parameters
    ----------
    sim : Simulation
        After `advance` has raised the error.
    text : str
        The message to the user.
    history : Path
        history.csv.

    Returns
    -------
    Path or None
        The folder; None if no particle has stopped the run, or if it cannot be written.
    """
    if sim.failure is None:
        return None
    folder = directory / FOLDER
    try:
        with np.errstate(all="ignore"):
            _write(folder, sim, sim.failure, text, history)
    except Exception:  # the error that stopped the run has priority
        if sim.comm.rank == 0:
            with suppress(OSError):
                _clear(folder)
                folder.rmdir()
        return None
    return folder


def _write(folder: Path, sim: Simulation, failure: Failure, text: str, history: Path) -> None:
    comm, scene, what = sim.comm, sim.scene, "write what went wrong"
    rows, kinds = sim.rank.errors[: sim.rank.failed].T
    found = _Found(rows, kinds, _places(sim, rows)[0])
    chosen, radius = _around(sim, found)
    # The same on any number of ranks.
    fields = [name for name in scene.fields if name not in {*BY_RANKS, *DERIVED, *FITTED}]
    if not scene.settings.origins:
        fields.remove("displacement")
    if not scene.domain.ends:
        fields.remove("unwrapped")
    file = ParticleFile(sim.case, scene, fields)
    shown = file.rows(comm, sim.particles.id[chosen], chosen, sim.count, complete=False)
    courant = _courant(sim, found)
    states = [_state(sim, found, i) for i in range(min(len(found.rows), _MOST_STATES))]
    gathered = comm.gather((states, set(found.kinds.tolist())))

    def begin() -> None:
        try:
            folder.mkdir(exist_ok=True)
            _clear(folder)
        except OSError as error:
            raise RunError(f"cannot {what}: {explain(error)}") from error

    on_root(comm, begin)
    path = folder / "particles.h5"

    def end() -> None:
        collection = Collection(folder / "particles.xdmf")
        collection.add(file.mesh(path, (failure.time, failure.step), shown.count))
        collection.finish()
        states = [state for part, _ in gathered or () for state in part][:_MOST_STATES]
        kinds = set().union(*(part for _, part in gathered or ()))
        number = f"first {len(states)} of {failure.number}" if failure.number > len(states) else ""
        parts = [
            text,
            *map(fill, _advice(sim, courant, kinds)),
            "\n".join([f"The {number or len(states)} at fault:", *states]),
            fill(
                f"particles.xdmf has {shown.count} particles as they are after the step: those at "
                f"fault, and all within {radius:g} cells of one of the first {_MOST_CENTRES} of "
                "them. Open it with ParaView and colour it by fault; 0 are neighbours. A particle "
                "outside the domain is drawn where it was before."
            ),
            "\n".join([f"The last lines of {history.name}:", *_last_lines(history)]),
        ]
        write_file(folder / "report.txt", "\n\n".join(parts) + "\n")

    state, instead = (failure.time, failure.step), _drawable(sim, found, shown.storage)
    file.write(path, partial(source_at, sim.rank), shown, state, what, instead).end(end)


def _clear(folder: Path) -> None:
    for name in ("report.txt", "particles.xdmf", "particles.h5"):
        (folder / name).unlink(missing_ok=True)


class _Found(NamedTuple):
    """A rank's listed particles at fault."""

    #: rows, kinds: (n,) int64: Their rows and errors, in canonical order.
    rows: Array
    kinds: Array
    #: (n, D): Their positions, present or else previous, in cells from the domain's origin.
    places: Array


def _places(sim: Simulation, rows: Array) -> tuple[Array, Array]:
    """Drawable positions in cells from the domain's origin, (n, D); mask of the actual ones.

    The others are the middle of the particle's layer, and in the other directions the middle of
    its cell at the last re-sort. In the initial configuration they are initial positions.
    """
    p, frame = sim.particles, sim.scene.domain.frame
    xi = (p.x[rows] - frame.origin) * frame.inverse
    begun = sim.scene.settings.lagrangian[p.body[rows]]
    drawable = ((xi >= -1.0) & (xi <= np.array(frame.cells) + 1.0)).all(axis=1)
    drawable |= begun & np.isfinite(xi).all(axis=1)
    first = vertices_of(p.cell[rows], frame.vertices)
    first[:, 0] = p.layer[rows]
    before = first - frame.ghost + 0.5 + np.array(sim.scene.settings.shape.half)
    if begun.any():
        before[begun] = (p.origin[rows[begun]] - frame.origin) * frame.inverse
    return np.where(drawable[:, None], xi, before), drawable


def _around(sim: Simulation, found: _Found) -> tuple[Array, float]:
    """Rows of the shown particles, and the radius of the neighbourhoods in cells; collective."""
    comm, frame = sim.comm, sim.scene.domain.frame
    every = comm.allgather(found.places)
    before = sum(len(places) for places in every[: comm.rank])
    centres = np.concatenate(every)[:_MOST_CENTRES]
    rows = sim.live()
    distance = np.full(len(rows), np.inf)
    xi = (sim.particles.x[rows] - frame.origin) * frame.inverse
    for centre in centres:
        distance = np.fmin(distance, np.abs(xi - centre).max(axis=1))
    shown = found.rows[: max(0, _MOST_FAULTS - before)]
    distance[np.isin(rows, shown)] = np.inf
    counts = np.sum(comm.allgather([int((distance <= r).sum()) for r in RADII]), axis=0)
    radius = next((r for r, n in zip(RADII, counts, strict=True) if n <= _MOST_NEIGHBOURS), 0.0)
    return np.concatenate([shown, rows[distance <= radius]]), radius


def _drawable(sim: Simulation, found: _Found, rows: Array) -> dict[str, Array]:
    """Additional fields of the shown rows, beside the fields of all particles."""
    p, scene = sim.particles, sim.scene
    places, drawable = _places(sim, rows)
    position = np.zeros((len(rows), 3))
    position[:, : scene.dimension] = places * scene.domain.frame.cell + scene.domain.frame.origin
    position[drawable, : scene.dimension] = p.x[rows[drawable]]
    radius = FIELDS["radius"].values
    of = (rows, scene.dimension, scene.materials.body_material)
    now = radius(Source(p, *of, plate=scene.carried.plate))
    then = radius(Source(p._replace(V=p.V0), *of, plate=scene.carried.plate))
    kinds = dict(zip(found.rows.tolist(), found.kinds.tolist(), strict=True))
    return {
        "position": position,
        "radius": np.where(np.isfinite(now) & (now > 0.0), now, then),
        "fault": np.array([kinds.get(row, 0) for row in rows.tolist()], np.int32),
    }


def _courant(sim: Simulation, found: _Found) -> float:
    """Courant number of the step, from the particles without fault; collective."""
    scene, p, order = sim.scene, sim.particles, sim.population.order
    sound = np.isfinite(p.v[order]).all(axis=1) & np.isfinite(p.F[order]).all(axis=1)
    order = order[sound & ~np.isin(order, found.rows)]
    rate = fastest(scene, p, order, scene.settings.controlled or True)
    assert sim.failure is not None
    return max(sim.comm.allgather(rate)) * sim.failure.dt


def _state(sim: Simulation, found: _Found, i: int) -> str:
    """State of a particle at fault, as lines of text."""
    p, row = sim.particles, int(found.rows[i])
    values = {
        "x": p.x[row],
        "v": p.v[row],
        "det F": [float(volume_ratio(p.F[row], sim.scene.dimension))],
        f"stress {' '.join('xx yy zz xy yz xz'.split()[: len(p.sigma[row])])}": p.sigma[row],
        "volume, at first": [p.V[row], p.V0[row]],
    }
    what = explanation(sim.rank, row, int(found.kinds[i]))
    lines = [f"  particle {p.id[row]} of body '{sim.scene.body_names[p.body[row]]}' {what}"]
    lines += [f"    {name}: {' '.join(f'{v:.9g}' for v in of)}" for name, of in values.items()]
    return "\n".join(lines)


def _advice(sim: Simulation, courant: float, kinds: set[int]) -> list[str]:
    """Interpretation of Courant number and errors, and further diagnostics."""
    stable, failure = stable_courant(sim.case), sim.failure
    if sim.case.watched:
        stable = largest_courant(sim.case)
    assert failure is not None
    lines = [
        f"The step had a Courant number of {courant:.3g} by the particles that are not at fault; "
        f"{sim.case.method.shape} is stable up to {stable:g}."
    ]
    if courant > stable:
        lines.append(
            f"That is too much: use steps of at most {stable / courant * failure.dt:.3g}, or "
            f"time.step: {{courant: {min(stable, 0.3):g}}}, which follows the waves' speed."
        )
    elif kinds != {OUTSIDE}:
        lines.append(
            "So the step was short enough for the waves. Look for loads that set in at once, "
            "parts that meet fast, a material too soft for its load, cells too coarse for the bend."
        )
    lines.append(
        "To see it coming, go on from the last checkpoint, if there is one, with more frames: "
        "--resume --set 'output.every={steps: 1}'"
    )
    return lines


def _last_lines(path: Path) -> list[str]:
    """First line of a file, with the names of the columns, and its last lines."""
    try:
        with open(path, "rb") as stream:
            head = stream.readline()
            stream.seek(max(len(head), path.stat().st_size - _TAIL))
            lines = stream.read().decode(errors="replace").splitlines()
    except OSError as error:
        return [f"(cannot be read: {explain(error)})"]
    return [head.decode(errors="replace").rstrip("\n"), *lines[-_LINES:]]
