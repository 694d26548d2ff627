"""Solids that are pieces of one rod: drawn twice at one place, or cut by planes and not joined again."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats, Ints, Vector, linked_groups, vector
from geometry.cad.bores import Pair
from geometry.cad.formats import NamedSolid
from geometry.cad.shapes import recognised_faces
from geometry.errors import GeometryError
from geometry.faces import face_middle, solid_points
from geometry.kernel import SOLID

# Coincident solids differ by less, relatively: two translators round differently.
_COINCIDENT = 1e-5
# Widest gap between two pieces that are joined, over the extent of all solids: 0.02 mm on a rod of 200 mm.
TOUCHING = 1e-4
# Cosine of the angle between faces that lie on each other, and the part of each that the others cover.
_PARALLEL, _COVERED = 1 - 1e-6, 0.98
# Two rods side by side on one pin touch at their rings; the face between two layers of a rod reaches from
# bore to bore, which is farther than this part of their distance.
_REACHES = 0.9
# Volume that two solids share, over that of the smaller one, from which on they overlap.
_OVERLAP = 1e-4
# Gaps below, mm, are rounding. Volume that joining pieces may lose or add, relatively.
_CLOSED, _KEPT = 1e-6, 1e-3
_REMEDY = "Join the pieces of the rod to one solid in the CAD program (Boolean union), and export it again"


def without_copies(solids: Sequence[NamedSolid]) -> tuple[list[NamedSolid], int]:
    """Keep one of several solids that coincide; also how many are removed from the open model."""
    kept: list[tuple[NamedSolid, Floats]] = []
    gone = []
    for solid in solids:
        measure = _measure(solid.tag)
        if any(np.abs(measure - other).max() < _COINCIDENT for _, other in kept):
            gone.append((SOLID, solid.tag))
        else:
            kept.append((solid, measure))
    if gone:
        gmsh.model.occ.remove(gone, recursive=True)
        gmsh.model.occ.synchronize()
    return [solid for solid, _ in kept], len(gone)


def _measure(tag: int) -> Floats:
    """Corners of the box, centre, inertia and volume of a solid, over powers of its size."""
    occ = gmsh.model.occ
    corners = np.array(gmsh.model.getBoundingBox(SOLID, tag))
    size = float(np.ptp(corners.reshape(2, 3), axis=0).max())
    places = np.concatenate([corners, occ.getCenterOfMass(SOLID, tag)]) / size
    inertia = np.array(occ.getMatrixOfInertia(SOLID, tag)) / size**5
    return np.concatenate([places, [np.log(size)], inertia, [occ.getMass(SOLID, tag) / size**3]])


class _PlaneFaces:
    """The plane faces of a solid: tags, unit normals (n, 3), middles, areas, and corners of their boxes."""

    def __init__(self, solid: int) -> None:
        flat = [face for face in recognised_faces((solid,)) if face.shape == "Plane"]
        self.tags = [face.tag for face in flat]
        self.normals = np.reshape([face_middle(tag)[1] for tag in self.tags], (-1, 3))
        self.areas = np.array([gmsh.model.occ.getMass(2, tag) for tag in self.tags])
        self.middles = np.reshape([gmsh.model.occ.getCenterOfMass(2, tag) for tag in self.tags], (-1, 3))
        self.low = np.reshape([face.low for face in flat], (-1, 3))
        self.high = np.reshape([face.high for face in flat], (-1, 3))

    def on(self, other: "_PlaneFaces", slack: float) -> Ints:
        """Places (n, 2) of faces of two solids that face each other in one plane, or lie apart in it."""
        apart = np.einsum("ijk,ik->ij", other.middles - self.middles[:, None], self.normals)
        near = (self.low[:, None] < other.high + slack) & (other.low < self.high[:, None] + slack)
        parallel = np.abs(self.normals @ other.normals.T) > _PARALLEL
        return np.argwhere(near.all(axis=2) & parallel & (np.abs(apart) < slack))


@dataclass(frozen=True)
class Cut:
    """A cut between two solids: plane faces that lie on each other and cover each other."""

    pair: tuple[int, int]
    faces: tuple[int, ...]  #: of the first solid
    shift: Vector = (0.0, 0.0, 0.0)  #: that brings the second solid onto the first, mm


def cuts_between(tags: Sequence[int]) -> list[Cut]:
    """Find the cuts between solids of the open model.

    A part that only lies against another one, as a crank's web against a rod, shares no whole face.
    """
    flats = {tag: _PlaneFaces(tag) for tag in tags}
    slack = TOUCHING * max(float(np.ptp(solid_points(tag), axis=0).max()) for tag in tags)
    shared: dict[tuple[int, int], list[tuple[int, int, Vector]]] = defaultdict(list)
    covered: dict[tuple[int, int], float] = defaultdict(float)  # of the faces of a solid
    for pair in combinations(tags, 2):
        first, second = (flats[tag] for tag in pair)
        for i, j in first.on(second, slack).tolist():
            area, away = _common(first, i, second, j)
            if area > 0:
                shared[pair].append((i, j, vector(-away * first.normals[i])))
                covered[pair[0], i] += area / first.areas[i]
                covered[pair[1], j] += area / second.areas[j]
    found = []
    for pair, faces in shared.items():
        whole = [
            (flats[pair[0]].tags[i], shift)
            for i, j, shift in faces
            if min(covered[pair[0], i], covered[pair[1], j]) > _COVERED
        ]
        if whole:
            shift = max((shift for _, shift in whole), key=np.linalg.norm)
            found.append(Cut(pair, tuple(tag for tag, _ in whole), shift))
    return found


def _common(flats: _PlaneFaces, i: int, others: _PlaneFaces, j: int) -> tuple[float, float]:
    """Area that two faces in one plane share, mm², and how far the second lies before the first, mm."""
    first, second = flats.tags[i], others.tags[j]
    away = float((others.middles[j] - flats.middles[i]) @ flats.normals[i])
    least, most = sorted((flats.areas[i], others.areas[j]))
    aside = np.abs(others.middles[j] - flats.middles[i] - away * flats.normals[i]).max()
    if first == second or (most - least < _COINCIDENT * most and aside < _COINCIDENT * np.sqrt(most)):
        return float(least), away
    occ = gmsh.model.occ
    copies = [occ.copy([(2, tag)])[0] for tag in (first, second)]
    occ.translate(copies[1:], *(-away * flats.normals[i]))
    with kernel.attempt("compare the faces of two solids", _REMEDY):
        made, _ = occ.intersect(copies[:1], copies[1:])
    area = sum(occ.getMass(2, tag) for dim, tag in made if dim == 2)
    occ.remove(made, recursive=True)
    return float(area), away


def one_rod(found: Sequence[Cut], rods: Mapping[int, Pair]) -> list[Cut]:
    """Pairs of solids that each have both bores and are one rod: layers, halves, or overlapping copies."""
    cuts = {contact.pair: contact for contact in found}
    joined = []
    for first, second in combinations(rods, 2):
        if not _same_bores(rods[first], rods[second]):
            continue
        cut = cuts.get((first, second)) or cuts.get((second, first))
        if cut is not None and any(_reaches(face, rods[first]) for face in cut.faces):
            joined.append(cut)
        elif cut is None and overlap(first, second) > 0:
            joined.append(Cut((first, second), ()))
    return joined


def _same_bores(first: Pair, second: Pair) -> bool:
    return any(
        all(
            a.parallel(b) and a.same_radius(b.radius, _REACHES / 100) and a.apart(b) < a.radius / 100
            for a, b in zip(first, pair, strict=True)
        )
        for pair in (second, second[::-1])
    )


def _reaches(face: int, bores: Pair) -> bool:
    low, high = np.reshape(gmsh.model.getBoundingBox(2, face), (2, 3))
    least = bores[0].apart(bores[1]) - bores[0].radius - bores[1].radius
    return bool(np.linalg.norm(high - low) > _REACHES * least)


def overlap(first: int, second: int) -> float:
    """Volume that two solids share, mm³; 0 where it is small against both."""
    occ = gmsh.model.occ
    boxes = [np.reshape(gmsh.model.getBoundingBox(SOLID, tag), (2, 3)) for tag in (first, second)]
    if (np.minimum(boxes[0][1], boxes[1][1]) <= np.maximum(boxes[0][0], boxes[1][0])).any():
        return 0.0
    least = min(occ.getMass(SOLID, tag) for tag in (first, second))
    with kernel.attempt("compare two solids", _REMEDY):
        made, _ = occ.intersect([(SOLID, first)], [(SOLID, second)], removeObject=False, removeTool=False)
    volume = sum(occ.getMass(SOLID, tag) for dim, tag in made if dim == SOLID)
    # A solid that lies inside the other is itself what they share.
    occ.remove([shape for shape in made if shape not in [(SOLID, first), (SOLID, second)]], recursive=True)
    return float(volume) if volume > _OVERLAP * least else 0.0


def touch(first: int, second: int, slack: float) -> bool:
    """Whether two solids are closer than `slack`, mm."""
    points = [solid_points(tag) for tag in (first, second)]
    low, high = (np.array([getattr(at, end)(axis=0) for at in points]) for end in ("min", "max"))
    if (low.max(axis=0) > high.min(axis=0) + slack).any():
        return False
    return bool(gmsh.model.occ.getDistance(SOLID, first, SOLID, second)[0] < slack)


def fused(solids: Sequence[NamedSolid], joins: Collection[Cut]) -> list[NamedSolid]:
    """Join solids of the open model at cuts. Raises `GeometryError`: they do not become one solid."""
    place = {solid.tag: at for at, solid in enumerate(solids)}
    ends = np.array([[place[tag] for tag in join.pair] for join in joins], dtype=np.int64)
    group = linked_groups(len(solids), *ends.T)
    result = []
    for number in dict.fromkeys(group.tolist()):
        pieces = [solid for solid, label in zip(solids, group, strict=True) if label == number]
        tags = {piece.tag for piece in pieces}
        between = [join for join in joins if join.pair[0] in tags]
        result.append(pieces[0] if len(pieces) == 1 else _union(pieces, between))
    gmsh.model.occ.synchronize()
    return result


def _close(pieces: Sequence[NamedSolid], joins: Sequence[Cut]) -> None:
    """Move pieces onto each other, beginning at the first one."""
    at, left = {pieces[0].tag: np.zeros(3)}, list(joins)
    while left:
        join = next((cut for cut in left if not at.keys().isdisjoint(cut.pair)), left[0])
        left.remove(join)
        for placed, new, sign in ((*join.pair, 1.0), (*join.pair[::-1], -1.0)):
            if placed in at and new not in at:
                at[new] = at[placed] + sign * np.array(join.shift)
                if np.linalg.norm(at[new]) > _CLOSED:
                    gmsh.model.occ.translate([(SOLID, new)], *at[new])


def _union(pieces: Sequence[NamedSolid], joins: Sequence[Cut]) -> NamedSolid:
    _close(pieces, joins)
    overlapping = any(not join.faces for join in joins)
    volume = sum(gmsh.model.occ.getMass(SOLID, piece.tag) for piece in pieces)
    names = ", ".join(piece.name or f"solid {piece.tag}" for piece in pieces)
    entities = [(SOLID, piece.tag) for piece in pieces]
    with kernel.attempt(f"join the pieces of the rod ({names})", _REMEDY):
        made, _ = gmsh.model.occ.fuse(entities[:1], entities[1:])
    tags = [tag for dim, tag in made if dim == SOLID]
    became = gmsh.model.occ.getMass(SOLID, tags[0]) if len(tags) == 1 else 0.0
    if len(tags) != 1 or (not overlapping and abs(became - volume) > _KEPT * volume):
        raise GeometryError(f"the pieces of the rod ({names}) do not become one solid. {_REMEDY}")
    return NamedSolid(tags[0], "")
