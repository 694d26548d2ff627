"""Which two through-holes of an imported solid are the bores."""

import math
from collections.abc import Sequence
from itertools import combinations

import gmsh
import numpy as np

from geometry.errors import GeometryError
from geometry.faces import Face
from geometry.holes import Hole, through_holes

_REMEDY = "Give the diameters of the bores as rod.big_end_bore_mm and rod.small_end_bore_mm"


def find_bores(
    volumes: Sequence[int], faces: Sequence[Face], named: tuple[float | None, float | None] = (None, None)
) -> tuple[Hole, Hole]:
    """Find the bores of the big and the small end: the two largest parallel through-holes.

    Of two with the same diameter, the one nearer to the centre of gravity is taken for the big end's.

    Parameters
    ----------
    volumes, faces
        Of the solid.
    named
        Diameters of the big-end and the small-end bore, mm, if the user has given them.

    Raises
    ------
    GeometryError
        The bores cannot be identified; the message lists the holes found and the keys that name the bores.
    """
    holes = through_holes(volumes, faces)
    _require_cylinders(holes, faces)
    big, small = ([hole for hole in holes if _has_diameter(hole, name)] for name in named)
    pairs = [
        (one, other)
        for one, other in combinations(holes, 2)
        if one.parallel(other) and one.apart(other) > max(one.radius, other.radius)
    ]
    fitting = [
        pair if pair[0] in big and pair[1] in small else pair[::-1]
        for pair in pairs
        if (pair[0] in big and pair[1] in small) or (pair[1] in big and pair[0] in small)
    ]
    if not fitting:
        listed = "; ".join(hole.text() for hole in holes) or "none"
        raise GeometryError(f"no two parallel bores were found. Through-holes: {listed}. {_REMEDY}")
    best = fitting[0]
    twice = len(fitting) > 1 and _alike(best[1], fitting[1][1]) and _alike(best[0], fitting[1][0])
    if twice or (named[1] is None and _is_amid(best, holes)):
        listed = "; ".join(hole.text() for hole in holes)
        raise GeometryError(f"more than one pair of holes could be the bores: {listed}. {_REMEDY}")
    return _heavier_first(best, volumes) if _alike(*best) else best


def _require_cylinders(holes: Sequence[Hole], faces: Sequence[Face]) -> None:
    """Refuse a solid without cylindrical holes if it has spline faces: its bores may be splines."""
    splines = sum("spline" in face.shape.lower() for face in faces)
    if not holes and splines:
        raise GeometryError(
            f"no through-hole is a cylinder, and {splines} of {len(faces)} faces are splines. Export the "
            "solid again with cylindrical bores that are not converted to splines"
        )


def _is_amid(bores: tuple[Hole, Hole], holes: Sequence[Hole]) -> bool:
    """Whether the small-end bore lies between the big-end bore and another hole of similar size.

    It may then be a hole in the shank that is larger than the pin bore.
    """
    big, small = bores
    return any(
        hole.parallel(small)
        and hole.radius > small.radius / 2
        and hole.apart(big) > max(small.apart(big), hole.apart(small))
        for hole in holes
    )


def _heavier_first(bores: tuple[Hole, Hole], volumes: Sequence[int]) -> tuple[Hole, Hole]:
    """Of two equal bores, take the one nearer to the centre of gravity for the big end's."""
    mass = np.array([gmsh.model.occ.getMass(3, volume) for volume in volumes])
    middle = mass @ [gmsh.model.occ.getCenterOfMass(3, volume) for volume in volumes] / mass.sum()
    one, other = bores
    along = (other.center - one.center) / np.linalg.norm(other.center - one.center)
    nearer_other = (middle - (one.center + other.center) / 2) @ along > 1e-6 * one.apart(other)
    return (other, one) if nearer_other else bores


def _has_diameter(hole: Hole, diameter: float | None) -> bool:
    return diameter is None or math.isclose(2 * hole.radius, diameter, rel_tol=1e-3)


def _alike(one: Hole, other: Hole) -> bool:
    return math.isclose(one.radius, other.radius, rel_tol=1e-3)
