"""Results as a VTU file, for ParaView, PyVista and meshio."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from fea.output.folder import StorageError, write_text
from mesh.tetmesh import TetMesh

Array = npt.NDArray[Any]

# What is loaded to write a file, once there is something to write.
LIBRARIES = ("vtkmodules.vtkIOXML", "vtkmodules.util.numpy_support")
# Names of the components, for arrays that have them; VTK's own order for a symmetric tensor.
COMPONENTS = {"stress": ("XX", "YY", "ZZ", "XY", "YZ", "XZ")}

# Names that older versions gave to arrays of the nodes and of the elements, and those of today.
_OLD_POINTS, _OLD_CELLS = {"safety_factor": "safety_factor_node"}, {"von_mises": "von_mises_max"}

# What is rounded by the von Mises stress at its node.
SCALED = ("stress", "principal_1", "principal_2", "principal_3")


def write_vtu(
    path: Path, mesh: TetMesh, point_data: Mapping[str, Array], cell_data: Mapping[str, Array] | None = None
) -> None:
    """Write a mesh and its results; the same input gives the same bytes.

    Point data are (n_nodes,) or (n_nodes, n_components), cell data likewise of the elements; each array keeps
    its precision. They are compressed by zlib, as meshio cannot read LZ4. Raises `ValueError`: an array does
    not have one row per node or element, or has too few components for its names; `StorageError`: the file
    could not be written.
    """
    write_cells(path, mesh.points, mesh.tets, point_data, cell_data or {})


# Bits of single precision that go: stresses are known to a per cent or so, and keep 2.4e-4 of a value, their
# components and principal values of the von Mises stress at the node; error bars keep .4 % of themselves.
# The von Mises stress keeps them all, so that its largest value is that of the summary.
_BITS = {"error_percent": 16, "von_mises": 0}
_MOST_BITS = 12
_OF_VON_MISES = 2.0**-11
# Displacements are in equilibrium with the loads to 1e-6 if they keep this part of the largest one; what is
# left out are zero bits, which compress.
_OF_LARGEST = 2.0**-34
# What coordinates are rounded to, mm.
_EXACT, _DRAWN = 2.0**-30, 2.0**-14


def write_result(
    path: Path,
    mesh: TetMesh,
    point_data: Mapping[str, Array],
    cell_data: Mapping[str, Array] | None = None,
    *,
    exact: bool,
) -> None:
    """Write a result as small as its error bars allow: stresses to 2.4e-4, displacements exactly.

    Elements come in the order of their first nodes, which compresses better. Coordinates are `exact`, to
    1e-9 mm, in one file of a run, from which it is read again, and to 6e-5 mm in the others. Otherwise as
    `write_vtu`.
    """
    order = np.argsort(mesh.tets.min(axis=1), kind="stable")
    write_cells(
        path,
        _to(_EXACT, mesh.points) if exact else _to(_DRAWN, mesh.points).astype(np.float32),
        mesh.tets[order],
        {name: _rounded(name, values, point_data.get("von_mises")) for name, values in point_data.items()},
        {name: _rounded(name, values[order]) for name, values in (cell_data or {}).items()},
    )


def _to(step: float | Array, values: Array) -> Array:
    # A zero's sign is that of rounding errors, which differ with the number of threads.
    return np.asarray(np.round(values / step) * step + 0.0)


def _rounded(name: str, values: Array, von_mises: Array | None = None) -> Array:
    """Return numbers of double precision rounded to what is known of them, in single precision mostly.

    Stresses and principal values are rounded to a power of two that the `von_mises` stress beside them sets.
    """
    if values.dtype != np.float64:
        return values
    if name == "displacement":
        largest = float(np.abs(values).max(initial=0.0))
        return _to(2.0 ** np.ceil(np.log2(largest)) * _OF_LARGEST, values) if largest else values
    if von_mises is not None and name in SCALED and (largest := float(von_mises.max(initial=0.0))):
        exponents = np.floor(np.log2(np.maximum(von_mises, 1e-6 * largest)))
        step = (_OF_VON_MISES * 2.0**exponents).reshape(-1, *(1,) * (values.ndim - 1))
        return _to(step, values).astype(np.float32)
    bits = _BITS.get(name, _MOST_BITS)
    half, kept = np.uint32((1 << bits) // 2), np.uint32(2**32 - (1 << bits))
    return ((np.ascontiguousarray(values, dtype=np.float32).view(np.uint32) + half) & kept).view(np.float32)


def write_cells(
    path: Path, points: Array, cells: Array, point_data: Mapping[str, Array], cell_data: Mapping[str, Array]
) -> None:
    """Write tetrahedra or triangles of either order: see `write_vtu`."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter  # noqa: PLC0415 - only writing needs VTK

    grid = vtk_grid(points, cells, point_data, cell_data)
    errors: list[str] = []
    writer = vtkXMLUnstructuredGridWriter()
    for source in (writer, writer.GetExecutive()):  # VTK does not print errors that are observed
        source.AddObserver("ErrorEvent", lambda _source, event: errors.append(event))
    writer.SetFileName(str(path))
    writer.SetInputData(grid)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    writer.SetCompressionLevel(1)  # higher ones take two to five times as long and save 4 %
    writer.SetHeaderTypeToUInt64()  # arrays beyond 4 GiB
    written = writer.Write() and not writer.GetErrorCode()
    del source, writer  # which hold the file open where writing failed: Windows removes no open file
    if errors or not written:
        raise StorageError(f"{path} could not be written. Check the free disk space and the permissions.")


