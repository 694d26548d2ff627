"""A meshed load case as an input deck for CalculiX and Abaqus; meshio writes only its mesh."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fea.material import Material
from fea.output.text import write_text
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh

# The ten-node tetrahedron numbers its mid-edge nodes as VTK does, so the order of the nodes does not change.
_ELEMENT = {1: "C3D4", 2: "C3D10"}
_PER_LINE = 8
_HEADING = ("*HEADING", "static load case", "** mm, N, MPa, t")


def write_inp(
    path: Path,
    mesh: TetMesh,
    material: Material,
    forces: Floats,
    fixed: npt.NDArray[np.bool_],
) -> None:
    """Write one linear static load case; `ccx -i NAME` solves it, NAME being the path without ``.inp``.

    Lengths are in mm, forces in N, stresses in MPa, masses in t. The body force stands in the nodal forces:
    the deck needs no motion. Asked for are displacements and nodal stresses.

    Parameters
    ----------
    path
        The file to write; its directory exists.
    mesh
        The mesh the case is solved on; each surface becomes a node set of its name.
    material
        Of every element.
    forces
        (n_nodes, 3) nodal forces, N.
    fixed
        (n_nodes, 3) the constrained degrees of freedom.

    Raises
    ------
    ValueError
        An array does not have one row per node.
    StorageError
        The file could not be written.
    """
    for name, values in (("forces", forces), ("fixed", fixed)):
        if values.shape != mesh.points.shape:
            raise ValueError(f"{name} has shape {values.shape}: it must have {mesh.points.shape}.")
    lines = [
        *_HEADING,
        *_mesh(mesh),
        *_node_sets(mesh),
        *_material(material),
        *_step(forces, fixed),
    ]
    write_text(path, "\n".join(lines) + "\n")


def _mesh(mesh: TetMesh) -> Iterator[str]:
    yield "*NODE, NSET=NALL"
    numbers = range(1, len(mesh.points) + 1)
    # CalculiX reads at most 20 characters per number.
    yield from (
        f"{n},{x:.12e},{y:.12e},{z:.12e}" for n, (x, y, z) in zip(numbers, mesh.points.tolist(), strict=True)
    )
    yield f"*ELEMENT, TYPE={_ELEMENT[mesh.order]}, ELSET=EALL"
    for n, nodes in enumerate((mesh.tets + 1).tolist(), start=1):
        yield ",".join(map(str, [n, *nodes]))


def _node_sets(mesh: TetMesh) -> Iterator[str]:
    for surface, facets in mesh.facets.items():
        if not facets.size:
            continue
        nodes = (np.unique(facets) + 1).tolist()
        yield f"*NSET, NSET={surface.name}"
        for start in range(0, len(nodes), _PER_LINE):
            yield ",".join(map(str, nodes[start : start + _PER_LINE]))


def _material(material: Material) -> Iterator[str]:
    yield "*MATERIAL, NAME=MATERIAL"
    yield "*ELASTIC"
    yield f"{material.youngs_modulus:.12g},{material.poissons_ratio:.12g}"
    yield "*DENSITY"
    yield f"{material.density:.12g}"
    yield "*SOLID SECTION, ELSET=EALL, MATERIAL=MATERIAL"


def _step(forces: Floats, fixed: npt.NDArray[np.bool_]) -> Iterator[str]:
    yield "*STEP"
    yield "*STATIC"
    if fixed.any():
        yield "*BOUNDARY"
        yield from (f"{node + 1},{axis + 1},{axis + 1}" for node, axis in np.argwhere(fixed).tolist())
    loaded = np.argwhere(forces)
    if len(loaded):
        yield "*CLOAD"
        values = forces[loaded[:, 0], loaded[:, 1]].tolist()
        yield from (
            f"{node + 1},{axis + 1},{value:.12e}"
            for (node, axis), value in zip(loaded.tolist(), values, strict=True)
        )
    yield "*NODE FILE"
    yield "U"
    yield "*EL FILE"
    yield "S"
    yield "*END STEP"
