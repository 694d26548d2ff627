"""The rod as a tagged solid in an open gmsh session."""

from dataclasses import dataclass

import gmsh

from geometry import kernel
from geometry.areas import check_areas
from geometry.errors import GeometryError
from geometry.faces import Bore, Feature, faces_of, features, surfaces
from geometry.intake import Intake
from geometry.invalid import require
from geometry.mass import MassProperties, joined
from geometry.mirror import PLANE_AXIS, Mirror
from geometry.outline import Outline
from geometry.rod import Rod
from geometry.segments import Line, Segment, mirrored
from geometry.surfaces import Surface
from geometry.tools import bushed, chamfers, holes, tools_above


@dataclass(frozen=True)
class Part:
    """A part of the solid, with one material.

    Attributes
    ----------
    name
        ``"rod"``, ``"bushing"``, or the name in the imported file.
    volumes
        gmsh's volume tags.
    mass
        Of the whole part (also when a cell was drawn) for density 1: the mass is the volume, mm³.
    """

    name: str
    volumes: tuple[int, ...]
    mass: MassProperties


@dataclass(frozen=True)
class Solid:
    """What `build` has drawn in the open session.

    Attributes
    ----------
    mirror
        The cell that was drawn.
    bores
        Of the big and the small end; the distance of their centres is `bores[1].x`.
    parts
        By material; at least one.
    faces
        gmsh's face tags of every surface of the boundary, cut planes included.
    features
        The faces that need small elements.
    mass
        Of the whole rod (also when a cell was drawn) for density 1: the mass is the volume, mm³.
    intake
        What was made of the file that it comes from; None for a rod drawn from dimensions.
    """

    mirror: Mirror
    bores: tuple[Bore, Bore]
    parts: tuple[Part, ...]
    faces: dict[Surface, tuple[int, ...]]
    features: tuple[Feature, ...]
    mass: MassProperties
    intake: Intake | None = None


def build(rod: Rod, mirror: Mirror = Mirror.QUARTER) -> Solid:
    """Draw a rod, or a cell of it, in a new model of the open session.

    Parameters
    ----------
    rod
        What to draw.
    mirror
        The cell: `NONE` the whole, `HALF` z ≥ 0, `QUARTER` y ≥ 0 and z ≥ 0.

    Returns
    -------
    Solid

    Raises
    ------
    InvalidValue
        The rod does not have the symmetry.
    GeometryError
        The CAD kernel failed.
    """
    _require_symmetry(rod, mirror)
    gmsh.model.add("rod")
    body = _plan(rod, mirror)
    above = tools_above(rod)
    if mirror is Mirror.NONE:
        above += [kernel.turned_over(tool) for tool in above]
    with kernel.attempt("cut ring steps and web pockets"):
        body = kernel.cut(body, above)
    with kernel.attempt("separate the bushing from the rod (rod.bushing_mm)"):
        bodies = bushed(rod, body)
    with kernel.attempt("drill and chamfer (rod.cap_bolt_mm, rod.oil_hole_mm, rod.…_chamfer_mm)"):
        cutters = [*holes(rod), *chamfers(rod, mirror)]
        bodies = dict(zip(bodies, kernel.drilled(list(bodies.values()), cutters), strict=True))
    gmsh.model.occ.synchronize()
    parts = tuple(Part(name, (tag,), whole_mass(tag, mirror)) for name, tag in bodies.items())
    faces = faces_of(tuple(bodies.values()))
    found = features(rod, faces)
    check_areas(rod, mirror, found)
    bores = (
        Bore(0.0, rod.big_end_bore / 2, rod.crank_bearing_width),
        Bore(rod.length, rod.small_end_bore / 2, rod.pin_bearing_width, rod.pin_bearing_taper),
    )
    mass = joined([part.mass for part in parts])
    return Solid(mirror, bores, parts, surfaces(bores, mirror, faces), found, mass)


def _require_symmetry(rod: Rod, mirror: Mirror) -> None:
    cells = list(Mirror)
    rule = f"the smallest mirror cell of this rod is {rod.smallest_cell}"
    possible = cells.index(mirror) <= cells.index(rod.smallest_cell)
    require(possible, "symmetry", str(mirror), rule, "Choose that or a larger part.")


def _plan(rod: Rod, mirror: Mirror) -> int:
    """Extrude the outline with its bores from the lowest to the highest face."""
    top = max(rod.big_end_width, rod.small_end_width) / 2
    outline = Outline(rod)
    with kernel.attempt("extrude the rod's outline"):
        if mirror is Mirror.QUARTER:
            return kernel.prism(_upper_loop(outline), (), 0.0, top)
        holes = [(bore, bore.mirrored()) for bore in outline.bores]
        loop = (*outline.upper, *mirrored(outline.upper))
        return kernel.prism(loop, holes, 0.0 if mirror is Mirror.HALF else -top, top)


def _upper_loop(outline: Outline) -> tuple[Segment, ...]:
    """Close the upper half along the axis, around the upper halves of the bores."""
    big, small = (bore.reversed() for bore in outline.bores)
    cap, crown = outline.upper[0].start, outline.upper[-1].end
    back = (Line(crown, small.start), small, Line(small.end, big.start), big, Line(big.end, cap))
    return (*outline.upper, *back)


def whole_mass(body: int, mirror: Mirror) -> MassProperties:
    """Return the kernel's own mass properties of a cell's volume, completed by reflection."""
    occ = gmsh.model.occ
    with kernel.attempt("integrate the volume"):
        volume = occ.getMass(kernel.SOLID, body)
        x, y, z = occ.getCenterOfMass(kernel.SOLID, body)
        a, b, c, d, e, f, g, h, i = occ.getMatrixOfInertia(kernel.SOLID, body)
    if not volume > 0:
        raise GeometryError(f"the CAD kernel made a solid of volume {volume:g} mm³; it must be positive")
    mass = MassProperties(volume, (x, y, z), ((a, b, c), (d, e, f), (g, h, i)))
    for plane in mirror.planes:
        mass = mass.reflected(PLANE_AXIS[plane])
    return mass
