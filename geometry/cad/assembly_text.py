"""What was found of an imported assembly, in words."""

import gmsh

from geometry.assembly import BoltAxis
from geometry.cad.joint import Joint
from geometry.solid import Solid


def text_of(solid: Solid, joint: Joint | None) -> tuple[str, ...]:
    """Say where the parts touch and where the bolts are."""
    said = [] if joint is None else [joint.text()]
    for one in solid.interfaces:
        first, second = (solid.parts[number].name for number in one.parts)
        area = solid.mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in one.faces)
        said.append(f"{first} and {second} touch over {area:.4g} mm²")
    return (*said, *map(_bolt, solid.bolts))


def _bolt(bolt: BoltAxis) -> str:
    x, y, z = bolt.point
    end = (
        f"thread engaged over {bolt.engaged:.4g} mm in a hole of {2 * bolt.thread_radius:.4g} mm"
        if bolt.engaged
        else f"nut on {2 * bolt.nut_radius:.4g} mm"
    )
    return (
        f"bolt through the joint at ({x:.4g}, {y:.4g}, {z:.4g}) mm from the crank pin: hole of "
        f"{2 * bolt.hole_radius:.4g} mm, head on {2 * bolt.head_radius:.4g} mm, "
        f"grip {bolt.grip:.4g} mm, {end}"
    )
