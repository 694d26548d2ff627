"""The load cases of a study at one speed, and those that are left out."""

from dataclasses import dataclass

from fea.rod.omission import Omission
from fea.study.study import Study
from fea.units import RPM
from geometry.invalid import InvalidValue
from geometry.mass import MassProperties
from loads.cases import LoadCase, given
from loads.engine import Engine
from loads.gas import GasModel
from loads.peaks import peak_cases


@dataclass(frozen=True)
class SpeedLoads:
    """The load cases of one speed.

    Attributes
    ----------
    cases
        The load cases to solve.
    left_out
        Load cases and effects that are left out, and why.
    notes
        Assumptions of the gas model.
    """

    cases: tuple[LoadCase, ...]
    left_out: tuple[Omission, ...]
    notes: tuple[str, ...]


def speed_loads(
    study: Study, engine: Engine | None, gas: GasModel | None, rod: MassProperties, rpm: float | None
) -> SpeedLoads:
    """Find the peak load cases of a cycle, or return the case of given forces.

    Parameters
    ----------
    study
        The study.
    engine, gas
        None if forces are given.
    rod
        Mass properties of the meshed rod.
    rpm
        The speed; None for given forces.

    Raises
    ------
    InvalidValue
        Nothing loads the rod.
    """
    if study.forces is not None:
        reason = "forces are given"
        spared = (Omission("dynamics", reason), Omission("inertia of the rod", reason))
        return SpeedLoads((given(*study.forces.pin()),), spared, ())
    if engine is None or gas is None or rpm is None:
        raise InvalidValue("study", study.name, "has neither [engine] nor [forces]", "Add one of them.")
    peaks = peak_cases(engine, rod, gas, rpm * RPM)
    if not peaks.cases:
        rule = "applies no load to the rod, because the engine has no gas pressure"
        remedy = "Use a speed above 0, or choose a gas model in [engine]."
        raise InvalidValue("speed.rpm", rpm, rule, remedy)
    omitted = tuple(Omission(f"case {name}", why) for name, why in peaks.left_out)
    if rpm == 0:
        omitted += (Omission("inertia of the rod", "the engine stands still"),)
    note = gas.note(rpm * RPM)
    return SpeedLoads(peaks.cases, omitted, (note,) if note else ())
