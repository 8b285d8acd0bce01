"""Groups of cells in what meshio has read: physical groups, sets, references.

meshio refuses meshes of Gmsh of which some cells are in no physical group, and keeps of several
groups of an entity only the first. In the process that reads a mesh, its readers are made to hand
over all of them.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Data of cells that are numbers of groups; 0 is none.
_NUMBERED = ("gmsh:physical", "medit:ref")

#: What meshio calls a set, and is none.
_NO_SETS = ("gmsh:bounding_entities",)


def take_all_groups() -> list[list[int]]:
    """Let meshio read all meshes of Gmsh.

    Returns
    -------
    list of list of int
        After reading, the physical groups of each block of cells, for formats 4 and later.
    """
    from meshio import Mesh
    from meshio._mesh import topological_dimension
    from meshio.gmsh import _gmsh22, _gmsh40, _gmsh41

    found: list[list[int]] = []

    def lenient(points: Any, cells: Any, cell_data: Any = None, **more: Any) -> Any:
        sizes = [len(cell[1] if isinstance(cell, tuple) else cell.data) for cell in cells]
        fitting = {
            key: data for key, data in (cell_data or {}).items() if [*map(len, data)] == sizes
        }
        return Mesh(points, cells, cell_data=fitting, **more)

    def all_of(read: Any) -> Any:
        def elements(f: Any, points: Any, physical: Any, *more: Any) -> Any:
            if physical is not None:
                physical = tuple(defaultdict(list, each) for each in physical)
            cells, data, *sets = read(f, points, physical, *more)
            for block, entity in zip(cells, data.get("gmsh:geometrical", ()), strict=True):
                dimension = topological_dimension[block.type]
                tags = physical[dimension][int(entity[0])] if physical and len(entity) else ()
                found.append([abs(int(tag)) for tag in tags])
            return cells, data, *sets

        return elements

    _gmsh22.Mesh = _gmsh40.Mesh = _gmsh41.Mesh = lenient
    for module in (_gmsh40, _gmsh41):
        module._read_elements = all_of(module._read_elements)
    return found


def groups_of(mesh: Any, tags: list[list[int]]) -> dict[str, NDArray[np.int64]]:
    """Return the numbers of cells, over all blocks, by the names or numbers of their groups.

    Parameters
    ----------
    mesh
        meshio.Mesh.
    tags : list of list of int
        Physical groups of each block, if they are known; see `take_all_groups`.
    """
    names = {
        (int(value[1]), int(value[0])): name
        for name, value in mesh.field_data.items()
        if np.size(value) == 2
    }
    starts = np.cumsum([0, *(len(block.data) for block in mesh.cells)])
    found: dict[str, list[NDArray[np.int64]]] = {}

    def add(name: str, cells: NDArray[np.int64]) -> None:
        if len(cells):
            found.setdefault(name, []).append(cells)

    if tags:
        for k, (block, own) in enumerate(zip(mesh.cells, tags, strict=True)):
            for tag in own:
                add(names.get((block.dim, tag), str(tag)), np.arange(starts[k], starts[k + 1]))
    else:
        for key in _NUMBERED:
            for k, values in enumerate(mesh.cell_data.get(key, ())):
                for tag in np.unique(values[values != 0]).tolist():
                    name = names.get((mesh.cells[k].dim, tag), str(tag))
                    add(name, starts[k] + np.flatnonzero(values == tag))
        for name, blocks in mesh.cell_sets.items():
            for k, cells in enumerate(blocks if name not in _NO_SETS else ()):
                if cells is not None:
                    add(str(name), starts[k] + np.asarray(cells, np.int64).reshape(-1))
    return {name: np.unique(np.concatenate(cells)) for name, cells in found.items()}