def vtk_grid(
    nodes: Array, elements: Array, point_data: Mapping[str, Array], cell_data: Mapping[str, Array]
) -> Any:
    """Return a vtkUnstructuredGrid, which shares memory where it can. Parameters and errors: `write_vtu`."""
    from vtkmodules.util.numpy_support import numpy_to_vtk  # noqa: PLC0415
    from vtkmodules.vtkCommonCore import vtkPoints  # noqa: PLC0415
    from vtkmodules.vtkCommonDataModel import (  # noqa: PLC0415
        VTK_QUADRATIC_TETRA,
        VTK_QUADRATIC_TRIANGLE,
        VTK_TETRA,
        VTK_TRIANGLE,
        vtkCellArray,
        vtkUnstructuredGrid,
    )

    kinds = {3: VTK_TRIANGLE, 4: VTK_TETRA, 6: VTK_QUADRATIC_TRIANGLE, 10: VTK_QUADRATIC_TETRA}
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(nodes)))
    index = np.int32 if elements.size < np.iinfo(np.int32).max else np.int64
    offsets = np.arange(0, elements.size + 1, elements.shape[1], dtype=index)
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtk(offsets), numpy_to_vtk(elements.astype(index).ravel()))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(kinds[elements.shape[1]], cells)
    for name, values in point_data.items():
        grid.GetPointData().AddArray(_array(name, values, len(nodes)))
    for name, values in cell_data.items():
        grid.GetCellData().AddArray(_array(name, values, len(elements)))
    return grid


def _array(name: str, values: Array, rows: int) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk  # noqa: PLC0415

    values = np.ascontiguousarray(values)
    components = COMPONENTS.get(name, ())
    if values.ndim not in (1, 2) or len(values) != rows:
        raise ValueError(f"{name} has shape {values.shape}: it must have {rows} rows.")
    if components and values.shape[1:] != (len(components),):
        raise ValueError(f"{name} has shape {values.shape}: its components are {' '.join(components)}.")
    array = numpy_to_vtk(values)
    array.SetName(name)
    for k, component in enumerate(components):
        array.SetComponentName(k, component)
    return array


def point_name(name: str) -> str:
    """Return today's name of an array of the nodes in a file of any version."""
    return _OLD_POINTS.get(name, name)


def cell_name(name: str) -> str:
    """Return today's name of an array of the elements in a file of any version."""
    return _OLD_CELLS.get(name, name)


_HEAD = (
    '<?xml version="1.0"?>\n'
    '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
    "  <Collection>\n"
)
_FOOT = "  </Collection>\n</VTKFile>\n"


def write_pvd(path: Path, times: Mapping[str, float]) -> None:
    """Write a collection of files beside it, by crank angle, degrees, or number. Raises `StorageError`."""
    ordered = sorted(times.items(), key=lambda item: item[1])
    rows = (_row(name, time) for name, time in ordered)
    write_text(path, _HEAD + "".join(rows) + _FOOT)


def _row(name: str, time: float) -> str:
    shown, file = quoteattr(Path(name).stem), quoteattr(name)
    return f'    <DataSet timestep="{time:.10g}" part="0" name={shown} file={file}/>\n'
