"""The single overload of a study: the force that compresses the rod, or the liquid that stops the piston."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from fea.base.units import BAR, DEG
from fea.rod.loading import EngineLoading, Loading
from fea.study.overload_table import OverloadTable
from geometry.errors import InvalidValue, require
from geometry.mass import MassProperties
from loads.compression import CLOSING
from loads.gas import HEAT_RATIO_AIR, dead_centres, relative_volume
from loads.hydrolock import BULK, TrappedLiquid

_ML = 1e3  # mm³


@dataclass(frozen=True)
class Overload:
    """A single overload at top dead centre; the engine turns slowly: inertia does not relieve the rod."""

    kind: str  #: ``knock``, ``liquid`` or ``force``
    force: float  #: that compresses the rod, N; of liquid not known before the rod gives way
    pressure: float | None = None  #: absolute, over the piston, MPa, of knock
    liquid: TrappedLiquid | None = None
    energy: float = np.inf  #: of crank and flywheel, N·mm

    def on_elastic_rod(self, flexibility: float) -> float:
        """Force, N, on a rod that gives way elastically, by its flexibility, mm/N.

        It is less where the energy is used up before the piston of trapped liquid reaches the top.
        """
        if (liquid := self.liquid) is None:
            return self.force

        def room(force: float) -> float:
            return liquid.shortening(force) - force * flexibility

        def beyond_energy(force: float) -> float:
            return liquid.work(force) + flexibility * force**2 / 2 - self.energy

        most = float(brentq(room, 0.0, 10 * BULK * liquid.piston_area))  # no liquid bears as much
        return most if beyond_energy(most) <= 0 else float(brentq(beyond_energy, 0.0, most))

    @classmethod
    def of(
        cls, table: OverloadTable, loading: Loading, rod: MassProperties, speeds: Iterable[float]
    ) -> "Overload":
        """Read the overload of a table that has one, of an engine that runs at `speeds`, rpm.

        Raises `InvalidValue`: knock below the peak pressure, more liquid than the cylinder holds, no engine
        or no compression ratio.
        """
        name = f"overload.{table.load}"
        if table.force_N is not None:
            return cls("force", table.force_N)
        if not isinstance(loading, EngineLoading):
            rule, remedy = "presses on a piston, which [forces] do not have", "Give overload.force_N."
            raise InvalidValue(name, getattr(table, table.load), rule, remedy)
        if table.liquid_ml is not None:
            energy = np.inf if table.energy_J is None else table.energy_J * 1e3
            return cls("liquid", np.nan, liquid=_trapped(name, table.liquid_ml, loading), energy=energy)
        bar, area = table.needed("knock_bar"), loading.engine.piston_area
        atmosphere = loading.table.atmosphere
        cycles = [loading.crank_cycle(rod, rpm) for rpm in speeds]
        peak = max((float(np.max(cycle.degrees.gas)) for cycle in cycles), default=0.0) / area + atmosphere
        rule = f"must exceed the peak pressure of the engine, {peak / BAR:.4g} bar absolute, which it raises"
        require(bar * BAR > peak, name, bar, rule, "Give the peak of the knocking cycle, absolute.")
        return cls("knock", (bar * BAR - atmosphere) * area, pressure=bar * BAR)


def _trapped(name: str, amount: float, loading: EngineLoading) -> TrappedLiquid:
    engine, table = loading.engine, loading.table
    ratio = table.needed("compression_ratio", f"is missing: {name} needs it", "Give it in [engine].")
    require(ratio > 1, "engine.compression_ratio", ratio, "must be above 1")
    chamber = engine.piston_area * engine.stroke / (ratio - 1)
    top, bottom = dead_centres(engine)
    two_stroke = engine.strokes == 2
    shut = top + (-table.port if two_stroke else CLOSING) * DEG
    holds = chamber * float(relative_volume(engine, ratio, np.array(shut)))
    rule = f"is more than the cylinder holds when the intake shuts, {holds / _ML:.4g} ml"
    require(amount * _ML < holds, name, amount, rule, "Give what is in one cylinder then.")
    closed = chamber * float(relative_volume(engine, ratio, np.array(shut if two_stroke else bottom)))
    return TrappedLiquid(
        liquid=amount * _ML,
        closed=closed,
        chamber=chamber,
        piston_area=engine.piston_area,
        intake=table.intake * (table.gas_scale or 1.0),
        crankcase=table.atmosphere,
        exponent=HEAT_RATIO_AIR if table.heat_ratio is None else table.heat_ratio,
    )
