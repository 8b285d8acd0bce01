"""Rigid bodies that hold particles out: where they are at a step's end, and what they get."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.kernels.toolhold import Keepers
from pgimp.scene.scene import Scene
from pgimp.solver.clock import Step
from pgimp.solver.freebodies import FreeBodies


class Keeping:
    """The rigid bodies of a scene that hold particles out, on one rank.

    Parameters
    ----------
    scene : Scene
        The scene.
    free : FreeBodies or None
        Those that move freely.
    layers : int
        Layers of the rank.
    """

    def __init__(self, scene: Scene, free: FreeBodies | None, layers: int) -> None:
        self.scene, self.free = scene, free
        self._impulses = np.zeros((layers, len(scene.tools.free), 6))
        self._kept: Any = ()

    def at(self, t: Step) -> Any:
        """Return what holds particles out at the end of a step; () without rigid bodies."""
        scene = self.scene
        if not scene.tools or not scene.pairs:
            return ()
        if not self._kept or scene.tools.move:
            tools = scene.tools.after(t.end, self.free.states if self.free else None)
            self._kept = Keepers(tools, scene.pairs, self._impulses)
        return self._kept
