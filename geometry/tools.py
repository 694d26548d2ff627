"""The volumes cut from the extruded outline of a rod, and the bushing separated from it."""

import math

import gmsh

from geometry import kernel
from geometry.mirror import Mirror
from geometry.outline import Outline
from geometry.pocket import Pocket, web_pocket
from geometry.rod import Rod
from geometry.slant import space_beside
from geometry.step import RingStep, ring_steps


def tools_above(rod: Rod, turn: float = 0.0) -> list[int]:
    """Draw the volumes cut away above z = 0; below it, their mirror images are cut.

    Bosses are turned by `turn`, rad.
    """
    tools = []
    big, small = ring_steps(rod)
    top = max(big.ring, small.ring)
    if top > rod.shank_width / 2:
        # Their common part is what lies above both rings' faces: no seam where they meet on the shank.
        with kernel.attempt("draw the ring steps"):
            around = _above(big, top, rod, Outline(rod, turn).shank_sector)
            tools.append(kernel.common(around, _above(small, top, rod)))
    if rod.has_pockets:
        with kernel.attempt("round the pocket floor (rod.pocket_floor_radius_mm)"):
            tools.append(_pocket_tool(web_pocket(rod, Outline(rod).edge), top))
    if profile := space_beside(rod):
        with kernel.attempt("slant the small end (rod.small_end_crown_width_mm)"):
            tools.append(kernel.prism_along_y(profile, rod.small_end_radius * 2))
    return tools


def holes(rod: Rod, turn: float = 0.0) -> list[int]:
    """Draw the holes that lie on the plane z = 0; those of bolts are turned by `turn`, rad."""
    occ, tools = gmsh.model.occ, []
    if rod.oil_hole:
        tools.append(occ.addCylinder(rod.length, 0, 0, 2 * rod.small_end_radius, 0, 0, rod.oil_hole / 2))
    if rod.cap_bolt:
        length, at = 2 * rod.cap_boss_length, rod.cap_bolt_spacing / 2
        bolts = [occ.addCylinder(-length / 2, y, 0, length, 0, 0, rod.cap_bolt / 2) for y in (at, -at)]
        if turn:
            occ.rotate([(kernel.SOLID, bolt) for bolt in bolts], 0, 0, 0, 0, 0, 1, turn)
        tools += bolts
    return tools


def chamfers(rod: Rod, mirror: Mirror) -> list[int]:
    """Draw the cones that chamfer the ends of the bores above z = 0, and below it for the whole rod."""
    cones = []
    for x, bore, width, size in (
        (0.0, rod.big_end_bore, rod.big_end_width, rod.big_end_chamfer),
        (rod.length, rod.small_end_bore, rod.small_end_width, rod.small_end_chamfer),
    ):
        if size:  # from inside the bore to above the face, so that it crosses both at an angle
            start, end = (x, 0, width / 2 - 2 * size), (0, 0, 3 * size)
            cones.append(gmsh.model.occ.addCone(*start, *end, bore / 2 - size, bore / 2 + 2 * size))
    return cones if mirror is not Mirror.NONE else [*cones, *map(kernel.turned_over, cones)]


def bushed(rod: Rod, body: int) -> dict[str, int]:
    """Separate the bushing from the rod; they share the faces where they touch."""
    if not rod.bushing:
        return {"rod": body}
    occ, far = gmsh.model.occ, 2 * rod.small_end_width
    core = occ.addCylinder(rod.length, 0, -far / 2, 0, 0, far, rod.small_end_bore / 2 + rod.bushing)
    # The cylinder's seam must not lie where the oil hole will be.
    occ.rotate([(kernel.SOLID, core)], rod.length, 0, 0, 0, 0, 1, -math.pi / 2)
    _, (of_body, of_core) = occ.fragment([(kernel.SOLID, body)], [(kernel.SOLID, core)])
    occ.remove([piece for piece in of_core if piece not in of_body], recursive=True)
    (outer,) = (tag for dim, tag in of_body if (dim, tag) not in of_core)
    (inner,) = (tag for dim, tag in of_body if (dim, tag) in of_core)
    return {"rod": outer, "bushing": inner}


def _above(step: RingStep, top: float, rod: Rod, sector: float = math.pi) -> int:
    """Draw the space above a ring's face, its step and the plane of the shank's face."""
    far = 3 * (rod.length + rod.big_end_radius + rod.small_end_radius)
    return kernel.revolution(step.space_above(top, far), step.center, sector)


def _pocket_tool(pocket: Pocket, top: float) -> int:
    tool = kernel.prism(pocket.outline(), (), pocket.floor, pocket.floor + 1.1 * (top - pocket.floor))
    return kernel.bottom_rounded(tool, pocket.floor, pocket.floor_radius)
