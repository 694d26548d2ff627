"""From [assembly] of a study to what is drawn, and to how the parts are put together."""

import math
from dataclasses import dataclass, replace

import numpy as np

from fea.base.note import Note, assumptions
from fea.contact.assembly_state import AssemblySpecification, Expansion
from fea.judge.bolt import TightenedBolt
from fea.judge.bolt_choice import BoltSeats, choose_bolt, seats_of
from fea.judge.press_fit import ROD, Expansions, FitRadii, fit_notes, radii_of
from fea.rod.meshed_rod import Bores, MeshedRod
from fea.study.assembly_table import BOLT, BUSHING, SHELL, AssemblyTable
from fea.study.material_table import (
    MaterialTable,
    assumed_materials,
    bolt_material,
    table_name,
    thermal_expansion,
)
from fea.study.option_tables import PINS
from fea.study.study import Study
from geometry.assembly import Assembly, BoltAxis, BoltSeat
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Directions in which a ring's thickness is looked at.
_SECTORS = 24


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


# Of pins whose material is not given.
_PIN_STEEL = MaterialTable(E_GPa=206.0, nu=0.3, density_kg_m3=7850.0, yield_MPa=400.0)


def drawn_assembly(study: Study) -> Assembly | None:
    """What is separate in the rod; None for one piece. Raises `InvalidValue`: bolts and rod do not fit."""
    if study.assembly is not None and study.rod.cad is not None:
        table = study.assembly  # lengths of bolts that it does not give are 0
        given = (table.bolt_head_mm, table.bolt_nut_mm, table.bolt_grip_mm, table.bolt_engaged_mm)
        return _geometry(table, table.split_angle, *(value or 0.0 for value in given))
    assembling = AssemblySetup.of(study)
    return None if assembling is None else assembling.geometry


def _geometry(table: AssemblyTable, split: float, *lengths: float) -> Assembly:
    head, nut, grip, engaged = lengths
    seat = BoltSeat(head_diameter=head, nut_diameter=nut, grip=grip, engaged=engaged)
    shell = table.shell_thickness_mm or 0.0
    return Assembly(split=split, bushing=table.bushing_touches, shell=shell, bolt=seat)


@dataclass(frozen=True, kw_only=True)
class AssemblySetup:
    """The assembly of a study."""

    table: AssemblyTable  #: [assembly]
    bolt: TightenedBolt  #: each of the cap's bolts
    geometry: Assembly  #: what is separate
    fit_notes: tuple[Note, ...]  #: on press fits, as Lamé estimates them
    expansions: Expansions  #: of the parts, at the assembly's temperature

    @classmethod
    def of(cls, study: Study, mesh: MeshedRod | None = None) -> "AssemblySetup | None":
        """Complete what a study says of its parts and bolts; None for a rod of one piece.

        `mesh`: of a rod from a file, which tells where the bolts are; not needed for one given by dimensions.
        Raises `InvalidValue`: bolts and rod do not go together.
        """
        table, rod, split = study.assembly, study.rod.dimensions, None
        if table is None:
            return None
        if rod is not None:
            seats, radii = seats_of(rod), radii_of(rod, table.shell_thickness_mm or 0.0)
        elif mesh is not None and mesh.bolts:
            first = mesh.bolts[0]
            x, y, _ = first.direction  # square to the joint
            seats, split = seats_in_file(first, mesh.bores), math.degrees(math.atan2(0.0 - y, -x))
            radii = radii_in_file(mesh)
            table = replace(
                table,
                bolt_head_mm=2 * first.head_radius,
                bolt_grip_mm=first.grip,
                bolt_nut_mm=2 * first.nut_radius or None,
                bolt_engaged_mm=first.engaged or None,
            )
        else:
            return None
        chosen = choose_bolt(table, seats, study.part_material.get(BOLT), study.material.material())
        bolt = chosen.bolt
        materials = {
            ROD: study.part_material_table(ROD),
            BOLT: bolt_material(study.part_material, table.grade),
        }
        inner = (BUSHING, table.bushing_touches), (SHELL, table.shell_thickness_mm is not None)
        materials |= {part: study.part_material_table(part) for part, there in inner if there}
        expansions = Expansions.of(table, materials)
        return cls(
            table=table,
            bolt=chosen,
            fit_notes=fit_notes(table, radii, materials, expansions),
            expansions=expansions,
            geometry=_geometry(
                table,
                table.split_angle if split is None else split,
                *(bolt.head_diameter, bolt.nut_diameter, bolt.grip, bolt.engaged),
            ),
        )

    def specification(self, study: Study, mesh: MeshedRod) -> AssemblySpecification:
        """How the parts of the meshed rod are put together."""
        table, bolt = self.table, self.bolt.bolt
        return AssemblySpecification(
            normal=self.geometry.normal,
            bolts=mesh.bolts,
            preload=self.bolt.preload,
            stiffness=1 / bolt.compliance,
            beam=bolt.beam,
            friction=table.friction,
            interference={
                Surface.BUSHING_SEAT: (table.bushing_interference_mm or 0.0) / 2,
                Surface.SHELL_SEAT: (table.shell_interference_mm or 0.0) / 2,
            },
            expansion=self._expansion(study, tuple(mesh.parts)),
            parts=tuple(mesh.parts),
        )

    def notes(self, study: Study, parts: tuple[str, ...]) -> tuple[Note, ...]:
        """What a reader must know of the assembly."""
        assumed = list(assumed_materials(study.part_material, parts))
        if self.table.joint_friction is None:
            assumed.append(f"friction {self.table.friction:g} between the parts (assembly.joint_friction)")
        return (*assumptions("assembly", assumed), *self.bolt.notes, *self.expansions.notes, *self.fit_notes)

    def _expansion(self, study: Study, parts: tuple[str, ...]) -> Expansion | None:
        if self.expansions.temperature_change == 0:
            return None
        own = [
            thermal_expansion(f"material.{table_name(part)}", study.part_material_table(part))
            for part in parts
        ]
        of_pins = {pin: study.part_material.get(pin, _PIN_STEEL) for pin in PINS}
        pins = [thermal_expansion(f"material.{pin}", table) for pin, table in of_pins.items()]
        return Expansion(
            rise=self.expansions.temperature_change,
            parts=tuple(alpha for alpha, _ in own),
            bolt=self.expansions.by_part[BOLT],
            piston_pin=pins[0][0],
            crank_pin=pins[1][0],
        )
