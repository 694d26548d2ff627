"""Assembled rods as STEP files: rod, cap, bushing and shells as solids of their own, with bolts and nuts."""

import gmsh

from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

SHANK = 0.9  # radius of a bolt's shank over that of its hole


def write_assembly(rod, assembly, path, *, bolts=True, without=()):
    """Write a rod given by dimensions; `without` names parts to leave out."""
    with session():
        solid = build(rod, Mirror.NONE, assembly)
        axes = solid.bolts if bolts else ()
        drawn = [tag for bolt in axes for tag in fastener(bolt)]
        gone = [(3, tag) for part in solid.parts if part.name in without for tag in part.volumes]
        gmsh.model.occ.remove(gone, recursive=True)
        gmsh.model.occ.synchronize()
        for part in solid.parts:
            if part.name not in without:
                gmsh.model.setEntityName(3, part.volumes[0], part.name)
        for number, tag in enumerate(drawn):
            gmsh.model.setEntityName(3, tag, f"fastener {number}")
        gmsh.write(str(path))
    return path


def fastener(bolt):
    """Draw a bolt with a round head and, if it has one, its nut; return their volumes."""
    occ, (u, v, w) = gmsh.model.occ, bolt.direction
    height = bolt.head_radius
    last = bolt.thread_end if bolt.engaged else bolt.grip_end - height
    length = bolt.head - last
    shank = occ.addCylinder(*bolt.at(last), u * length, v * length, w * length, SHANK * bolt.hole_radius)
    head = occ.addCylinder(*bolt.at(bolt.head), u * height, v * height, w * height, bolt.head_radius)
    whole, _ = occ.fuse([(3, shank)], [(3, head)])
    tags = [tag for _, tag in whole]
    if not bolt.engaged:
        nut = occ.addCylinder(*bolt.at(last), u * height, v * height, w * height, bolt.nut_radius)
        inner = occ.addCylinder(*bolt.at(last), u * height, v * height, w * height, SHANK * bolt.hole_radius)
        tags += [tag for _, tag in occ.cut([(3, nut)], [(3, inner)])[0]]
    return tags
