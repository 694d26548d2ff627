"""[assembly] of a rod from a CAD file, whose joint and bolts are found in the file."""

import math
from dataclasses import replace

import numpy as np

from fea.assess.bolt_seats import BoltSeats
from fea.assess.fit_choice import FitRadii
from fea.rod.bores import Bores
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_materials import BUSHING, SHELL
from fea.study.assembly_table import AssemblyTable
from geometry.assembly import Assembly, BoltAxis, BoltSeat
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Directions in which a ring's thickness is looked at.
_SECTORS = 24


def asked_of_file(table: AssemblyTable) -> Assembly:
    """What a study says of the parts of a file; lengths of bolts that it does not give are 0."""
    return Assembly(
        split=table.split_angle,
        bushing=table.bushing_touches,
        shell=table.shell_thickness_mm or 0.0,
        bolt=BoltSeat(
            head_diameter=table.bolt_head_mm or 0.0,
            grip=table.bolt_grip_mm or 0.0,
            nut_diameter=table.bolt_nut_mm or 0.0,
            engaged=table.bolt_engaged_mm or 0.0,
        ),
    )


def found_in_file(table: AssemblyTable, bolt: BoltAxis) -> AssemblyTable:
    """Return [assembly] with the lengths of a bolt that was found."""
    return replace(
        table,
        bolt_head_mm=2 * bolt.head_radius,
        bolt_grip_mm=bolt.grip,
        bolt_nut_mm=2 * bolt.nut_radius or None,
        bolt_engaged_mm=bolt.engaged or None,
    )


def seats_in_file(bolt: BoltAxis, bores: Bores) -> BoltSeats:
    """Where a bolt that was found sits; the parts around it reach as far as to the bore, and not farther."""
    to_bore = math.hypot(*bolt.point[:2]) - bores.big_radius
    return BoltSeats(
        hole=2 * bolt.hole_radius,
        length=bolt.head - bolt.thread_end,
        cap=bolt.head,
        room=max(bolt.head_radius, bolt.nut_radius),
        outer=2 * min(to_bore, bores.big_width / 2, 2 * bolt.hole_radius),
        through=bool(bolt.nut_radius),
    )


def joint_angle(bolt: BoltAxis) -> float:
    """Angle of the normal of the joint from the rod's axis, degrees: bolts are square to the joint."""
    x, y, _ = bolt.direction
    return math.degrees(math.atan2(0.0 - y, -x))


def radii_in_file(mesh: MeshedRod) -> dict[str, FitRadii]:
    """Radii of the fits, by the inner part; the ring reaches out as far as it does at its thinnest."""
    big, small = mesh.bores.big_radius, mesh.bores.small_radius
    return {
        BUSHING: _radii(mesh.whole, Surface.BUSHING_SEAT, mesh.bores.rod_length, small),
        SHELL: _radii(mesh.whole, Surface.SHELL_SEAT, 0.0, big),
    }


def _radii(mesh: TetMesh, surface: Surface, x: float, bore: float) -> FitRadii:
    free = mesh.points[np.unique(mesh.facets[Surface.FREE])] - [x, 0.0, 0.0]
    radius, angle = np.hypot(free[:, 0], free[:, 1]), np.arctan2(free[:, 1], free[:, 0])
    sector = ((angle / math.pi + 1) / 2 * _SECTORS).astype(int) % _SECTORS
    outermost = np.zeros(_SECTORS)
    np.maximum.at(outermost, sector, radius)
    outer = float(outermost[outermost > bore].min())
    if surface not in mesh.facets:
        return FitRadii(bore, bore, outer)
    seat = mesh.points[np.unique(mesh.facets[surface])] - [x, 0.0, 0.0]
    return FitRadii(bore, float(np.hypot(seat[:, 0], seat[:, 1]).max()), outer)
