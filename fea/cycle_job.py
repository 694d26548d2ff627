"""The job behind `fea loads`: the crank cycle of a study, without a mesh."""

from fea.cycle_report import CycleReport, cycle_reports
from fea.study import Study
from geometry.invalid import InvalidValue
from geometry.mass import MassProperties


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
    engine = study.engine.engine(study.rod.length)
    gas = study.engine.gas_model(engine)
    return cycle_reports(engine, rod_mass(study), gas, study.speed.speeds(), every_cylinder=every_cylinder)


def rod_mass(study: Study) -> MassProperties:
    """Return the given mass properties, or the CAD kernel's of the rod's solid.

    Raises
    ------
    InvalidValue
        The study's rod has neither masses nor dimensions.
    GeometryError
        No solid came out.
    """
    if study.rod.mass is not None:
        return study.rod.mass
    from geometry.mirror import Mirror  # noqa: PLC0415 - gmsh is loaded only where a solid is drawn
    from geometry.session import session  # noqa: PLC0415
    from geometry.solid import build  # noqa: PLC0415

    with session():
        solid = build(study.rod.solid(), Mirror.QUARTER)
    return solid.mass.times(study.material.material().density)
