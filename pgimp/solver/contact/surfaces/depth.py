"""How deep surfaces that meet are in each other: said when it is too much."""

from __future__ import annotations

import numpy as np

from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene

#: Cells by which surfaces may overlap without a word.
MOST = 0.05


class Depth:
    """The deepest facet since the last line of the history.

    Parameters
    ----------
    scene : Scene
        The scene.
    names : list of str
        Names of bodies and rigid bodies; walls come after them.
    """

    def __init__(self, scene: Scene, names: list[str]) -> None:
        self._names, self._D, self._cell = names, scene.dimension, min(scene.domain.frame.cell)
        self._told: set[tuple[int, int]] = set()
        self._found: list[tuple] = []  # gap, bodies, time and place

    def note(self, every: np.ndarray, surface: Surface, time: float) -> None:
        """Note the deepest facet of a step, given those near others with their gaps."""
        gap = every["gap"]
        least = self._found[0][0] if self._found else -MOST * self._cell
        if not gap.min(initial=0.0) < least:
            return
        at = every[int(np.where(every["side"] >= 0, gap, np.inf).argmin())]
        if at["gap"] < least and at["side"] >= 0:
            a, facet = int(at["body"]), int(at["facet"])
            place = tuple(surface.now[facet, : self._D].tolist())
            self._found = [(float(at["gap"]), int(surface.body[facet]), a, time, place)]

    def look(self, comm: Communicator) -> list[str]:
        """Return a warning for two bodies, once, if they overlapped too much; collective."""
        every = sorted(each for found in comm.allgather(self._found) for each in found)
        self._found = []
        for gap, a, b, time, place in every[:1]:
            two = (min(a, b), max(a, b))
            if two in self._told:
                continue
            self._told.add(two)
            names = [f"'{self._names[n]}'" if n < len(self._names) else "a wall" for n in (a, b)]
            at = ", ".join(f"{x:.4g}" for x in place)
            return [
                f"surfaces overlap: {names[0]} was {-gap / self._cell:.2g} cells deep in "
                f"{names[1]} at time {time:.6g}, near ({at}). More than {MOST:g} is too much for "
                "stress there to be right: take smaller cells, shorter steps, or edges less sharp"
            ]
        return []
