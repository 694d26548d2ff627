"""The rod as a tagged solid in an open gmsh session."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import gmsh

from geometry import kernel
from geometry.assembly import Assembly, BoltAxis, bolt_axes, check
from geometry.errors import GeometryError, require
from geometry.faces import Bore, Face, Feature, faces_of, features, surfaces
from geometry.features import check_areas, check_contacts
from geometry.imports import ImportReport
from geometry.kernel import bushed, chamfers, holes, tools_above
from geometry.mass import MassProperties, joined
from geometry.outline import Outline
from geometry.parts import Interface, bodies, contact_features, interfaces, parted, with_seats
from geometry.rod import Rod
from geometry.segments import Line, Segment
from geometry.surfaces import PLANE_AXIS, Mirror, Surface


@dataclass(frozen=True)
class Part:
    """A part of the solid, with one material.

    Attributes
    ----------
    name
        ``"rod"``, ``"bushing"``, another of `geometry.parts`, or the name in the imported file.
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
    imported
        What was made of the file that it comes from; None for a rod drawn from dimensions.
    bolts
        Of the whole rod, also when a cell was drawn; empty for a rod without an assembly.
    interfaces
        Where parts touch without being joined.
    """

    mirror: Mirror
    bores: tuple[Bore, Bore]
    parts: tuple[Part, ...]
    faces: dict[Surface, tuple[int, ...]]
    features: tuple[Feature, ...]
    mass: MassProperties
    imported: ImportReport | None = None
    bolts: tuple[BoltAxis, ...] = ()
    interfaces: tuple[Interface, ...] = ()

    @property
    def bodies(self) -> list[list[int]]:
        """Volume tags of each separate body; empty if all parts are joined."""
        return bodies([part.volumes for part in self.parts], self.interfaces)


def build(rod: Rod, mirror: Mirror = Mirror.QUARTER, assembly: Assembly | None = None) -> Solid:
    """Draw a rod, or a cell of it, in a new model of the open session.

    Parameters
    ----------
    rod
        What to draw.
    mirror
        The cell: `NONE` the whole, `HALF` z ≥ 0, `QUARTER` y ≥ 0 and z ≥ 0.
    assembly
        What is separate; None for a rod in one piece, with its bushing bonded to it.

    Returns
    -------
    Solid

    Raises
    ------
    InvalidValue
        The rod does not have the symmetry, or the parts do not go together.
    GeometryError
        The CAD kernel failed.
    """
    if assembly is not None:
        check(rod, assembly)
    _require_symmetry(rod.smallest_cell if assembly is None else assembly.smallest_cell(rod), mirror)
    gmsh.model.add("rod")
    turn = 0.0 if assembly is None else math.radians(assembly.split or 0.0)
    body = _plan(rod, mirror, turn)
    above = tools_above(rod, turn)
    if mirror is Mirror.NONE:
        above += [kernel.turned_over(tool) for tool in above]
    with kernel.attempt("cut ring steps and web pockets"):
        body = kernel.cut(body, above)
    with kernel.attempt("separate the bushing from the rod (rod.bushing_mm)"):
        volumes = bushed(rod, body)
    with kernel.attempt("drill and chamfer (rod.cap_bolt_mm, rod.oil_hole_mm, rod.…_chamfer_mm)"):
        cutters = [*holes(rod, turn), *chamfers(rod, mirror)]
        volumes = dict(zip(volumes, kernel.drilled(list(volumes.values()), cutters), strict=True))
    bolts = () if assembly is None else bolt_axes(rod, assembly)
    if assembly is not None:
        volumes = parted(rod, volumes, assembly, bolts)
    gmsh.model.occ.synchronize()
    parts = tuple(Part(name, (tag,), whole_mass(tag, mirror)) for name, tag in volumes.items())
    faces = faces_of(tuple(volumes.values()))
    found = features(rod, faces, turn)
    check_areas(rod, mirror, found)
    bores = (
        Bore(0.0, rod.big_end_bore / 2, rod.crank_bearing_width),
        Bore(rod.length, rod.small_end_bore / 2, rod.pin_bearing_width, rod.pin_bearing_taper),
    )
    mass = joined([part.mass for part in parts])
    solid = Solid(mirror, bores, parts, surfaces(bores, mirror, faces), found, mass)
    return solid if assembly is None else _assembled(rod, assembly, solid, faces, bolts)


def _assembled(
    rod: Rod, assembly: Assembly, solid: Solid, faces: Sequence[Face], bolts: tuple[BoltAxis, ...]
) -> Solid:
    """Name the faces where parts touch and bolts press."""
    parts = solid.parts
    found = interfaces([part.name for part in parts], [part.volumes for part in parts], assembly)
    named = with_seats(solid.faces, faces, bolts)
    check_contacts(rod, assembly, solid.mirror, found, named)
    thickness = {
        Surface.JOINT: rod.big_end_ring,
        Surface.BUSHING_SEAT: rod.bushing,
        Surface.SHELL_SEAT: assembly.shell,
    }
    small = contact_features(found, named, bolts, thickness)
    return replace(solid, faces=named, features=(*solid.features, *small), bolts=bolts, interfaces=found)


def _require_symmetry(smallest: Mirror, mirror: Mirror) -> None:
    cells = list(Mirror)
    rule = f"the smallest mirror cell of this rod is {smallest}"
    possible = cells.index(mirror) <= cells.index(smallest)
    require(possible, "symmetry", str(mirror), rule, "Choose that or a larger part.")


def _plan(rod: Rod, mirror: Mirror, turn: float) -> int:
    """Extrude the outline with its bores from the lowest to the highest face."""
    top = max(rod.big_end_width, rod.small_end_width) / 2
    outline = Outline(rod, turn)
    with kernel.attempt("extrude the rod's outline"):
        if mirror is Mirror.QUARTER:
            return kernel.prism(_upper_loop(outline), (), 0.0, top)
        holes = [(bore, bore.mirrored()) for bore in outline.bores]
        return kernel.prism(outline.whole, holes, 0.0 if mirror is Mirror.HALF else -top, top)


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
