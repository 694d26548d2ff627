"""The solid in figures: mass properties, sections along the shank, slenderness, the mesh's agreement."""

from dataclasses import dataclass
from typing import Any

from fea.clock import Clock
from fea.discretise import Discretised, discretise
from fea.solid.inertia import inertia
from fea.study import Study
from fea.units import KG, KG_M2
from geometry.mass import MassProperties
from geometry.section import Section, least_section, sections

# Effective length factors of a rod as a column: pinned in the plane of motion, built in sideways by its pins.
IN_PLANE, SIDEWAYS = 1.0, 0.5
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
        Sections evenly spaced from ring to ring.
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
            "volume_mm3": self.mesh.volume,
            "sections": [_section(section) for section in self.along],
            "least_section": _section(self.least),
            "slenderness": {
                "in_plane": IN_PLANE * length / self.least.gyration_z,
                "sideways": SIDEWAYS * length / self.least.gyration_y,
            },
            "mesh": {
                "nodes": len(self.mesh.whole.mesh.points),
                "elements": len(self.mesh.whole.mesh.tets),
                "size_mm": self.mesh.size,
                "volume_error": self.mesh.volume_error(rod.mass / self.study.material.material().density),
                "least_scaled_jacobian": quality.least_scaled_jacobian,
                "least_shape": quality.least_shape,
                "median_shape": quality.median_shape,
                "worst_at_mm": list(quality.worst_at),
                "straightened_elements": quality.straightened,
            },
        }


def _section(section: Section) -> dict[str, float]:
    return {
        "x_mm": section.x,
        "area_mm2": section.area,
        "inertia_y_mm4": section.inertia_y,
        "inertia_z_mm4": section.inertia_z,
    }


def rod_report(study: Study) -> RodReport:
    """Draw, mesh and measure the rod of a study.

    Raises
    ------
    InvalidValue
        The study's rod has no dimensions.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """
    rod = study.rod.solid()
    mesh = discretise(study, Clock())
    properties = inertia(mesh.cell, study.material.material().density).properties
    return RodReport(study, mesh, properties, sections(rod, _STATIONS), least_section(rod))
