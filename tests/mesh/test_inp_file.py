import numpy as np
import pytest
from tet_blocks import block, deck

from mesh.files.reading import read_inp, read_tets
from mesh.tetmesh import MeshError


def read(tmp_path, text):
    path = tmp_path / "a.inp"
    path.write_text(text)
    return read_inp(path)


@pytest.mark.parametrize("order", [1, 2])
def test_nodes_elements_and_their_numbers_are_read(tmp_path, order):
    file = block(order=order, first_number=7001)
    found = read(tmp_path, deck(file))
    np.testing.assert_array_equal(found.points, file.points)
    np.testing.assert_array_equal(found.tets, file.tets)
    np.testing.assert_array_equal(found.numbers, file.numbers)


def in_two_lines(line):
    """An element of ten nodes as Abaqus also writes it."""
    head = line[: len(line) // 2].rpartition(",")[0]
    return f"{head},\n {line[len(head) + 1 :]}" if line.count(",") == 10 else line


def test_what_other_programs_write_around_a_mesh_does_not_matter(tmp_path):
    file = block(order=2)
    lines = deck(file).splitlines()
    lines[1:1] = ["** a comment", ""]
    half = len(file.points) // 2
    lines[half:half] = ["*Nset, nset=SOME, generate", "1, 5, 1", "*node, nset=B"]
    text = "\n".join(map(in_two_lines, lines)).replace(
        "*ELEMENT, TYPE=C3D10", "*Element, elset=E, type=c3d10t"
    )
    skin = "*ELEMENT, TYPE=CPS6\n901, 1, 2, 3, 4, 5, 6\n"
    found = read(tmp_path, f"*Heading\nModel, 1\n{text}\n{skin}*Material, name=X\n*Elastic\n2e5, .3\n")
    np.testing.assert_array_equal(found.points, file.points)
    np.testing.assert_array_equal(found.tets, file.tets)


BLOCK = block()
BAD = {
    "no mesh at all": ("*HEADING\nnothing\n", "holds no elements"),
    "an empty file": ("", "holds no elements"),
    "hexahedra": (
        "*NODE\n1,0,0,0\n*ELEMENT, TYPE=C3D8R\n1,1,1,1,1,1,1,1,1\n",
        "1 hexahedra; only tetrahedra",
    ),
    "shells": ("*NODE\n1,0,0,0\n*ELEMENT, TYPE=S3\n1,1,1,1\n", "1 S3 but no tetrahedra"),
    "a missing node": (
        deck(BLOCK).replace("\n12, ", "\n912, "),
        "element 7 has a node that the file does not",
    ),
    "elements without nodes": ("*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n", "elements but no nodes"),
    "a cut line": (deck(BLOCK)[:-4], "incomplete"),
    "two parts": (
        deck(BLOCK) + deck(BLOCK).replace(", 0.0, 0.0, 0.0", ", 8.0, 0.0, 0.0"),
        "node 1 is defined twice",
    ),
    "both orders": (
        deck(BLOCK) + "*ELEMENT, TYPE=C3D10\n99,1,2,3,4,5,6,7,8,9,10\n",
        "first- and second-order",
    ),
    "generated nodes": (deck(BLOCK) + "*NGEN\n1,9\n", "NGEN, which is not supported"),
    "cylindrical coordinates": (deck(BLOCK).replace("*NODE", "*NODE, SYSTEM=C"), "not in Cartesian"),
    "a mesh elsewhere": ("*INCLUDE, INPUT=mesh.inp\n*STEP\n", r"another file \(\*INCLUDE, INPUT=mesh.inp\)"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_deck_that_cannot_be_used_is_refused(tmp_path, name):
    text, message = BAD[name]
    path = tmp_path / "a.inp"
    path.write_text(text)
    with pytest.raises(MeshError, match=message) as caught:
        read_tets(path)
    assert str(path) in str(caught.value)


def test_text_in_place_of_numbers_is_told_as_damage(tmp_path):
    path = tmp_path / "a.inp"
    path.write_text(deck(BLOCK).replace("1.0", "one", 1))
    with pytest.raises(MeshError, match="could not be read as a file of the format abaqus"):
        read_tets(path)
