"""Rounds that a CAD program has divided into strips along their length: the angle of the whole arc.

Elements that are small enough for each strip would be many times too small for the round.
"""

from collections.abc import Iterator, Mapping
from itertools import combinations

import gmsh
import numpy as np

from geometry.arrays import Floats

# Largest difference of the radii of two strips of one round, relatively, and of their normals at the edge.
_ALIKE, _SMOOTH = 0.05, 0.05
# The edge between two strips runs along the round: largest cosine of its angle with the arc.
_ALONG = 0.5


def whole_sweeps(rounds: Mapping[int, tuple[float, float]]) -> dict[int, float]:
    """Return the angle of the arc (rad) that each face of a round belongs to.

    Of strips it is at most a quarter turn, or their own angle: two fillets that meet in a groove keep theirs.

    Parameters
    ----------
    rounds
        Radius (mm) and angle of the own arc (rad) of faces of the open model, by tag.
    """
    sweeps = {tag: sweep for tag, (_, sweep) in rounds.items()}
    pairs = list(_neighbours(rounds))
    if not pairs:
        return sweeps
    from scipy import sparse  # noqa: PLC0415 - only divided rounds need it

    place = {tag: at for at, tag in enumerate(rounds)}
    own = np.array(list(sweeps.values()))
    one, other = np.array([[place[tag] for tag in pair] for pair in pairs]).T
    between = sparse.csr_array(((own[one] + own[other]) / 2, (one, other)), shape=(len(own), len(own)))
    apart = sparse.csgraph.shortest_path(between, directed=False)  # from middle to middle
    arcs = apart + (own[:, None] + own) / 2
    _, group = sparse.csgraph.connected_components(between, directed=False)
    widest = {int(one): float(arcs[np.ix_(group == one, group == one)].max()) for one in np.unique(group)}
    return {tag: max(sweeps[tag], min(widest[int(group[at])], np.pi / 2)) for tag, at in place.items()}


def _neighbours(rounds: Mapping[int, tuple[float, float]]) -> Iterator[tuple[int, int]]:
    """Pairs of faces of the same radius that go over into each other along an edge across their arc."""
    faces_at: dict[int, list[int]] = {}
    for tag in rounds:
        for _, edge in gmsh.model.getBoundary([(2, tag)], oriented=False):
            faces_at.setdefault(int(edge), []).append(tag)
    for edge, faces in faces_at.items():
        for one, other in combinations(faces, 2):
            radii = rounds[one][0], rounds[other][0]
            if abs(radii[0] - radii[1]) < _ALIKE * min(radii) and _continues(edge, one, other):
                yield one, other


def _continues(edge: int, one: int, other: int) -> bool:
    """Whether two faces have the same normal at the middle of an edge, which runs along the round."""
    (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
    middle = [(low + high) / 2]
    along = np.array(gmsh.model.getDerivative(1, edge, middle))
    along /= np.linalg.norm(along)
    (first, arc), (second, _) = (_normal_and_arc(edge, middle, face) for face in (one, other))
    smooth = np.linalg.norm(np.cross(first, second)) < _SMOOTH
    return bool(smooth and abs(along @ arc) < _ALONG)


def _normal_and_arc(edge: int, middle: list[float], face: int) -> tuple[Floats, Floats]:
    """Unit normal of a face at a place of its edge, and the direction in which it is curved most."""
    place = gmsh.model.reparametrizeOnSurface(1, edge, middle, face)
    most, least, toward_most, toward_least = gmsh.model.getPrincipalCurvatures(face, place)
    arc = toward_most if abs(most[0]) > abs(least[0]) else toward_least
    return np.array(gmsh.model.getNormal(face, place)), np.array(arc)
