"""The solid in figures: mass properties, sections along the shank, slenderness, agreement of the mesh."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.base.material import of_parts
from fea.base.note import Note, assumption
from fea.judge.column import Plane
from fea.rod.given import found_assembly
from fea.rod.meshed_rod import Bores, MeshedRod
from fea.run.figure_types import Vector
from fea.run.figures import QualityFigures
from fea.run.meshing import mesh_study
from fea.run.summary import quality_figures
from fea.solid.inertia import inertia
from fea.study.rod_table import RodTable, dimension_of
from fea.study.study import Study
from fea.units import KG, KG_M2
from geometry.errors import require
from geometry.fit import Fit, Targets, fit
from geometry.imports import ImportReport
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
class RodBoreFigures:
    """A bore; `at_mm` is its middle as it lies in a file, null for a rod drawn from dimensions."""

    diameter_mm: float
    width_mm: float
    at_mm: Vector | None = None


@dataclass(frozen=True, kw_only=True)
class SolidFigures:
    """A solid of a file: what it is, whether it is analysed, its mass with the rod's density, its extents."""

    name: str
    role: str
    kept: bool
    mass_kg: float
    size_mm: Vector


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
    bores
        Of the big and the small end; for a solid from a file with their places there.
    unit, solids
        Of a solid from a file: the unit of its lengths, and its solids.
    assumed
        What was assumed or left out.
    assembly
        Of a file with a cap of its own: the joint, bolts and interfaces found.
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
    bores: tuple[RodBoreFigures, ...]
    unit: str | None = None
    solids: tuple[SolidFigures, ...] | None = None
    assumed: tuple[Note, ...] = ()
    assembly: tuple[str, ...] = ()


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
        bores=_bores(mesh),
        unit=None if mesh.imported is None else mesh.imported.unit,
        solids=None if mesh.imported is None else _solids(mesh.imported, materials[0].density),
        assumed=(
            *study.material_notes,
            *map(assumption, () if mesh.imported is None else mesh.imported.assumed),
        ),
        assembly=() if mesh.imported is None else found_assembly(study.rod, mesh.imported),
    )
    return report, mesh.whole


def _bores(mesh: MeshedRod) -> tuple[RodBoreFigures, ...]:
    if mesh.imported is not None:
        return tuple(
            RodBoreFigures(diameter_mm=bore.diameter, width_mm=bore.width, at_mm=bore.center)
            for bore in mesh.imported.bores
        )
    bores = mesh.bores
    return (
        RodBoreFigures(diameter_mm=2 * bores.big_radius, width_mm=bores.big_width),
        RodBoreFigures(diameter_mm=2 * bores.small_radius, width_mm=bores.small_width),
    )


def _solids(report: ImportReport, density: float) -> tuple[SolidFigures, ...]:
    return tuple(
        SolidFigures(
            name=one.name,
            role=str(one.role),
            kept=one.kept,
            mass_kg=density * one.volume / KG,
            size_mm=one.size,
        )
        for one in report.solids
    )


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


def fitted(
    study: Study,
    free: Sequence[str],
    mass_kg: float | None,
    center_of_gravity_mm: float | None,
    inertia_kg_m2: float | None,
) -> tuple[RodTable, Fit]:
    """Adjust named dimensions of the study's rod until its mass properties meet the targets.

    Parameters
    ----------
    study
        Gives the rod to start from and the density.
    free
        Keys of the [rod] table that may change.
    mass_kg, center_of_gravity_mm, inertia_kg_m2
        Targets; where all are None, those that the [rod] table gives.

    Returns
    -------
    tuple
        The rod of the study with the dimensions found; mass properties that it gives stay only where they
        are the targets. And how well they are met.

    Raises
    ------
    InvalidValue
        No target, nothing free, a key that is no dimension, or a rod without dimensions.
    """
    rod = study.rod.solid()
    density, *others = (
        part.density for part in study.materials(["rod", "bushing"] if rod.bushing else ["rod"])
    )
    bushing = next(iter(others), None)
    given = study.rod.mass
    if (mass_kg, center_of_gravity_mm, inertia_kg_m2) == (None, None, None):
        remedy = "Say --mass-kg, --center-of-gravity-mm or --inertia-kg-m2, or give them in [rod]."
        require(given is not None, "--fit", list(free), "has no target", remedy)
    own = mass_kg is center_of_gravity_mm is inertia_kg_m2 is None
    if given is not None and own:
        targets = Targets(density, given.mass, given.center[0], given.inertia_z, bushing)
    else:
        targets = Targets(
            density,
            None if mass_kg is None else mass_kg * KG,
            center_of_gravity_mm,
            None if inertia_kg_m2 is None else inertia_kg_m2 * KG_M2,
            bushing,
        )
    found = fit(rod, targets, [dimension_of(key) for key in free])
    table = dataclasses.replace(study.rod, dimensions=found.rod, length=found.rod.length)
    return (table if own else dataclasses.replace(table, mass=None)), found
