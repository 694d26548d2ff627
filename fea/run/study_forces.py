"""The crank forces of a study, without a mesh."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from fea.rod.loading import EngineLoading
from fea.rod.reading import read_isolated
from fea.run.forces import ForceReport, force_reports
from fea.study.engine_table import engine_notes, layout_notes
from fea.study.rod_table import RodTable
from fea.study.study import Study
from geometry.mass import MassProperties, joined

if TYPE_CHECKING:
    from geometry.solid import Solid


def study_forces(study: Study, *, every_cylinder: bool) -> list[ForceReport]:
    """Compute the crank forces at each speed of a study.

    Raises
    ------
    InvalidValue
        The study has no engine, or a value breaks a rule.
    GeometryError
        No solid came out to take the rod's mass from.
    """
    table = study.require_engine()
    if study.rod.length is not None:  # refused before anything is drawn
        EngineLoading.of(table, study.rod.length)
    length, mass = rod_mass(study)
    loading = EngineLoading.of(table, length)
    speeds = study.engine_speeds(table)
    reports = force_reports(loading.engine, mass, loading.gas, speeds, every_cylinder=every_cylinder)
    layout = layout_notes(table) if every_cylinder else []
    return [
        replace(report, notes=(*report.notes, *engine_notes(table, length, report.rpm), *layout))
        for report in reports
    ]


def rod_mass(study: Study) -> tuple[float, MassProperties]:
    """Return the rod's length, mm, and the given mass properties or the CAD kernel's of its solid.

    Raises
    ------
    InvalidValue
        The study's rod has neither masses nor dimensions.
    GeometryError
        No solid came out.
    """
    rod = study.rod
    if rod.mass is not None and rod.length is not None:
        return rod.length, rod.mass
    if rod.mesh is not None:
        return _of_mesh(study)
    solid = drawn_solid(rod)
    materials = study.materials(part.name for part in solid.parts)
    drawn = joined(
        [part.mass.times(material.density) for part, material in zip(solid.parts, materials, strict=True)]
    )
    return solid.bores[1].x, rod.mass or drawn


def _of_mesh(study: Study) -> tuple[float, MassProperties]:
    from fea.run.meshing import mesh_study  # noqa: PLC0415 - other rods need no mesh for their forces
    from fea.solid.inertia import inertia  # noqa: PLC0415

    found = mesh_study(study)
    (material,) = study.materials(found.parts)
    own = inertia(found.cell, material.density).properties
    return found.bores.rod_length, study.rod.mass or own


def drawn_solid(rod: RodTable) -> "Solid":
    """Draw a rod, or read it from its CAD file, in a session of its own.

    Raises
    ------
    InvalidValue, GeometryError
        See `RodTable.draw`.
    """
    return _drawn(rod) if rod.cad is None else read_isolated(partial(_drawn, rod), f"read {rod.cad.path}")


def _drawn(rod: RodTable) -> "Solid":
    from geometry.session import session  # noqa: PLC0415 - gmsh is loaded only where a solid is drawn

    with session():
        return rod.draw()
