"""The job behind `fea loads`: the crank cycle of a study, without a mesh."""

from typing import TYPE_CHECKING

from fea.analysis.force_report import CycleReport, cycle_reports
from fea.machine.forked import apart
from fea.study.study import Study
from geometry.invalid import InvalidValue
from geometry.mass import MassProperties, joined

if TYPE_CHECKING:
    from geometry.solid import Solid


def study_cycles(study: Study, *, every_cylinder: bool) -> list[CycleReport]:
    """Compute the crank cycle at each speed of a study.

    Raises
    ------
    InvalidValue
        The study has no engine, or a value breaks a rule.
    GeometryError
        No solid came out to take the rod's mass from.
    """
    if study.engine is None:
        remedy = "Given forces are for fea run."
        raise InvalidValue("STUDY", study.name, "has no [engine], so there is no crank cycle", remedy)
    if study.rod.length is not None:  # refused before anything is drawn
        study.engine.gas_model(study.engine.engine(study.rod.length))
    length, mass = rod_mass(study)
    engine = study.engine.engine(length)
    gas = study.engine.gas_model(engine)
    return cycle_reports(engine, mass, gas, study.speed.speeds(), every_cylinder=every_cylinder)


def rod_mass(study: Study) -> tuple[float, MassProperties]:
    """Return the rod's length, mm, and the given mass properties or the CAD kernel's of its solid.

    Raises
    ------
    InvalidValue
        The study's rod has neither masses nor dimensions.
    GeometryError
        No solid came out.
    """
    if study.rod.mass is not None and study.rod.length is not None:
        return study.rod.length, study.rod.mass
    solid = (
        _drawn(study)
        if study.rod.step is None
        else apart(lambda: _drawn(study), f"read {study.rod.step.path}")
    )
    materials = study.materials(part.name for part in solid.parts)
    drawn = joined(
        [part.mass.times(material.density) for part, material in zip(solid.parts, materials, strict=True)]
    )
    return solid.bores[1].x, study.rod.mass or drawn


def _drawn(study: Study) -> "Solid":
    from geometry.session import session  # noqa: PLC0415 - gmsh is loaded only where a solid is drawn

    with session():
        return study.rod.draw()
