"""The inside of a closed surface, or of cells, from a mesh file.

In 3D: a surface of triangles or polygons (STL, OBJ, PLY), or volume cells (Gmsh, VTU, ...). In 2D:
an outline of lines, or triangles and quadrilaterals. Points are scaled first, then turned about
the origin, then moved. Inner surfaces are holes. Sums over the particles equal the mesh's to
rounding, for any lattice. A mesh of a curved body converges to it by second order in the size of
its triangles. In unions and differences meshes are measured like other regions, by lines: there
facets within a box leave an error of second order.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from pgimp.errors import CaseError
from pgimp.geometry.regions.base import Points
from pgimp.geometry.regions.enclosed import Enclosed
from pgimp.schema.base import Count, Label, Number, Positive, Vector
from pgimp.schema.dispatch import Either
from pgimp.schema.paths import FileName

if TYPE_CHECKING:
    from pgimp.geometry.mesh.tree import Surface


class Mesh(Enclosed):
    """Inside of a mesh: a closed surface (STL, OBJ, PLY) or cells (Gmsh, VTU); holes are empty."""

    WHAT: ClassVar[str] = "the mesh"

    file: FileName = Field(
        description="file of the mesh, from the folder of the case; meshio tells its format by "
        "the ending of its name"
    )
    group: Annotated[
        str | int | None,
        Either("a name or a number of a group", {str: Label, float: Count, None: None}),
    ] = Field(
        default=None,
        description="group of the file's cells that is taken: a physical group of Gmsh, a set, a "
        "group of OBJ, a solid of STL; null: all. `pgimp check` lists them",
    )
    scale: Positive = Field(
        default=1.0, description="factor of all lengths, such as 0.001 from mm to m [1]"
    )
    rotate: Annotated[
        float | tuple[float, ...],
        Either("degrees, in 3D about x, y and z", {float: Number, tuple: Vector}),
    ] = Field(
        default=0.0,
        description="turn about the origin, after scaling, in degrees: in 2D anticlockwise; in 3D "
        "a list, about x, then y, then z",
    )
    translate: Vector | None = Field(
        default=None, description="displacement, after turning; null: none [length]"
    )

    @cached_property
    def surface(self) -> Surface:
        """The surface after scaling, turning and moving; the file is read at first use.

        Raises
        ------
        CaseError
            If it cannot be read, or encloses nothing.
        """
        from pgimp.geometry.mesh.cells import facets_of
        from pgimp.geometry.mesh.closed import enclose
        from pgimp.geometry.mesh.file import read_mesh

        mesh = read_mesh(self.file)
        try:
            group = None if self.group is None else str(self.group)
            found = facets_of(mesh, self.dimensions, group)
            with np.errstate(over="ignore", invalid="ignore"):
                points = self._moved(found.points)
                extent = np.ptp(points[found.facets].reshape(-1, self.dimensions), axis=0)
            if not (np.isfinite(points[found.facets]).all() and (extent > 1e-100).all()):
                size = " x ".join(f"{x:.3g}" for x in extent)
                raise CaseError(f"is {size} large: flat, or too large or small for any case")
            if (extent > 1e100).any():
                raise CaseError(f"is {extent.max():.3g} large: too large for any case")
            return enclose(found._replace(points=points))
        except CaseError as error:
            raise CaseError(f"the mesh {self.file} {error}") from None

    def _moved(self, points: Points) -> Points:
        """Points after scaling, turning and moving."""
        points = points * self.scale
        D = points.shape[1]
        if isinstance(self.rotate, tuple):
            for axis, degrees in enumerate(self.rotate):
                points = _turned(points, (axis + 1) % 3, (axis + 2) % 3, degrees)
        elif self.rotate:
            points = _turned(points, 0, 1, self.rotate)
        return points if self.translate is None else points + np.array(self.translate)[:D]


def _turned(points: Points, i: int, j: int, degrees: float) -> Points:
    """Turn points from axis i towards axis j; exactly by whole quarters."""
    quarters, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters % 4)]
    else:
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    points = points.copy()
    x, y = points[:, i].copy(), points[:, j].copy()
    points[:, i], points[:, j] = c * x - s * y, s * x + c * y
    return points
