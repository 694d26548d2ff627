"""What meshio needs help with: Nastran's fields, and files that are not what their names say."""

import meshio
import numpy as np
import pytest
import pyvista as pv
from tet_blocks import block
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from mesh.files.reading import read_tets
from mesh.files.tets import FORMATS, is_mesh
from mesh.tetmesh import MeshError

FILE = block(order=2)


def grids(frame="", field="{:<16.9f}"):
    rows = enumerate(FILE.points.tolist(), 1)
    return "".join(
        f"GRID*   {n:<16d}{frame:<16s}{field.format(x)}{field.format(y)}\n*       {field.format(z)}\n"
        for n, (x, y, z) in rows
    )


def elements(first, second, width=8):
    """Ten nodes each, six of them in the first line."""
    lines = []
    for n, nodes in enumerate((FILE.tets + 1).tolist(), 1):
        words = [f"{number:<{width}d}" for number in [n, 1, *nodes]]
        lines += [
            first.format("".join(words[:8]), ",".join(words[:8]).replace(" ", "")),
            second.format("".join(words[8:]), ",".join(words[8:]).replace(" ", "")),
        ]
    return "\n".join(lines) + "\n"


CONTINUED = {
    "marked": ("CTETRA  {0}+1", "+1      {0}"),
    "blank": ("CTETRA  {0}", "        {0}"),
    "free": ("CTETRA,{1},+1", "+1,{1}"),
    "free and blank": ("CTETRA,{1}", ",{1}"),
}


@pytest.mark.parametrize("style", CONTINUED)
@pytest.mark.parametrize("framed", [True, False])
def test_elements_of_nastran_go_on_in_a_second_line(tmp_path, style, framed):
    text = grids() + elements(*CONTINUED[style])
    path = tmp_path / "rod.bdf"
    path.write_text(f"SOL 101\nCEND\nBEGIN BULK\n{text}ENDDATA\n" if framed else text)
    found = read_tets(path)
    np.testing.assert_array_equal(found.tets, FILE.tets)
    np.testing.assert_array_equal(found.points, FILE.points)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (grids(frame="7") + elements(*CONTINUED["marked"]), "use coordinate systems"),
        (grids() + elements("CTETRA* {0}+1", "+1      {0}"), "in large fields"),
        (grids() + elements("CTETRA  {0}", "$       {0}"), "neither four nor ten nodes"),
        (grids(), "holds no elements"),
    ],
)
def test_what_meshio_would_drop_from_nastran_is_refused(tmp_path, text, message):
    (tmp_path / "rod.nas").write_text(text)
    with pytest.raises(MeshError, match=message):
        read_tets(tmp_path / "rod.nas")


def test_double_precision_of_nastran_is_read(tmp_path):
    text = grids(field="{:<16.9e}").replace("e+", "D+").replace("e-", "D-")  # as pyNastran writes it
    (tmp_path / "rod.bdf").write_text(text + elements(*CONTINUED["marked"]))
    np.testing.assert_allclose(read_tets(tmp_path / "rod.bdf").points, FILE.points, rtol=1e-9)


@pytest.mark.parametrize("compressor", ["ZLib", "LZMA", "LZ4"])
def test_compressed_vtu_files_are_read_or_refused_with_the_remedy(tmp_path, compressor):
    writer = vtkXMLUnstructuredGridWriter()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    writer.SetInputData(pv.UnstructuredGrid({pv.CellType.QUADRATIC_TETRA: FILE.tets}, FILE.points))
    writer.SetFileName(str(tmp_path / "rod.vtu"))
    writer.Write()
    if compressor == "LZ4":
        with pytest.raises(MeshError, match="compressed with LZ4, which is not supported"):
            read_tets(tmp_path / "rod.vtu")
    else:
        np.testing.assert_array_equal(read_tets(tmp_path / "rod.vtu").points, FILE.points)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_file_of_anything_else_is_told_with_its_name_and_format(tmp_path, suffix):
    path = tmp_path / f"rod{suffix}"
    path.write_bytes(bytes(range(256)) * 20)
    assert is_mesh(path)
    with pytest.raises(MeshError, match=f"rod{suffix}"):
        read_tets(path)


def test_solids_of_other_shapes_are_counted_and_refused(tmp_path):
    points = np.random.default_rng(0).random((8, 3))
    cells = [("hexahedron", [list(range(8))]), ("tetra", [[0, 1, 2, 3]])]
    meshio.write(tmp_path / "rod.vtu", meshio.Mesh(points, cells))
    with pytest.raises(MeshError, match="it holds 1 hexahedra; only tetrahedra"):
        read_tets(tmp_path / "rod.vtu")
    meshio.write(tmp_path / "skin.vtu", meshio.Mesh(points, [("triangle", [[0, 1, 2]])]))
    with pytest.raises(MeshError, match="it holds 1 triangles but no tetrahedra"):
        read_tets(tmp_path / "skin.vtu")


def test_a_gmsh_file_with_physical_groups_on_some_entities_alone_is_read(tmp_path):
    # Two volumes, one of them in a group: meshio does not take this.
    points = "\n".join(f"{x} {y} {z}" for x, y, z in FILE.points.tolist())
    half = len(FILE.tets) // 2
    rows = [
        " ".join(map(str, [n, *(tet + 1)]))
        for n, tet in enumerate(FILE.tets[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]], 1)
    ]
    box = "0 0 0 2 1 1"
    (tmp_path / "rod.msh").write_text(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 2\n"
        f"1 {box} 1 7 0\n2 {box} 0 0\n$EndEntities\n"
        f"$Nodes\n1 {len(FILE.points)} 1 {len(FILE.points)}\n3 1 0 {len(FILE.points)}\n"
        + "\n".join(map(str, range(1, len(FILE.points) + 1)))
        + f"\n{points}\n$EndNodes\n"
        f"$Elements\n2 {len(rows)} 1 {len(rows)}\n3 1 11 {half}\n"
        + "\n".join(rows[:half])
        + f"\n3 2 11 {len(rows) - half}\n"
        + "\n".join(rows[half:])
        + "\n$EndElements\n"
    )
    with pytest.raises(Exception, match="physical"):
        meshio.gmsh.read(tmp_path / "rod.msh")
    found = read_tets(tmp_path / "rod.msh")
    np.testing.assert_array_equal(found.tets, FILE.tets)
    np.testing.assert_allclose(found.points, FILE.points)


def test_a_script_that_is_called_a_mesh_is_not_run(tmp_path):
    (tmp_path / "rod.msh").write_text(f'SystemCall "touch {tmp_path}/run";\n')
    with pytest.raises(MeshError, match="could not be read as a file of the format gmsh"):
        read_tets(tmp_path / "rod.msh")
    assert not (tmp_path / "run").exists()
