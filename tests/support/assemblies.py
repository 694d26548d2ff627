"""Assembled rods: drawn at random, as studies, and as STEP files."""

import dataclasses
from dataclasses import replace

import gmsh
import numpy as np
from rod_studies import random_rod

from fea.study.assembly_table import AssemblyTable
from fea.study.flags import Flags
from fea.study.speed_tables import SpeedTable
from fea.study.study import load_study
from geometry.assembly import Assembly, BoltSeat
from geometry.errors import InvalidValue
from geometry.presets import PRESETS
from geometry.rod import Rod
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

LEON_2001 = PRESETS["leon-2001"]

# León's rod with bosses that are wide enough for bolt heads.
BOLTED = replace(
    LEON_2001,
    cap_bolt=9.0,
    cap_bolt_spacing=72.6,
    cap_boss_length=40.0,
    cap_boss_fillet=4.0,
    bushing=1.5,
    oil_hole=4.0,
    big_end_chamfer=0.5,
)
# Without pockets and steps, whose many faces and small elements tell nothing of its parts.
SIMPLE = replace(BOLTED, shank_section="rectangular", shank_width=30.0)
# With bosses that are short enough to be turned.
STUBBY = replace(
    BOLTED, cap_boss_length=24.0, cap_boss_fillet=3.0, big_end_fillet=12.0, cap_bolt_spacing=82.0
)
NUTS = BoltSeat(head_diameter=14.0, nut_diameter=13.0, grip=40.0)
SCREWS = BoltSeat(head_diameter=14.0, grip=24.0, engaged=12.0)


def random_assembly(seed: int) -> tuple[Rod, Assembly] | InvalidValue:
    """Draw a rod and what it is assembled from, or the refusal that the rod alone met.

    Parameters
    ----------
    seed
        The same seed draws the same.
    """
    draw = np.random.default_rng([seed, 19])
    rod = random_rod(seed)
    if isinstance(rod, InvalidValue):
        return rod
    head = rod.cap_bolt * draw.uniform(1.3, 1.7)
    try:
        if rod.cap_bolt and draw.random() < 0.8:
            rod = replace(rod, cap_bolt_spacing=rod.cap_bolt_spacing + head * draw.uniform(0, 1.2))
    except InvalidValue as refusal:
        return refusal
    length = rod.cap_boss_length
    thread = {"grip": length * draw.uniform(0.5, 0.8), "engaged": length * draw.uniform(0.1, 0.3)}
    nut = {"grip": length, "nut_diameter": head * draw.uniform(0.8, 1.1)}
    bolt = BoltSeat(head_diameter=head, **(nut if draw.random() < 0.5 else thread))
    oblique = draw.random() < 0.4
    return rod, Assembly(
        split=float(draw.uniform(-60, 60)) if oblique else 0.0,
        bushing=bool(rod.bushing) and draw.random() < 0.8,
        shell=rod.big_end_ring * float(draw.choice([0.0, draw.uniform(0.05, 0.6)])),
        bolt=bolt if rod.cap_bolt else None,
    )


EVERY = AssemblyTable(
    bolt_preload_kN=30.0,
    bolt_nut_mm=13.0,
    bushing_interference_mm=0.03,
    shell_thickness_mm=1.5,
    shell_interference_mm=0.03,
)


def study(table=EVERY, rpm=6000.0, rod=BOLTED, **flags):
    """León's rod with a cap, bolts, a bushing and shells."""
    given = load_study("leon-2001")
    given = dataclasses.replace(given, rod=dataclasses.replace(given.rod, dimensions=rod))
    given = Flags(pressure="contact", **flags).applied(given)
    return dataclasses.replace(given, speed=SpeedTable(rpm), assembly=table)


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
