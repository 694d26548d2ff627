"""What a study's assembly comes to before it is drawn and solved: bolts, fits, temperature, assumptions."""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.assess.bolt_choice import ChosenBolt, choose_bolt
from fea.assess.bolt_seats import BoltSeats, seats_of
from fea.assess.expansions import ROD, Expansions
from fea.assess.fit_choice import ChosenFit, FitRadii, choose_fits, radii_of
from fea.assess.joint_diagram import thermal_slack
from fea.study.assembly_materials import BOLT, BUSHING, SHELL, assumed_materials, bolt_material
from fea.study.assembly_table import AssemblyTable
from fea.study.material_table import MaterialTable
from fea.study.study import Study
from geometry.rod import Rod


@dataclass(frozen=True)
class AssemblyPlan:
    """An assembly, complete.

    Attributes
    ----------
    bolt
        Each of its bolts.
    fits
        By the inner part: `BUSHING`, `SHELL`.
    friction
        Between the parts.
    warming
        Above the reference temperature, K.
    expansions
        Thermal expansion, 1/K, by part: rod (cap included), bolt, bushing, shell; 0 without warming.
    bolt_slack
        By how much more than the parts in its grip a bolt expands, mm.
    remarks
        What a reader must know.
    """

    bolt: ChosenBolt
    fits: Mapping[str, ChosenFit]
    friction: float
    warming: float
    expansions: Mapping[str, float]
    bolt_slack: float
    remarks: tuple[str, ...]

    @classmethod
    def of(
        cls,
        study: Study,
        table: AssemblyTable,
        seats: BoltSeats,
        radii: Mapping[str, FitRadii],
    ) -> "AssemblyPlan":
        """Complete what a study says of its assembly.

        Parameters
        ----------
        study
            With its materials.
        table
            Its [assembly].
        seats
            Of the bolts.
        radii
            Of the fits, by the inner part.

        Raises
        ------
        InvalidValue
            Parts, bolts or fits do not go together.
        """
        materials = _materials(study, table)
        bolt = choose_bolt(table, seats, study.part_material.get(BOLT), study.material.material())
        expansions = Expansions.of(table, materials)
        fits = choose_fits(table, radii, materials, expansions)
        alpha = expansions.by_part
        slack = thermal_slack(bolt.bolt.grip, alpha[BOLT], alpha[ROD], expansions.warming)
        said = [*_assumed(study, table, materials), *bolt.remarks, *expansions.remarks]
        return cls(
            bolt=bolt,
            fits=fits,
            friction=table.friction,
            warming=expansions.warming,
            expansions=alpha,
            bolt_slack=slack,
            remarks=(*said, *(remark for fit in fits.values() for remark in fit.remarks)),
        )

    @classmethod
    def of_rod(cls, study: Study, table: AssemblyTable, rod: Rod) -> "AssemblyPlan":
        """Complete the assembly of a parametric rod.

        Raises
        ------
        InvalidValue
            See `of`.
        """
        return cls.of(study, table, seats_of(rod), radii_of(rod, table.shell_thickness_mm or 0.0))


def _materials(study: Study, table: AssemblyTable) -> dict[str, MaterialTable]:
    """Tables by part, of those that the assembly has."""
    found = {ROD: study.material, BOLT: bolt_material(study.part_material, table.grade)}
    if table.bushing_touches:
        found[BUSHING] = study.part_material_table(BUSHING)
    if table.shell_thickness_mm is not None:
        found[SHELL] = study.part_material_table(SHELL)
    return found


def _assumed(study: Study, table: AssemblyTable, materials: Mapping[str, MaterialTable]) -> tuple[str, ...]:
    said = list(assumed_materials(study.part_material, tuple(materials)))
    if table.joint_friction is None:
        said.append(f"friction {table.friction:g} between its parts (assembly.joint_friction)")
    return (f"assembly: assumed are {', '.join(said)}",) if said else ()
