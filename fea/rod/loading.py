"""What loads the rod, and its load cases at one speed."""

from dataclasses import dataclass, field, replace

from fea.base.note import TRACE, Note, assumption, doubt, omission, warning
from fea.base.units import BAR, RPM
from fea.study.duty_log import LogColumn
from fea.study.engine_table import EngineTable, engine_notes
from fea.study.speed_tables import DutyTable
from geometry.errors import InvalidValue, require
from geometry.mass import MassProperties
from loads.crank_cycle import CrankCycle
from loads.engine import Engine
from loads.gas import GasModel, scaled
from loads.instants import Instants, given, joined
from loads.trace import absorbed

# Crank cycles that stay in memory, at a tenth of a megabyte each.
_MOST_CYCLES = 100


@dataclass(frozen=True)
class SpeedLoads:
    """The load cases of one speed."""

    cases: Instants  #: those that are solved
    #: Of the gas model and of an engine of the library; and the cases that do not occur
    notes: tuple[Note, ...]


@dataclass(frozen=True)
class EngineLoading:
    """An engine and its gas load the rod."""

    #: engine, gas: in coherent units
    engine: Engine
    gas: GasModel
    table: EngineTable  #: what the study says of them
    _cycles: dict[tuple[int, float], CrankCycle] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    @classmethod
    def of(cls, table: EngineTable, rod_length: float) -> "EngineLoading":
        """Read a study's engine, for a rod of `length`, mm. Raises `InvalidValue`: a value breaks a rule."""
        engine = table.engine(rod_length)
        return cls(engine, table.gas_model(engine), table)

    def with_gas(self, gas: str) -> "EngineLoading":
        """Return the engine with another gas, as in [engine]. Raises as `EngineTable.gas_model`."""
        table = self.table.with_gas(gas)
        return EngineLoading(self.engine, table.gas_model(self.engine), table)

    def at(self, rod: MassProperties, rpm: float | None) -> SpeedLoads:
        """Find the peak cases of the cycle. Raises `InvalidValue`: nothing loads the rod, or no speed."""
        if rpm is None:
            raise InvalidValue("speed.rpm", None, "is missing: an engine needs a speed", "Give one.")
        peaks = self.crank_cycle(rod, rpm).peaks
        if not len(peaks.cases):
            rule, remedy = "applies no load to the rod", "Choose a speed above 0, or an engine with gas."
            raise InvalidValue("speed.rpm", rpm, rule, remedy)
        omitted = tuple(omission(f"case {name}", why) for name, why in peaks.left_out)
        if rpm == 0:
            omitted += (omission("inertia of the rod", "the engine stands still"),)
        return SpeedLoads(peaks.cases, (*self.notes(rod, rpm), *omitted))

    def notes(self, rod: MassProperties, rpm: float) -> tuple[Note, ...]:
        """Return what a user must know about the engine and its gas at a speed."""
        torque = self.crank_cycle(rod, rpm).degrees.torque
        absorbs = absorbed(self.gas, torque, self.table.brake_torque(rpm))
        of_engine = engine_notes(self.table, self.engine.rod_length, rpm)
        doubts = (doubt(text, TRACE) for text in (*self.gas.doubts, absorbs) if text)
        of_speed = self.gas.note(rpm * RPM)
        return (
            *doubts,
            *(assumption(text, "gas") for text in self.gas.remarks),
            *([warning(of_speed)] if of_speed else []),
            *of_engine,
        )

    def crank_cycle(self, rod: MassProperties, rpm: float) -> CrankCycle:
        """Return the crank cycle at a speed, rpm."""
        return self.cycle_at(rod, rpm * RPM)

    def cycle_at(self, rod: MassProperties, speed: float) -> CrankCycle:
        """Return the crank cycle at a speed, rad/s: the same object each time, with what it has computed."""
        found = self._cycles.get((id(rod), speed))
        if found is None or found.rod is not rod:  # an id may have been another rod's, in another process too
            if len(self._cycles) >= _MOST_CYCLES:
                self._cycles.clear()
            found = self._cycles[id(rod), speed] = CrankCycle(self.engine, rod, self.gas, speed)
        return found


UPPER, LOWER = "upper", "lower"  # load cases of a fatigue test


@dataclass(frozen=True)
class GivenForces:
    """A given pin force loads the rod, which is at rest."""

    pin: tuple[float, float]  #: axial and transverse force on the piston-pin bore, N, tension positive
    levels: tuple[float, float] | None = None  #: in place of it, largest and least axial force of a test, N

    def at(self, _rod: MassProperties, _rpm: float | None) -> SpeedLoads:
        """Return the load case there is, or those of a fatigue test, of which one may be without force."""
        reason = "forces are given"
        spared = (omission("dynamics", reason), omission("inertia of the rod", reason))
        if self.levels is None:
            return SpeedLoads(given(*self.pin)[None], spared)
        named = zip((UPPER, LOWER), self.levels, strict=True)
        return SpeedLoads(joined([given(force).named(name) for name, force in named if force]), spared)


Loading = EngineLoading | GivenForces


CLOSED_THROTTLE = 0.3  # bar, absolute, in the intake behind it


@dataclass(frozen=True)
class DutyLoads:
    """A duty and its loads."""

    table: DutyTable  #: what the study says
    loadings: tuple[EngineLoading, ...]  #: the engine with the gas of every entry

    @classmethod
    def of(cls, table: DutyTable, loading: EngineLoading) -> "DutyLoads":
        """Read the gas of every entry, else the engine's. Raises `InvalidValue`: a missing key or file."""
        entries = table.entries
        if (log := table.read) is not None:
            charges = [charge(log.kind, entry.load, loading) for entry in entries]
            return cls(table, tuple(replace(loading, gas=scaled(loading.gas, each)) for each in charges))
        of_gas = {gas: loading if gas is None else loading.with_gas(gas) for gas in table.gas or (None,)}
        return cls(table, tuple(of_gas[entry.gas] for entry in entries))


def charge(kind: LogColumn | None, load: float | None, engine: EngineLoading) -> float:
    """Return the charge at a load of a log, over the study's: in proportion to it, above a closed throttle.

    Raises `InvalidValue`: boost beside a trace whose own is not known.
    """
    if kind is None or load is None:
        return 1.0
    table, traced = engine.table, engine.gas.samples.size > 0
    closed = min(CLOSED_THROTTLE * BAR / table.intake, 1.0)
    known = not traced or table.boost_bar is not None or table.intake_pressure_bar is not None
    rule, remedy = "gives boost, but that of the pressure trace is not known", "Give engine.boost_bar."
    require(known or kind is not LogColumn.BOOST, "duty.log", f"boost {load:g} bar", rule, remedy)
    part = {
        LogColumn.LOAD: load / 100,
        LogColumn.BOOST: (table.atmosphere + load * BAR) / table.intake,
        LogColumn.THROTTLE: closed + (1 - closed) * load / 100,
    }[kind]
    return float(f"{max(part, closed):.4g}")
