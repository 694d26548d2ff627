"""Meshed load cases as an input deck for CalculiX and Abaqus; meshio writes only a mesh."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fea.base.material import Material
from fea.output.folder import write_text
from geometry.arrays import Floats, Mask
from mesh.tetmesh import FACES, TetMesh, faces_behind

# The ten-node tetrahedron numbers its mid-edge nodes as VTK does, so the order of the nodes does not change.
_ELEMENT = {1: "C3D4", 2: "C3D10"}
_PER_LINE = 8
# Forces below this part of the largest are what rounding leaves.
_NOTHING = 1e-12
_UNITS = "** mm, N, MPa, t"
# The decks' number of each face of `FACES`: S1 has the vertices 1-2-3, S2 1-4-2, S3 2-4-3, S4 3-4-1.
_FACE_NUMBER = np.array([1, 2, 4, 3])


@dataclass(frozen=True)
class Step:
    """One linear static load case."""

    title: str  #: for the comment above it; empty for none
    forces: Floats  #: (n_nodes, 3) nodal forces, N: pressures and body forces together
    fixed: Mask  #: (n_nodes, 3) the constrained degrees of freedom
    held_at: Floats | None = None  #: (n_nodes, 3) mm, the displacement of those; None for none


def write_inp(path: Path, mesh: TetMesh, material: Material, forces: Floats, fixed: Mask) -> None:
    """Write a linear static case for ``ccx -i NAME``, the path without ``.inp``; see `write_deck`, `Step`."""
    write_deck(path, mesh, {"material": material}, [Step("", forces, fixed)], ["static load case"])


def write_deck(
    path: Path,
    mesh: TetMesh,
    materials: Mapping[str, Material],
    steps: Sequence[Step],
    heading: Sequence[str],
) -> None:
    """Write load cases as the steps of a deck; `ccx -i NAME` solves it, NAME being the path without ``.inp``.

    Units are mm, N, MPa, t. Each surface of the mesh becomes a node set and an element surface of its name,
    each part an element set of its material. The body force stands in the nodal forces: the deck needs no
    motion. Every step replaces the loads of the one before and asks for displacements and nodal stresses.
    Raises `ValueError`: an array does not have one row per node; `StorageError`: the file could not be
    written.
    """
    for step in steps:
        for name, values in (("forces", step.forces), ("fixed", step.fixed)):
            if values.shape != mesh.points.shape:
                raise ValueError(f"{name} has shape {values.shape}: it must have {mesh.points.shape}.")
    lines = [
        "*HEADING",
        *heading,
        _UNITS,
        *_mesh(mesh),
        *_node_sets(mesh),
        *_surfaces(mesh),
        *_sections(mesh, materials),
        *(line for step in steps for line in _step(step, several=len(steps) > 1)),
    ]
    write_text(path, "\n".join(lines) + "\n")


def _mesh(mesh: TetMesh) -> Iterator[str]:
    yield "*NODE, NSET=NALL"
    numbers = range(1, len(mesh.points) + 1)
    # CalculiX reads at most 20 characters per number.
    for n, (x, y, z) in zip(numbers, mesh.points.tolist(), strict=True):
        yield f"{n},{x:.12e},{y:.12e},{z:.12e}"
    yield f"*ELEMENT, TYPE={_ELEMENT[mesh.order]}, ELSET=EALL"
    for n, nodes in enumerate((mesh.tets + 1).tolist(), start=1):
        yield ",".join(map(str, [n, *nodes]))


def _node_sets(mesh: TetMesh) -> Iterator[str]:
    for surface, facets in mesh.facets.items():
        if facets.size:
            yield f"*NSET, NSET={surface.name}"
            yield from _rows((np.unique(facets) + 1).tolist())


def _rows(numbers: Sequence[int]) -> Iterator[str]:
    for start in range(0, len(numbers), _PER_LINE):
        yield ",".join(map(str, numbers[start : start + _PER_LINE]))


def _surfaces(mesh: TetMesh) -> Iterator[str]:
    for surface, (behind, _) in faces_behind(mesh).items():
        if not behind.size:
            continue
        yield f"*SURFACE, NAME={surface.name}_FACES, TYPE=ELEMENT"
        element, face = np.divmod(behind, len(FACES))
        numbers = zip((element + 1).tolist(), _FACE_NUMBER[face].tolist(), strict=True)
        yield from (f"{n},S{number}" for n, number in numbers)


def _sections(mesh: TetMesh, materials: Mapping[str, Material]) -> Iterator[str]:
    for number, (part, material) in enumerate(materials.items()):
        letters = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in part.upper())
        name, elements = letters[:40] or "PART", "EALL"
        if mesh.part is not None:
            elements = f"E_{name}"
            yield f"*ELSET, ELSET={elements}"
            yield from _rows((np.flatnonzero(mesh.part == number) + 1).tolist())
        yield from (f"*MATERIAL, NAME={name}", "*ELASTIC")
        yield f"{material.youngs_modulus:.12g},{material.poissons_ratio:.12g}"
        yield from ("*DENSITY", f"{material.density:.12g}")
        yield f"*SOLID SECTION, ELSET={elements}, MATERIAL={name}"


def _step(step: Step, *, several: bool) -> Iterator[str]:
    new = ", OP=NEW" if several else ""
    if step.title:
        yield f"** {step.title}"
    yield from ("*STEP", "*STATIC")
    if step.fixed.any():
        yield f"*BOUNDARY{new}"
        held = np.zeros_like(step.forces) if step.held_at is None else step.held_at
        for node, axis in np.argwhere(step.fixed).tolist():
            value = f",{held[node, axis]:.12e}" if held[node, axis] else ""
            yield f"{node + 1},{axis + 1},{axis + 1}{value}"
    loaded = np.argwhere(np.abs(step.forces) > _NOTHING * np.abs(step.forces).max(initial=0.0))
    if len(loaded):
        yield f"*CLOAD{new}"
        values = step.forces[loaded[:, 0], loaded[:, 1]].tolist()
        for (node, axis), value in zip(loaded.tolist(), values, strict=True):
            yield f"{node + 1},{axis + 1},{value:.12e}"
    yield from ("*NODE FILE", "U", "*EL FILE", "S", "*END STEP")


_NODE = slice(3, 13)
_WIDTH = 12


def read_frd(path: Path, name: str, n_nodes: int, step: int = 1) -> Floats:
    """Return the values of a field at the nodes, NaN where the .frd file (in its text form) has none.

    The field is ``"DISP"`` (3 components) or ``"STRESS"`` (6: XX YY ZZ XY YZ XZ), of a step of the deck from
    1. Raises `ValueError`: the file has no such field of that step.
    """
    rows: list[str] = []
    reading, steps = False, 0
    with path.open(encoding="ascii") as file:
        for line in file:
            if line.startswith(" -4"):
                named = line[5:13].strip() == name
                steps += named
                reading = named and steps == step
            elif line.startswith(" -3"):
                reading = False
            elif reading and line.startswith(" -1"):
                rows.append(line)
    if not rows:
        raise ValueError(f"{path} has no field {name} of step {step}")
    numbers = np.array([int(row[_NODE]) for row in rows]) - 1
    values = [[float(row[k : k + _WIDTH]) for k in range(13, len(row.rstrip()), _WIDTH)] for row in rows]
    field = np.full((n_nodes, len(values[0])), np.nan)
    field[numbers] = values
    return field
