"""The formats of meshes that can be read; needs no library."""

from pathlib import Path

# meshio's module for each suffix. It could guess them, but `meshio.read` prints errors and ends the program.
FORMATS = {
    ".inp": "abaqus",
    ".msh": "gmsh",
    ".bdf": "nastran",
    ".nas": "nastran",
    ".fem": "nastran",
    ".med": "med",
    ".vtk": "vtk",
    ".vtu": "vtu",
    ".xdmf": "xdmf",
    ".xmf": "xdmf",
    ".mesh": "medit",
    ".meshb": "medit",
    ".vol": "netgen",
    ".stl": "stl",
}


def is_mesh(path: Path) -> bool:
    """Whether the ending is that of a mesh file that can be read."""
    return path.suffix.lower() in FORMATS
