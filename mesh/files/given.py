"""A mesh from a file in the rod's frame, with its bores named: what can be solved."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geometry.arrays import Floats, Ints, vector
from geometry.faces import Bore
from geometry.holes import EQUAL_BORES, Diameters, place_text, rod_frame
from geometry.imports import UNITS, BoreLocation, ImportReport, MissingCap, RodFile, plausible_unit
from geometry.surfaces import Surface
from mesh.files.bore_pair import Axes, Pair, find_bore_pair, fitted_axes
from mesh.files.cap import GAPS, shells, with_assumed_cap, with_cap
from mesh.files.reading import filled, read_tets, require_closed, stl_surface
from mesh.files.tets import Mended, mended
from mesh.quality import Quality, measure, scaled_jacobian
from mesh.quality import mended as straightened
from mesh.surface_mesh import SurfaceMesh
from mesh.tetmesh import EDGES, MeshError, TetMesh, boundary_facets, numbered

# Root mean square distance of the vertices of a bore from the fitted cylinder, over its radius. A pressure
# that varies around the bore is meaningless on a rougher one.
_ROUGHEST = 0.01
_SAME_BORE = 5e-3  # relative difference up to which radii count as equal
_ROUGH = 1e-3  # from here on a note says so
_BONDED = "rod and cap are bonded at the joint"
_ASSUMED_CAP = "the cap is missing: a ring of the section at the joint is assumed, without bolts (rod.cap)"
# Below this extent a rod cannot be meant in millimetres.
_LEAST_EXTENT = 3.0


@dataclass(frozen=True)
class GivenMesh:
    """A mesh from a file, ready to be solved."""

    mesh: TetMesh  #: placed in the rod's frame; every boundary facet is on a bore or free
    bores: tuple[Bore, Bore]  #: of the big and the small end
    size: float  #: mean length of the elements' edges, mm
    quality: Quality  #: of the elements
    imported: ImportReport  #: where the bores are in the file, in millimetres, and what was mended or assumed


def given_mesh(file: RodFile) -> GivenMesh:
    """Read a rod's mesh, check it, find its bores and place it in the rod's frame.

    Raises `MeshError`: the file is damaged, its mesh cannot be used, or its bores cannot be
    identified; `OSError` and `ImportError`: see `mesh.files.reading.read_tets`.
    """
    said: tuple[str, ...] = ()
    try:
        sound, said = _read(file)
        extent = float(np.ptp(sound.mesh.points, axis=0).max())
        scale = file.unit or ("m" if extent < _LEAST_EXTENT else "mm")
        given = _measured(sound, scale, file)
        usual = file.unit or plausible_unit(given.bores[1].x, scale)
        if usual != scale:
            given = _measured(sound, usual, file)
    except MeshError as error:
        raise MeshError(f"{file.path}: {error}") from error
    if file.unit is None and usual != "mm":
        why = "because in mm the rod would be of no usual length (rod.unit)"
        said = (f"the mesh is taken to be in {usual}, {why}", *said)
    return replace(given, imported=replace(given.imported, assumed=(*said, *given.imported.assumed)))


def _read(file: RodFile) -> tuple[Mended, tuple[str, ...]]:
    """Read the rod, with its cap where it has one of its own or one is to be assumed; and what was done."""
    path, cap = file.path, file.cap
    if cap is MissingCap.REFUSED and path.suffix.lower() != ".stl":
        return mended(read_tets(path)), ()
    surface, sound = _surface(path)
    bodies = [part for part in shells(surface) if part.volume > 0]
    if isinstance(cap, Path):
        return _joined(surface, _surface(cap)[0]), (_BONDED,)
    if len(bodies) == 2:
        return _joined(*bodies), (_BONDED,)
    if len(bodies) > 2:
        places = ", ".join(place_text(body.center) for body in bodies[:3])
        raise MeshError(
            f"it holds {len(bodies)} separate bodies, the largest around {places}: at most a rod and its cap "
            "can be joined. Export the rod alone, and the cap to another file (rod.cap)"
        )
    completed = with_assumed_cap(surface) if cap is MissingCap.ASSUMED else None
    if completed is None:
        if not any(file.diameters):
            find_bore_pair(surface)  # refused before its inside is meshed
        return sound or mended(filled(surface)), ()
    require_closed(completed)
    return mended(filled(completed)), (_ASSUMED_CAP,)


def _joined(rod: SurfaceMesh, cap: SurfaceMesh) -> Mended:
    """Mesh rod and cap as one body; where gmsh cannot follow a narrow band between them, a wider one."""
    for gap in GAPS:
        completed = with_cap(rod, cap, gap)
        require_closed(completed)
        try:
            return mended(filled(completed))
        except MeshError as error:
            failed = error
    raise failed


def _surface(path: Path) -> tuple[SurfaceMesh, Mended | None]:
    """The surface of a file, and its mesh if that is one of tetrahedra."""
    if path.suffix.lower() == ".stl":
        return stl_surface(path), None
    sound = mended(read_tets(path))
    return SurfaceMesh(sound.mesh.points, boundary_facets(sound.mesh.tets)[:, :3]), sound


def _measured(sound: Mended, unit: str, file: RodFile) -> GivenMesh:
    scaled = replace(sound.mesh, points=UNITS[unit] * sound.mesh.points)
    mesh, curved = straightened(scaled)
    inverted = np.flatnonzero(scaled_jacobian(mesh) <= 0)
    if inverted.size:
        place = place_text(mesh.points[mesh.tets[inverted[0], :4]].mean(axis=0))
        raise MeshError(
            f"{inverted.size} elements are folded over and could not be mended; the first is around "
            f"{place}. Mesh the rod again"
        )
    facets = boundary_facets(mesh.tets)
    surface = SurfaceMesh(mesh.points, facets[:, :3])
    pair = find_bore_pair(surface, file.diameters)
    guessed = pair[0].same_radius(pair[1].radius, _SAME_BORE) and not (file.swap_ends or any(file.diameters))
    pair = pair[::-1] if file.swap_ends else pair
    axes = _axes(surface, pair)
    placed, bores = _placed(mesh, surface, pair, axes)
    whole = replace(placed, facets=_named(facets, pair))
    rough = f"the bores are cylinders to {100 * axes.residual:.2g} % of their radius"
    equal = [EQUAL_BORES] if guessed else []
    assumed = [*equal, *sound.notes, *([rough] if axes.residual > _ROUGH else [])]
    boundaries = surface.patches(np.ones(len(facets), dtype=bool), math.inf)
    if len(boundaries) > 1:
        least = min(boundaries, key=len)
        assumed.append(
            f"the mesh has {len(boundaries) - 1} closed cavities inside, the smallest with {len(least)} "
            f"facets around {place_text(surface.corners[least].reshape(-1, 3).mean(axis=0))} of the file: is "
            "an element missing?"
        )
    big, small = (
        BoreLocation(2 * bore.radius, vector(hole.center), bore.width)
        for hole, bore in zip(pair, bores, strict=True)
    )
    imported = ImportReport(unit, (), (big, small), tuple(assumed))
    return GivenMesh(numbered(whole)[0], bores, mean_edge(placed), measure(whole, curved), imported)


def named_mesh(mesh: TetMesh, diameters: Diameters) -> tuple[TetMesh, tuple[Bore, Bore]]:
    """Find the bores of a mesh that a run has left in the rod's frame, and name its surfaces.

    Raises `MeshError`: its bores cannot be identified.
    """
    facets = boundary_facets(mesh.tets)
    surface = SurfaceMesh(mesh.points, facets[:, :3])
    pair = find_bore_pair(surface, diameters)
    if pair[0].center[0] > pair[1].center[0]:
        pair = pair[::-1]
    _, bores = _placed(mesh, surface, pair, _axes(surface, pair))
    return replace(mesh, facets=_named(facets, pair)), bores


def _axes(surface: SurfaceMesh, pair: Pair) -> Axes:
    clouds = [surface.points[np.unique(surface.facets[bore.facets])] for bore in pair]
    axes = fitted_axes(clouds, pair[0].direction)
    if axes.residual > _ROUGHEST:
        raise MeshError(
            f"its bores are not round: their vertices are off the fitted cylinders by "
            f"{100 * axes.residual:.2g} % of the radius (root mean square); at most {100 * _ROUGHEST:g} % "
            "are allowed"
        )
    return axes


def _placed(mesh: TetMesh, surface: SurfaceMesh, pair: Pair, axes: Axes) -> tuple[TetMesh, tuple[Bore, Bore]]:
    z = axes.direction
    heights = [surface.corners[bore.facets] @ z for bore in pair]
    middles = [(height.min() + height.max()) / 2 for height in heights]
    big, small = (c + (m - c @ z) * z for c, m in zip(axes.centers, middles, strict=True))
    turn, length = rod_frame(z, small - big)
    placed = replace(mesh, points=(mesh.points - big) @ turn.T)
    corners = (
        ((surface.corners - big) @ turn.T)[pair[0].facets],
        ((surface.corners - small) @ turn.T)[pair[1].facets],
    )
    widths = [_width(wall, float(radius)) for wall, radius in zip(corners, axes.radii, strict=True)]
    return placed, (
        Bore(0.0, float(axes.radii[0]), widths[0][0]),
        Bore(length, float(axes.radii[1]), *widths[1]),
    )


def _width(corners: Floats, radius: float) -> tuple[float, float]:
    """Mean width of a wall and its taper (see `Bore`), from its corners (n, 3, 3) about the bore's centre."""
    angle = np.arctan2(corners[..., 1], corners[..., 0])
    unrolled = angle[:, :1] + (angle - angle[:, :1] + np.pi) % (2 * np.pi) - np.pi
    spans, rises = unrolled[:, 1:] - unrolled[:, :1], corners[:, 1:, 2] - corners[:, :1, 2]
    areas = radius * np.abs(spans[:, 0] * rises[:, 1] - spans[:, 1] * rises[:, 0]) / 2
    around = np.cos(unrolled).mean(axis=1)
    return float(areas.sum() / (2 * np.pi * radius)), float(areas @ around / (np.pi * radius))


def _named(facets: Ints, pair: Pair) -> dict[Surface, Ints]:
    free = np.ones(len(facets), dtype=bool)
    for bore in pair:
        free[bore.facets] = False
    return {
        Surface.BIG_END_BORE: facets[pair[0].facets],
        Surface.SMALL_END_BORE: facets[pair[1].facets],
        Surface.FREE: facets[free],
    }


def mean_edge(mesh: TetMesh) -> float:
    """Mean length of the elements' straight edges, mm."""
    ends = mesh.points[mesh.tets[:, EDGES]]
    return float(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).mean())
