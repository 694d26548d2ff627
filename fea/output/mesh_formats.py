"""Write a meshed rod and its results in the formats of other programs, through meshio."""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.output.target import StorageError
from mesh.tetmesh import TetMesh, boundary_facets

Array = npt.NDArray[Any]
# Rows of the six components XX YY ZZ XY YZ XZ in a full tensor, row by row: gmsh takes nine.
_FULL = [0, 3, 5, 3, 1, 4, 5, 4, 2]
_ORDER_OF_MIDDLES = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]


@dataclass(frozen=True)
class Format:
    """What a format carries."""

    module: str  #: meshio's module that writes it
    #: points, cells: whether it takes arrays of the nodes, and of the elements
    points: bool = False
    cells: bool = False
    surfaces: bool = False  #: whether it takes the named surfaces, as triangles
    skin: bool = False  #: whether it is of triangles only
    options: Mapping[str, Any] | None = None  #: for meshio

    @property
    def without(self) -> str:
        """What it cannot carry, in words; empty for nothing."""
        if self.skin:
            return "the solid elements and the results: the file holds the boundary as flat triangles"
        if not self.points:
            return "the results and the names of the bores: the file holds the mesh only"
        left = [] if self.cells else ["the arrays of the elements"]
        return " and ".join([*left, *([] if self.surfaces else ["the names of the bores"])])


FORMATS = {
    ".vtu": Format("vtu", points=True, cells=True),
    ".vtk": Format("vtk", points=True, cells=True),
    ".xdmf": Format("xdmf", points=True, cells=True),
    ".msh": Format("gmsh", points=True, surfaces=True, options={"fmt_version": "2.2", "binary": True}),
    ".med": Format("med", points=True, surfaces=True),
    ".bdf": Format("nastran"),
    ".nas": Format("nastran"),
    ".stl": Format("stl", skin=True),
    ".ply": Format("ply", skin=True),
}


def write_mesh(
    path: Path, mesh: TetMesh, point_data: Mapping[str, Array], cell_data: Mapping[str, Array]
) -> tuple[Path, ...]:
    """Write a mesh with as much of its results as the format of the suffix carries (see `Format.without`).

    Returned are the files written: XDMF keeps its numbers in a second one, ``.h5``. Raises `StorageError`:
    the disk or a permission refused, or an installed library lacks.
    """
    form = FORMATS[path.suffix.lower()]
    try:
        write = import_module(f"meshio.{form.module}").write
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".export-") as scratch:
            place = Path(scratch) / path.name
            write(str(place), _content(form, mesh, point_data, cell_data), **dict(form.options or {}))
            if form.module == "nastran":
                # Name ten-node tetrahedra as Nastran does; meshio writes a name of its own.
                place.write_bytes(place.read_bytes().replace(b"\nCTETRA_ ", b"\nCTETRA  "))
            made = sorted(Path(scratch).iterdir())
            for file in made:
                file.replace(path.parent / file.name)
    except OSError as error:
        reason = error.strerror or str(error)
        raise StorageError(f"{path} could not be written: {reason}. Choose another path.") from error
    except ImportError as error:
        remedy = f"Type: pip install {error.name}" if error.name else "Install it"
        raise StorageError(f"{path} could not be written: {error}. {remedy}") from error
    return tuple(path.parent / file.name for file in made)


def _content(
    form: Format, mesh: TetMesh, point_data: Mapping[str, Array], cell_data: Mapping[str, Array]
) -> Any:
    from meshio import Mesh  # noqa: PLC0415 - only an export needs it

    if form.skin:
        facets = boundary_facets(mesh.tets)
        if mesh.order == 2:
            facets = facets[:, _ORDER_OF_MIDDLES].reshape(-1, 3)
        used, local = np.unique(facets, return_inverse=True)
        return Mesh(mesh.points[used], [("triangle", local.reshape(-1, 3).astype(np.int32))])
    kind = "tetra" if mesh.order == 1 else "tetra10"
    if form.module == "nastran":
        part = np.ones(len(mesh.tets), dtype=int) if mesh.part is None else mesh.part + 1
        property_numbers = {"nastran:ref": [part]}
        # Coordinates as Nastran's fields of sixteen letters hold them, with a sign and one digit of exponent.
        short = [float(f"{x:.10e}") if abs(x) > 1e-9 else 0.0 for x in mesh.points.ravel().tolist()]
        return Mesh(np.reshape(short, mesh.points.shape), [(kind, mesh.tets)], cell_data=property_numbers)
    points = dict(point_data)
    if form.module == "gmsh":
        tensors = [name for name, values in points.items() if values.shape[1:] == (6,)]
        points |= {name: np.asarray(points[name][:, _FULL]) for name in tensors}
    if not form.surfaces or not mesh.facets:
        # VTK has no name for integers that meshio writes.
        plain = {name: values.astype(float) for name, values in cell_data.items()}
        cell_data = plain if form.module == "vtk" else cell_data
        of_cells = {name: [values] for name, values in cell_data.items() if form.cells}
        of_points = points if form.points else {}
        return Mesh(mesh.points, [(kind, mesh.tets)], point_data=of_points, cell_data=of_cells)
    # One number for the solid, and one for each named surface.

    names = list(mesh.facets)
    triangles = np.concatenate([mesh.facets[name] for name in names])
    marks = np.repeat(np.arange(1, len(names) + 1), [len(mesh.facets[name]) for name in names])
    cells = [(f"triangle{'' if mesh.order == 1 else '6'}", triangles), (kind, mesh.tets)]
    solid = np.full(len(mesh.tets), len(names) + 1)
    if form.module == "gmsh":
        marked = {f"gmsh:{what}": [marks, solid] for what in ("physical", "geometrical")}
        named = {name.value: np.array([number, 2]) for number, name in enumerate(names, start=1)}
        named |= {"rod": np.array([len(names) + 1, 3])}
        return Mesh(mesh.points, cells, point_data=points, cell_data=marked, field_data=named)
    made = Mesh(mesh.points, cells, point_data=points, cell_data={"cell_tags": [-marks, -solid]})
    tags = [*(name.value for name in names), "rod"]
    made.cell_tags = {-number: [name] for number, name in enumerate(tags, start=1)}
    return made
