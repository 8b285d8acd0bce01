"""The current particles of a rank, by the names of the fields of a frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pgimp.io.results.tables import Fields
from pgimp.kernels.sums.energies import strain_energies
from pgimp.physics import fields

if TYPE_CHECKING:
    import pandas

    from pgimp.solver.state.progress import SimulationProgress


class Particles(Mapping[str, np.ndarray]):
    """The current particles of this rank, by the names of the fields of a frame.

    Each access copies the current values, in ascending id; see cases/reference.md for the
    fields. ``len(particles["id"])`` is the number of particles.
    """

    def __init__(self, core: SimulationProgress) -> None:
        self._core = core

    def _names(self) -> list[str]:
        followed = self._core.particles.origin.shape[1] > 0
        turns = self._core.particles.winding.shape[1] > 0
        return [
            name
            for name in self._core.scene.fields
            if name not in fields.FAILURE
            and (followed or name != "displacement")
            and (turns or name != "unwrapped")
        ]

    def __iter__(self) -> Iterator[str]:
        """Go through the names of the fields."""
        return iter(self._names())

    def __len__(self) -> int:
        """Return the number of fields."""
        return len(self._names())

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a field.

        Parameters
        ----------
        name : str
            As in frames; ``displacement`` only if the case has it in ``output.fields``.

        Returns
        -------
        ndarray, shape (n,) or (n, k)
            A copy.

        Raises
        ------
        KeyError
            If there is no such field.
        """
        if name not in self._names():
            raise KeyError(f"there is no field {name}; there are {', '.join(self._names())}")
        core = self._core
        rows = core.live()
        rows = rows[np.argsort(core.particles.id[rows])]
        scene = core.scene
        source = fields.Source(
            core.particles,
            rows,
            scene.dimension,
            scene.materials.body_material,
            periods=scene.domain.ends,
            plate=scene.carried.plate,
            energy=partial(strain_energies, scene.setting),
            fills=scene.materials.fills,
        )
        return scene.fields[name].values(source)

    def to_pandas(self, *names: str) -> pandas.DataFrame:
        """Return fields, all by default, as a pandas.DataFrame; see `Frame.to_pandas`."""
        chosen = [name for name in names or self if name != "id"]
        found = Fields({"id": self["id"]} | {name: self[name] for name in chosen})
        return found.to_pandas().set_index("id")
