"""From [assembly] of a study to what is drawn, and to how the parts are put together."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fea.analysis.file_assembly import (
    asked_of_file,
    found_in_file,
    joint_angle,
    radii_in_file,
    seats_in_file,
)
from fea.assess.bolt_choice import ChosenBolt, choose_bolt
from fea.assess.bolt_seats import seats_of
from fea.assess.expansions import ROD, Expansions
from fea.assess.fit_choice import ChosenFit, choose_fits, radii_of
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_materials import (
    BOLT,
    BUSHING,
    SHELL,
    assumed_materials,
    bolt_material,
    table_name,
)
from fea.study.assembly_table import AssemblyTable
from fea.study.contact_table import PINS
from fea.study.expansion import thermal_expansion
from fea.study.material_table import MaterialTable
from fea.study.study import Study
from geometry.assembly import Assembly, BoltSeat
from geometry.surfaces import Surface

if TYPE_CHECKING:
    from fea.contact.assembled_rod import Expansion, Putting

# Of pins whose material is not given.
_PIN_STEEL = MaterialTable(E_GPa=206.0, nu=0.3, density_kg_m3=7850.0, yield_MPa=400.0)


def drawn_assembly(study: Study) -> Assembly | None:
    """What is separate in the rod of a study; None for a rod of one piece.

    Raises
    ------
    InvalidValue
        Bolts and rod do not go together.
    """
    if study.assembly is not None and study.rod.cad is not None:
        return asked_of_file(study.assembly)
    found = Assembling.of(study)
    return None if found is None else found.geometry


@dataclass(frozen=True, kw_only=True)
class Assembling:
    """The assembly of a study.

    Attributes
    ----------
    table
        [assembly].
    bolt
        Each of the cap's bolts.
    geometry
        What is separate.
    fits
        Press fits by the inner part, as Lamé estimates them.
    expansions
        Of the parts, at the assembly's temperature.
    """

    table: AssemblyTable
    bolt: ChosenBolt
    geometry: Assembly
    fits: Mapping[str, ChosenFit]
    expansions: Expansions

    @classmethod
    def of(cls, study: Study, mesh: MeshedRod | None = None) -> "Assembling | None":
        """Complete what a study says of its parts and bolts; None for a rod of one piece.

        Parameters
        ----------
        study
            What is asked.
        mesh
            Of a rod from a file, which tells where the bolts are; not needed for one given by dimensions.

        Raises
        ------
        InvalidValue
            Bolts and rod do not go together.
        """
        table, rod, split = study.assembly, study.rod.dimensions, None
        if table is None:
            return None
        if rod is not None:
            seats, radii = seats_of(rod), radii_of(rod, table.shell_thickness_mm or 0.0)
        elif mesh is not None and mesh.bolts:
            first = mesh.bolts[0]
            seats, split = seats_in_file(first, mesh.bores), joint_angle(first)
            table, radii = found_in_file(table, first), radii_in_file(mesh)
        else:
            return None
        chosen = choose_bolt(table, seats, study.part_material.get(BOLT), study.material.material())
        bolt = chosen.bolt
        materials = _materials(study, table)
        expansions = Expansions.of(table, materials)
        return cls(
            table=table,
            bolt=chosen,
            fits=choose_fits(table, radii, materials, expansions),
            expansions=expansions,
            geometry=Assembly(
                split=table.split_angle if split is None else split,
                bushing=table.bushing_touches,
                shell=table.shell_thickness_mm or 0.0,
                bolt=BoltSeat(
                    head_diameter=bolt.head_diameter,
                    nut_diameter=bolt.nut_diameter,
                    grip=bolt.grip,
                    engaged=bolt.engaged,
                ),
            ),
        )

    def putting(self, study: Study, mesh: MeshedRod) -> "Putting":
        """How the parts of the meshed rod are put together."""
        from fea.contact.assembled_rod import Putting  # noqa: PLC0415 - rods of one piece do without

        table, bolt = self.table, self.bolt.bolt
        return Putting(
            normal=self.geometry.normal,
            bolts=mesh.bolts,
            preload=bolt.preload,
            stiffness=bolt.stiffness,
            friction=table.friction,
            interference={
                Surface.BUSHING_SEAT: (table.bushing_interference_mm or 0.0) / 2,
                Surface.SHELL_SEAT: (table.shell_interference_mm or 0.0) / 2,
            },
            expansion=self._expansion(study, tuple(mesh.parts)),
            parts=tuple(mesh.parts),
        )

    def remarks(self, study: Study, parts: tuple[str, ...]) -> tuple[str, ...]:
        """What a reader must know of the assembly."""
        assumed = list(assumed_materials(study.part_material, parts))
        if self.table.joint_friction is None:
            assumed.append(f"friction {self.table.friction:g} between the parts (assembly.joint_friction)")
        said = [f"assembly: assumed are {', '.join(assumed)}"] if assumed else []
        fits = (remark for fit in self.fits.values() for remark in fit.remarks)
        return (*said, *self.bolt.remarks, *self.expansions.remarks, *fits)

    def _expansion(self, study: Study, parts: tuple[str, ...]) -> "Expansion | None":
        from fea.contact.assembled_rod import Expansion  # noqa: PLC0415 - see above

        if self.expansions.warming == 0:
            return None
        own = [
            thermal_expansion(f"material.{table_name(part)}", study.part_material_table(part))
            for part in parts
        ]
        pins = [
            thermal_expansion(f"material.{pin}", study.part_material.get(pin, _PIN_STEEL)) for pin in PINS
        ]
        return Expansion(
            rise=self.expansions.warming,
            parts=tuple(alpha for alpha, _ in own),
            bolt=self.expansions.by_part[BOLT],
            piston_pin=pins[0][0],
            crank_pin=pins[1][0],
        )


def _materials(study: Study, table: AssemblyTable) -> dict[str, MaterialTable]:
    """Tables of rod, bolts and what is fitted into the rod, by part."""
    found = {ROD: study.part_material_table(ROD), BOLT: bolt_material(study.part_material, table.grade)}
    if table.bushing_touches:
        found[BUSHING] = study.part_material_table(BUSHING)
    if table.shell_thickness_mm is not None:
        found[SHELL] = study.part_material_table(SHELL)
    return found
