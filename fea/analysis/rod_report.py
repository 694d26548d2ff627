"""The solid in figures: mass properties, sections along the shank, slenderness, the mesh's agreement."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fea.assess.column import Plane
from fea.machine.clock import Clock
from fea.material import of_parts
from fea.rod.discretise import Discretised, discretise
from fea.solid.inertia import inertia
from fea.study.study import Study
from fea.units import KG, KG_M2
from geometry.mass import MassProperties
from geometry.section import Section, least_section, sections
from mesh import slices

_STATIONS = 11


@dataclass(frozen=True)
class RodReport:
    """A rod's figures.

    Attributes
    ----------
    study
        What was asked.
    mesh
        The meshed rod.
    properties
        From the mesh's quadrature.
    along
        Sections evenly spaced from ring to ring; of a solid from a file from bore to bore, cut from its mesh.
    least
        The section of least area.
    """

    study: Study
    mesh: Discretised
    properties: MassProperties
    along: tuple[Section, ...]
    least: Section

    def figures(self) -> dict[str, Any]:
        """The figures in the units their names say."""
        rod, quality = self.properties, self.mesh.quality
        length = self.mesh.bores.rod_length
        return {
            "study": self.study.name,
            "length_mm": length,
            "mass_kg": rod.mass / KG,
            "center_of_gravity_mm": list(rod.center),
            "inertia_kg_m2": [[value / KG_M2 for value in row] for row in rod.inertia],
            "volume_mm3": sum(self.mesh.parts.values()),
            "parts_mm3": dict(self.mesh.parts),
            "symmetry": self.mesh.symmetry.value,
            "sections": [_section(section) for section in self.along],
            "least_section": _section(self.least),
            "slenderness": _slenderness(self.least, length),
            "mesh": {
                "nodes": len(self.mesh.whole.mesh.points),
                "elements": len(self.mesh.whole.mesh.tets),
                "size_mm": self.mesh.size,
                "mass_error": self.mesh.mass_error(rod.mass, self.study.materials(self.mesh.parts)),
                "least_scaled_jacobian": quality.least_scaled_jacobian,
                "least_shape": quality.least_shape,
                "median_shape": quality.median_shape,
                "worst_at_mm": list(quality.worst_at),
                "straightened_elements": quality.straightened,
                "repairs": list(self.mesh.repair.causes),
                "repaired_size_mm": self.mesh.repair.size,
            },
        }


def _section(section: Section) -> dict[str, float]:
    return {
        "x_mm": section.x,
        "area_mm2": section.area,
        "inertia_y_mm4": section.inertia_y,
        "inertia_z_mm4": section.inertia_z,
    }


def _slenderness(section: Section, length: float) -> dict[str, float]:
    return {plane.value: plane.length_factor * length / plane.gyration(section) for plane in Plane}


def rod_report(study: Study) -> RodReport:
    """Draw, mesh and measure the rod of a study.

    Raises
    ------
    InvalidValue
        The study's rod has no dimensions.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """
    mesh = discretise(study, Clock())
    materials, part = study.materials(mesh.parts), mesh.cell.part
    density = of_parts(materials, part).density
    properties = inertia(mesh.cell, density).properties
    return RodReport(study, mesh, properties, *_sections(study, mesh))


def _sections(study: Study, mesh: Discretised) -> tuple[tuple[Section, ...], Section]:
    """Sections along the shank, and the least."""
    if study.rod.rod is not None:
        return sections(study.rod.rod, _STATIONS), least_section(study.rod.rod)
    whole, ends = mesh.whole.mesh, mesh.bores.between
    return slices.sections(whole, np.linspace(*ends, _STATIONS + 2)[1:-1]), slices.least_section(whole, *ends)
