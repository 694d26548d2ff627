"""What meshio needs help with: Nastran's fields, and files that are not what their names say."""

import meshio
import numpy as np
import pytest
from tet_blocks import block

from mesh.errors import MeshError
from mesh.formats import FORMATS, is_mesh
from mesh.reading import read_tets

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
