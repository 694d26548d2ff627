"""Places on a rod in words."""

from math import hypot

import numpy as np

from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_table import BUSHING, UPPER_SHELL
from geometry.surfaces import Surface

# Surfaces by which a place is known; where several meet, the first.
_NAMES = {
    Surface.BIG_END_BORE: "big-end bore",
    Surface.SMALL_END_BORE: "small-end bore",
    Surface.BOLT_HEAD: "seat of a bolt head",
    Surface.BOLT_THREAD: "seat of a nut or thread",
    Surface.JOINT: "joint",
    Surface.JOINT_CAP: "joint",
    Surface.BUSHING_SEAT: "seat of the bushing",
    Surface.BUSHING_BACK: "seat of the bushing",
    Surface.SHELL_SEAT: "seat of the shells",
    Surface.SHELL_BACK: "seat of the shells",
}
# What lines a bore, where the rod has such a part.
_LININGS = {
    Surface.BIG_END_BORE: (UPPER_SHELL, "bore of the bearing shells"),
    Surface.SMALL_END_BORE: (BUSHING, "bore of the bushing"),
}
# Shares of the length between the rings up to which a place on the shank is at its end, and towards it.
_AT_END, _TOWARDS_END = 0.1, 0.4


def place_name(mesh: MeshedRod, node: int) -> str:
    """Return where a node of the whole rod is: a bore or a seat, an end, the cap, or a part of the shank."""
    whole = mesh.whole
    for surface, name in _NAMES.items():
        if surface in whole.facets and (whole.facets[surface] == node).any():
            part, lining = _LININGS.get(surface, ("", name))
            return lining if part in mesh.parts else name
    x, y, _ = (float(value) for value in whole.points[node])
    length, along = mesh.bores.rod_length, whole.points[:, 0]
    big, small = -float(along.min()), float(along.max()) - length  # outer radii of the ends
    if hypot(x, y) <= big:
        return "cap" if x < 0 else "big end"
    if hypot(x - length, y) <= small:
        return "small end"
    share = float(np.clip((x - big) / (length - small - big), 0.0, 1.0))
    end = "big end" if share < 1 / 2 else "small end"
    from_end = min(share, 1 - share)
    if from_end > _TOWARDS_END:
        return "middle of the shank"
    return f"shank at the {end}" if from_end < _AT_END else f"shank towards the {end}"
