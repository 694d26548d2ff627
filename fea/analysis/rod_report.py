"""The solid in figures: mass properties, sections along the shank, slenderness, agreement of the mesh."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from fea.analysis.figures import Figures, QualityFigures, figures
from fea.analysis.meshing import mesh_study
from fea.analysis.summary import quality_figures
from fea.base.material import of_parts
from fea.base.note import Note
from fea.base.units import KG, KG_M2
from fea.judge.column import Plane
from fea.rod.given import found_assembly
from fea.rod.meshed_rod import Bores, file_notes
from fea.solid.inertia import inertia
from fea.study.rod_table import MASS_KEYS, RodTable, dimension_of
from fea.study.study import Study
from fea.study.tables import number_of
from geometry.arrays import Vector
from geometry.errors import require
from geometry.fit import Fit, Targets, fit
from geometry.rod import Rod
from geometry.section import CrossSection, least_section, sections
from mesh import slices
from mesh.tetmesh import TetMesh

_STATIONS = 11


class SectionFigures(Figures):
    """A cross-section of the shank."""

    x_mm: float
    area_mm2: float
    inertia_y_mm4: float
    inertia_z_mm4: float


class RodMeshFigures(QualityFigures):
    """The mesh of a rod; `mass_error` is relative to the solid's mass."""

    nodes: int
    elements: int
    size_mm: float
    mass_error: float


class RodBoreFigures(Figures):
    """A bore; `at_mm` is its middle as it lies in a file, null for a rod drawn from dimensions."""

    diameter_mm: float
    width_mm: float
    at_mm: Vector | None = None


class SolidFigures(Figures):
    """A solid of a file: what it is, whether it is analysed, its mass with the rod's density, its extents."""

    name: str
    role: str
    kept: bool
    mass_kg: float
    size_mm: Vector


class RodReport(Figures):
    """The figures of ``fea rod``."""

    study: str
    length_mm: float
    mass_kg: float
    center_of_gravity_mm: Vector
    inertia_kg_m2: tuple[tuple[float, ...], ...]  #: (3, 3) about the centre of gravity
    volume_mm3: float
    parts_mm3: Mapping[str, float]  #: volume of each part
    symmetry: str
    #: Evenly spaced from ring to ring; of a solid from a file from bore to bore, cut from its mesh
    sections: tuple[SectionFigures, ...]
    least_section: SectionFigures  #: of least area
    slenderness: Mapping[str, float]  #: K l / r for bending in each plane
    mesh: RodMeshFigures
    bores: tuple[RodBoreFigures, ...]  #: of the big and the small end
    unit: str | None = None  #: of the lengths in a file
    solids: tuple[SolidFigures, ...] | None = None  #: of a file
    assumed: tuple[Note, ...] = ()
    assembly: tuple[str, ...] = ()  #: joint, bolts and interfaces found in a file with a separate cap


def rod_report(study: Study) -> tuple[RodReport, TetMesh]:
    """Draw, mesh and measure the rod of a study; return its figures and the mesh of the whole rod.

    Raises `InvalidValue`: it has no dimensions; `GeometryError`, `MeshError`: no solid or no usable mesh came
    out.
    """
    mesh = mesh_study(study)
    materials = study.materials(mesh.parts)
    rod = inertia(mesh.cell, of_parts(materials, mesh.cell.part).density).properties
    along, least = _sections(study.rod.dimensions, mesh.whole, mesh.bores)
    quality, length = quality_figures(mesh.meshing.quality, mesh.meshing.repair), mesh.bores.rod_length
    report = RodReport(
        study=study.name,
        length_mm=length,
        mass_kg=rod.mass / KG,
        center_of_gravity_mm=rod.center,
        inertia_kg_m2=tuple(tuple(value / KG_M2 for value in row) for row in rod.inertia),
        volume_mm3=sum(mesh.parts.values()),
        parts_mm3=dict(mesh.parts),
        symmetry=mesh.symmetry.value,
        sections=tuple(figures(SectionFigures, section) for section in along),
        least_section=figures(SectionFigures, least),
        slenderness={plane.value: plane.length_factor * length / plane.gyration(least) for plane in Plane},
        mesh=RodMeshFigures(
            **vars(quality),
            nodes=len(mesh.whole.points),
            elements=len(mesh.whole.tets),
            size_mm=mesh.meshing.size,
            mass_error=mesh.mass_error(rod.mass, materials),
        ),
        bores=tuple(
            RodBoreFigures(diameter_mm=2 * radius, width_mm=width)
            for radius, width in (
                (mesh.bores.big_radius, mesh.bores.big_width),
                (mesh.bores.small_radius, mesh.bores.small_width),
            )
        ),
        assumed=(*study.unusual_notes(mesh.bores.lengths), *study.material_notes),
    )
    if (read := mesh.imported) is not None:
        density = materials[0].density
        report = dataclasses.replace(
            report,
            bores=tuple(figures(RodBoreFigures, bore, at_mm=bore.center) for bore in read.bores),
            unit=read.unit,
            solids=tuple(
                figures(SolidFigures, solid, mass_kg=density * solid.volume / KG) for solid in read.solids
            ),
            assumed=(*report.assumed, *file_notes(read)),
            assembly=found_assembly(study.rod, read),
        )
    return report, mesh.whole


def _sections(rod: Rod | None, whole: TetMesh, bores: Bores) -> tuple[tuple[CrossSection, ...], CrossSection]:
    if rod is not None:
        return sections(rod, _STATIONS), least_section(rod)
    ends = bores.between
    return slices.sections(whole, np.linspace(*ends, _STATIONS + 2)[1:-1]), slices.least_section(whole, *ends)


def fitted(
    study: Study,
    free: Sequence[str],
    mass_kg: float | str | None,
    center_of_gravity_mm: float | str | None,
    inertia_kg_m2: float | str | None,
) -> tuple[RodTable, Fit]:
    """Adjust named dimensions of the study's rod until its mass properties meet the targets.

    The keys in `free` may change; without any target those that the [rod] table gives are met, which keeps
    them only then. Returned are the table with the new dimensions, and how well the targets are met. Raises
    `InvalidValue`: no target, nothing free, a key that is no dimension, or a rod without dimensions.
    """
    rod = study.rod.solid()
    parts = ["rod", "bushing"] if rod.bushing else ["rod"]
    density, *others = (part.density for part in study.materials(parts))
    bushing = next(iter(others), None)
    given = study.rod.mass
    asked = dict(zip(MASS_KEYS, (mass_kg, center_of_gravity_mm, inertia_kg_m2), strict=True))
    as_given = set(asked.values()) == {None}
    if as_given:
        remedy = "Give --mass-kg, --center-of-gravity-mm or --inertia-kg-m2, or set them in [rod]."
        require(given is not None, "--fit", list(free), "has no target", remedy)
    if given is not None and as_given:
        targets = Targets(density, given.mass, given.center[0], given.inertia_z, bushing)
    else:
        sought = (number_of(f"--{name.replace('_', '-')}", value, name) for name, value in asked.items())
        in_units = zip(sought, (KG, 1.0, KG_M2), strict=True)
        mass, center, inertia_z = (None if value is None else value * unit for value, unit in in_units)
        targets = Targets(density, mass, center, inertia_z, bushing)
    fitted_rod = fit(rod, targets, [dimension_of(key) for key in free])
    table = dataclasses.replace(study.rod, dimensions=fitted_rod.rod, length=fitted_rod.rod.length)
    return (table if as_given else dataclasses.replace(table, mass=None)), fitted_rod
