"""The solid in figures: mass properties, sections along the shank, slenderness, agreement of the mesh."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fea.analysis.figures import QualityFigures, Vector
from fea.analysis.meshing import mesh_study
from fea.analysis.summary import quality_figures
from fea.assess.column import Plane
from fea.material import of_parts
from fea.rod.bores import Bores
from fea.solid.inertia import inertia
from fea.study.study import Study
from fea.units import KG, KG_M2
from geometry.rod import Rod
from geometry.section import Section, least_section, sections
from mesh import slices
from mesh.tetmesh import TetMesh

_STATIONS = 11


@dataclass(frozen=True, kw_only=True)
class SectionFigures:
    """A cross-section of the shank."""

    x_mm: float
    area_mm2: float
    inertia_y_mm4: float
    inertia_z_mm4: float


@dataclass(frozen=True, kw_only=True)
class RodMeshFigures(QualityFigures):
    """The mesh of a rod; `mass_error` is relative to the solid's mass."""

    nodes: int
    elements: int
    size_mm: float
    mass_error: float


@dataclass(frozen=True, kw_only=True)
class RodReport:
    """The figures of ``fea rod``.

    Attributes
    ----------
    inertia_kg_m2
        (3, 3) about the centre of gravity.
    parts_mm3
        Volume of each part.
    sections
        Evenly spaced from ring to ring; of a solid from a file from bore to bore, cut from its mesh.
    least_section
        The section of least area.
    slenderness
        K l / r for bending in each plane.
    """

    study: str
    length_mm: float
    mass_kg: float
    center_of_gravity_mm: Vector
    inertia_kg_m2: tuple[tuple[float, ...], ...]
    volume_mm3: float
    parts_mm3: Mapping[str, float]
    symmetry: str
    sections: tuple[SectionFigures, ...]
    least_section: SectionFigures
    slenderness: Mapping[str, float]
    mesh: RodMeshFigures


def rod_report(study: Study) -> tuple[RodReport, TetMesh]:
    """Draw, mesh and measure the rod of a study; return its figures and the mesh of the whole rod.

    Raises
    ------
    InvalidValue
        The study's rod has no dimensions.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """
    mesh = mesh_study(study)
    materials = study.materials(mesh.parts)
    rod = inertia(mesh.cell, of_parts(materials, mesh.cell.part).density).properties
    along, least = _sections(study.rod.dimensions, mesh.whole, mesh.bores)
    quality = quality_figures(mesh.meshing.quality, mesh.meshing.repair)
    report = RodReport(
        study=study.name,
        length_mm=mesh.bores.rod_length,
        mass_kg=rod.mass / KG,
        center_of_gravity_mm=rod.center,
        inertia_kg_m2=tuple(tuple(value / KG_M2 for value in row) for row in rod.inertia),
        volume_mm3=sum(mesh.parts.values()),
        parts_mm3=dict(mesh.parts),
        symmetry=mesh.symmetry.value,
        sections=tuple(_section(section) for section in along),
        least_section=_section(least),
        slenderness={
            plane.value: plane.length_factor * mesh.bores.rod_length / plane.gyration(least)
            for plane in Plane
        },
        mesh=RodMeshFigures(
            **vars(quality),
            nodes=len(mesh.whole.points),
            elements=len(mesh.whole.tets),
            size_mm=mesh.meshing.size,
            mass_error=mesh.mass_error(rod.mass, materials),
        ),
    )
    return report, mesh.whole


def _section(section: Section) -> SectionFigures:
    return SectionFigures(
        x_mm=section.x,
        area_mm2=section.area,
        inertia_y_mm4=section.inertia_y,
        inertia_z_mm4=section.inertia_z,
    )


def _sections(rod: Rod | None, whole: TetMesh, bores: Bores) -> tuple[tuple[Section, ...], Section]:
    """Sections along the shank, and the smallest."""
    if rod is not None:
        return sections(rod, _STATIONS), least_section(rod)
    ends = bores.between
    return slices.sections(whole, np.linspace(*ends, _STATIONS + 2)[1:-1]), slices.least_section(whole, *ends)
