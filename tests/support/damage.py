"""Text files, and meshes in the formats of other programs, damaged as disks and programs damage them."""

import re
import tempfile
from functools import cache
from pathlib import Path

import gmsh
import meshio
import numpy as np

NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
NUMBERS = ("0", "-1", "1e308", "-1e-300", "nan", "99999999999999999999", "1e9", ".", "")


def mutated(text, draw, *, most=6):
    """The text (one letter a byte) with up to `most` kinds of damage.

    Parameters
    ----------
    draw
        A `random.Random`.
    """
    kinds = (flipped, cut, ended, swapped, renumbered, renumbered, scaled, pointed, doubled)
    for _ in range(draw.randint(1, most)):
        if text:
            text = draw.choice(kinds)(text, draw)
    return text


def flipped(text, draw):
    """One bit wrong."""
    at = draw.randrange(len(text))
    return text[:at] + chr(ord(text[at]) ^ (1 << draw.randrange(8))) + text[at + 1 :]


def cut(text, draw):
    """A stretch lost."""
    at = draw.randrange(len(text))
    return text[:at] + text[at + draw.randint(1, 200) :]


def ended(text, draw):
    """The rest lost, seldom: not much is left to test then."""
    return text[: draw.randrange(len(text))] if draw.random() < 0.3 else text


def swapped(text, draw):
    """Two lines in each other's places."""
    lines = text.split("\n")
    a, b = draw.randrange(len(lines)), draw.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return "\n".join(lines)


def doubled(text, draw):
    """A line twice."""
    lines = text.split("\n")
    at = draw.randrange(len(lines))
    return "\n".join([*lines[: at + 1], *lines[at:]])


def renumbered(text, draw):
    """A number that is none, or far off."""
    return _changed(text, draw, NUMBER, lambda _: draw.choice(NUMBERS))


def scaled(text, draw):
    """A number somewhat off."""
    return _changed(text, draw, NUMBER, lambda found: f"{_value(found) * draw.uniform(-2, 3):.6g}")


def pointed(text, draw):
    """A reference of a STEP file that leads elsewhere."""
    return _changed(text, draw, re.compile(r"#\d+"), lambda _: f"#{draw.randint(0, 900)}")


def _changed(text, draw, pattern, change):
    found = list(pattern.finditer(text))
    if not found:
        return text
    match = draw.choice(found)
    return text[: match.start()] + change(match[0]) + text[match.end() :]


def _value(number):
    try:
        return float(number)
    except ValueError:
        return 1.0


KINDS = ("inp", "msh", "bdf", "vtu", "vtk", "med", "xdmf", "mesh")


@cache
def rod_mesh(order):
    """Nodes and tetrahedra of a small coarse rod."""
    from fea import prepare
    from fea.study.study import parse_study

    text = (
        "[rod]\nlength_mm = 141\nbig_end_bore_mm = 50\nsmall_end_bore_mm = 24\n"
        f'shank_section = "rectangular"\n[mesh]\nsize_mm = 30\nelement = "p{order}"\n'
        '[material]\npreset = "leon-2001"\n[forces]\npin_N = [2e4, 0.0]\n[analysis]\nsymmetry = "none"\n'
    )
    mesh = prepare(parse_study(text, "rod", Path.cwd())).mesh.whole
    return mesh.points, mesh.tets


def files_of(kind, points, tets):
    """The bytes of a mesh in a format, by the names of its files."""
    cells = [("tetra" if tets.shape[1] == 4 else "tetra10", tets)]
    options = {
        "msh": {"file_format": "gmsh22", "binary": False},
        "vtu": {"binary": False},
        "vtk": {"binary": False},
    }
    short = np.round(points, 6) if kind == "bdf" else points
    with tempfile.TemporaryDirectory() as folder:
        meshio.write(Path(folder, f"rod.{kind}"), meshio.Mesh(short, cells), **options.get(kind, {}))
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def write_surface(path, size, around):
    """Write the surface of the open model as STL: sides of a size, mm, so many triangles around a turn."""
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", around)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))


def wrecked(points, tets, draw):
    """Nodes and elements with the damage that editors and converters of meshes do."""
    points, tets = points.copy(), tets.copy()
    numbers = [draw.randrange(len(tets)) for _ in range(draw.choice([1, 5, len(tets) // 3]))]
    node, columns = draw.randrange(len(points)), list(range(tets.shape[1]))
    damage = draw.choice(
        ["turned", "shuffled", "doubled", "collapsed", "nan", "far", "moved", "lost", "torn", "apart"]
    )
    if damage == "turned":
        tets[numbers, :2] = tets[numbers, 1::-1]
    elif damage == "shuffled":
        draw.shuffle(columns)
        tets[numbers] = tets[numbers][:, columns]
    elif damage == "doubled":
        tets = np.vstack([tets, tets[numbers]])
    elif damage == "collapsed":
        tets[numbers, 1] = tets[numbers, 0]
    elif damage in ("nan", "far", "moved"):
        points[node] = {"nan": np.nan, "far": 1e300, "moved": points[node] + draw.uniform(-40, 40)}[damage]
    elif damage == "lost":
        tets = np.delete(tets, numbers, axis=0)
    elif damage == "torn":  # nodes of their own for some elements
        points = np.vstack([points, points[tets[numbers]].reshape(-1, 3) + 0.01])
        tets[numbers] = (
            len(points)
            - len(numbers) * tets.shape[1]
            + np.arange(len(numbers) * tets.shape[1]).reshape(len(numbers), -1)
        )
    else:  # a second body
        points, tets = np.vstack([points, points + 500]), np.vstack([tets, tets + len(points)])
    return points, tets


def damaged(kind, draw):
    """Files of a mesh with damage to its elements or to its bytes."""
    points, tets = rod_mesh(draw.choice([1, 2]))
    if draw.random() < 0.5:
        return files_of(kind, *wrecked(points, tets, draw))
    whole = files_of(kind, points, tets)
    most = draw.choice([1, 1, 2, 6])
    return {
        name: mutated(text.decode("latin-1"), draw, most=most).encode("latin-1")
        for name, text in whole.items()
    }
