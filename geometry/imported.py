"""A rod from a STEP file, placed and cut in the same way as one drawn from dimensions."""

import math
from collections.abc import Sequence
from pathlib import Path

import gmsh
import numpy as np

from geometry import kernel
from geometry.bores import find_bores
from geometry.errors import GeometryError
from geometry.faces import Bore, Feature, FeatureKind, faces_of, surfaces
from geometry.holes import Hole
from geometry.mass import joined
from geometry.mirror import Mirror
from geometry.rounds import concave_rounds
from geometry.solid import Part, Solid, whole_mass
from geometry.step_file import read_step
from geometry.surfaces import Surface
from geometry.symmetry import cut_to, smallest_cell


def import_step(
    path: Path,
    mirror: Mirror | None = None,
    big_end_bore: float | None = None,
    small_end_bore: float | None = None,
) -> Solid:
    """Read a solid, or several, into a new model of the open session and place it in the rod's frame.

    Parameters
    ----------
    path
        The file; its own unit of length is respected.
    mirror
        The cell to keep; None for the smallest that the solid's symmetry allows.
    big_end_bore, small_end_bore
        Diameters, mm, needed if the two largest parallel through-holes are not the bores.

    Returns
    -------
    Solid
        One part per solid of the file, under its name there; touching parts share their faces.

    Raises
    ------
    GeometryError
        No solid in the file, bores that cannot be identified, or a mirror plane that the solid lacks.
    OSError
        The file cannot be read.
    """
    volumes, names = read_step(path)
    holes = find_bores(volumes, faces_of(volumes), (big_end_bore, small_end_bore))
    bores = _place(volumes, *holes)
    length = bores[1].x
    found = smallest_cell(volumes, length)
    mirror = found if mirror is None else mirror
    if len(mirror.planes) > len(found.planes):
        raise GeometryError(
            f'{path.name}: the solid does not have {mirror} symmetry. Use symmetry = "{found}" or "auto"'
        )
    parts = _parts(cut_to(volumes, mirror, length), names, mirror)
    volumes = [tag for part in parts for tag in part.volumes]
    faces = faces_of(volumes)
    mass = joined([part.mass for part in parts])
    named = surfaces(bores, mirror, faces)
    features = [
        Feature(FeatureKind.BORE, named[surface], bore.radius, 2 * math.pi)
        for surface, bore in zip((Surface.BIG_END_BORE, Surface.SMALL_END_BORE), bores, strict=True)
    ]
    free = [face for face in faces if face.tag in named[Surface.FREE]]
    return Solid(mirror, bores, parts, named, (*features, *concave_rounds(free, volumes, length)), mass)


def _place(volumes: Sequence[int], big: Hole, small: Hole) -> tuple[Bore, Bore]:
    """Move the solid so that the big-end bore is the origin, x leads to the small end, z along the pins."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 - only imported solids need it

    z = big.direction
    between = small.center - big.center
    x = between - (between @ z) * z
    length = float(np.linalg.norm(x))
    x = x / length
    turn = Rotation.from_matrix(np.stack([x, np.cross(z, x), z])).as_rotvec()
    angle = float(np.linalg.norm(turn))
    solids = [(kernel.SOLID, tag) for tag in volumes]
    with kernel.attempt("place the solid in the rod's frame"):
        gmsh.model.occ.translate(solids, *(-big.center))
        if angle > 1e-12:
            gmsh.model.occ.rotate(solids, 0, 0, 0, *(turn / angle), angle)
        gmsh.model.occ.synchronize()
    return (
        Bore(0.0, big.radius, big.mean_width),
        Bore(length, small.radius, small.mean_width, small.taper(x)),
    )


def _parts(cells: Sequence[Sequence[int]], names: Sequence[str], mirror: Mirror) -> tuple[Part, ...]:
    """Let touching parts share their faces, and compute the mass properties of each."""
    cells = [list(cell) for cell in cells]
    if sum(map(len, cells)) > 1:
        every = [(kernel.SOLID, tag) for cell in cells for tag in cell]
        with kernel.attempt("join the parts at their common faces"):
            _, pieces = gmsh.model.occ.fragment(every, [])
        became = {entity[1]: [tag for _, tag in made] for entity, made in zip(every, pieces, strict=True)}
        cells = [[piece for tag in cell for piece in became[tag]] for cell in cells]
        every_piece = [piece for cell in cells for piece in cell]
        if len(set(every_piece)) < len(every_piece):
            raise GeometryError(
                "the solids in the STEP file overlap; they may only touch. Correct them in the CAD program"
            )
    gmsh.model.occ.synchronize()
    return tuple(
        Part(name, tuple(cell), joined([whole_mass(tag, mirror) for tag in cell]))
        for name, cell in zip(_distinct(names), cells, strict=True)
    )


def _distinct(names: Sequence[str]) -> list[str]:
    """Number the names that occur more than once."""
    return [
        name if names.count(name) == 1 else f"{name} {names[:place].count(name) + 1}"
        for place, name in enumerate(names)
    ]
