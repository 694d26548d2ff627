"""What was found of an imported assembly, in words."""

from collections.abc import Sequence

from geometry.assembly import BoltAxis
from geometry.cad.joint import Joint


def text_of(joint: Joint | None, bolts: Sequence[BoltAxis]) -> list[str]:
    """Say where the joint and the bolts are."""
    said = [] if joint is None else [joint.text()]
    for bolt in bolts:
        x, y, z = bolt.point
        end = (
            f"thread engaged over {bolt.engaged:.4g} mm in a hole of {2 * bolt.thread_radius:.4g} mm"
            if bolt.engaged
            else f"nut on {2 * bolt.nut_radius:.4g} mm"
        )
        said.append(
            f"bolt through the joint at ({x:.4g}, {y:.4g}, {z:.4g}) mm from the crank pin: hole of "
            f"{2 * bolt.hole_radius:.4g} mm, head on {2 * bolt.head_radius:.4g} mm, "
            f"grip {bolt.grip:.4g} mm, {end}"
        )
    return said
