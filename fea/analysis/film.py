"""The oil film of the big end's bearing at one speed: how thin, at what pressure and cost, how certain."""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
import numpy.typing as npt

from fea.analysis.figures import FilmFigures
from fea.analysis.prepare import PreparedRod
from fea.base.checks import LIMITS, Check, check
from fea.base.note import Note, doubt, remark, warning
from fea.base.units import BAR, DEG, UM
from fea.film.cycle import HOTTEST, MOST_CYCLES, FilmCycle
from fea.pins.lubrication import COARSE, FINE, MPAS, TOPIC, Lubrication, crank_angles
from geometry.arrays import Floats

_W, _L_MIN = 1e3, 1e6 / 60  # N·mm/s and mm³/s


class Regime(StrEnum):
    """How surfaces are kept apart, by the smallest gap over the roughness λ, and whether the oil suffices.

    Full films have λ > 3, asperities carry most of the load where λ < 1 (Hamrock, Schmid & Jacobson 2004,
    Fundamentals of Fluid Film Lubrication, section 3.8).
    """

    HYDRODYNAMIC = "hydrodynamic"
    MIXED = "mixed"
    METAL = "metal to metal"
    STARVED = "starved"
    OVERHEATED = "overheated"

    @classmethod
    def of(cls, ratio: float) -> "Regime":
        """Judge a ratio λ."""
        return cls.HYDRODYNAMIC if ratio > 3 else cls.MIXED if ratio > 1 else cls.METAL


@dataclass(frozen=True)
class FilmResult:
    """The film at one speed, and a coarser one of the same bearing."""

    cycle: FilmCycle
    coarse: FilmCycle
    lubrication: Lubrication
    displacement: float  #: of the engine's cylinder, mm³

    @property
    def degrees(self) -> Floats:
        """Crank angle (n,) of the steps."""
        return crank_angles(self.cycle.acting.count) / DEG

    @cached_property
    def verdict(self) -> Regime:
        """The regime, or why there is none."""
        if self.cycle.starved:
            return Regime.STARVED
        warm = self.cycle.temperature
        if warm is not None and (warm > HOTTEST - 1 or abs(self.cycle.unbalanced) > LIMITS["film_heat"]):
            return Regime.OVERHEATED
        return Regime.of(self.ratio)

    @property
    def sound(self) -> bool:
        """Whether there is a verdict on the regime."""
        return self.verdict not in (Regime.STARVED, Regime.OVERHEATED)

    @cached_property
    def ratio(self) -> float:
        """Smallest gap over the roughness."""
        asperities = self.lubrication.asperities
        return math.inf if asperities is None else float(self.cycle.thinnest.min()) / asperities.roughness

    @cached_property
    def figures(self) -> FilmFigures:
        """The figures of `summary.json`."""
        cycle, said = self.cycle, self.lubrication
        thinnest, highest = cycle.thinnest.min(), cycle.highest.max()
        grid = cycle.bearing.reynolds.grid
        specific = float(np.hypot(*cycle.acting.load.T).max()) / (2 * grid.radius * grid.width)
        return FilmFigures(
            h_min_um=float(thinnest) / UM,
            h_min_deg=float(self.degrees[cycle.thinnest.argmin()]),
            h_min_error_percent=film_error(float(thinnest), float(self.coarse.thinnest.min())),
            p_max_MPa=float(highest),
            p_max_deg=float(self.degrees[cycle.highest.argmax()]),
            p_max_error_percent=film_error(float(highest), float(self.coarse.highest.max())),
            power_W=cycle.dissipated / _W,
            friction_mep_bar=cycle.dissipated * cycle.acting.period / self.displacement / BAR,
            flow_l_min=cycle.leaked / _L_MIN,
            filled_percent=100 * float(cycle.filled.mean()),
            temperature_C=cycle.temperature,
            viscosity_mPas=cycle.bearing.reynolds.oil.viscosity / MPAS,
            radial_clearance_um=said.clearance / UM,
            lambda_min=self.ratio if said.asperities else None,
            asperity_percent=100 * float(cycle.asperities.max()),
            specific_load_MPa=specific,
            lining_factor=said.lining and said.lining / specific,
            verdict=self.verdict.value,
        )

    @property
    def columns(self) -> dict[str, npt.ArrayLike]:
        """Columns of ``film.csv``."""
        cycle = self.cycle
        x, y = cycle.eccentricity.T
        return {
            "crank_deg": self.degrees,
            "h_min_um": cycle.thinnest / UM,
            "p_max_MPa": cycle.highest,
            "eccentricity_x": x,
            "eccentricity_y": y,
            "power_W": cycle.friction[1] / _W,
            "asperity_percent": 100 * cycle.asperities,
            "filled_percent": 100 * cycle.filled,
        }

    @property
    def checks(self) -> dict[str, Check]:
        """Balances of force, oil, power and heat, and repetition; of a film that fails, the first only."""
        cycle = self.cycle
        grid = cycle.bearing.reynolds.grid
        forces = np.array([grid.resultant(state.pressure) for state in cycle.states])
        values = {
            "film_force": float(np.abs(forces - cycle.acting.load).max() / np.abs(cycle.acting.load).max())
        }
        if self.sound:
            values |= {
                "film_repeats": cycle.unrepeated,
                "film_oil": abs(cycle.supplied / cycle.leaked - 1),
                "film_power": abs(cycle.driven / cycle.dissipated - 1),
                "film_heat": abs(cycle.unbalanced),
            }
        return {name: check(name, value) for name, value in values.items()}

    @property
    def notes(self) -> tuple[Note, ...]:
        """What a reader must know."""
        found, notes = self.figures, [*self.lubrication.notes]
        if self.verdict == Regime.STARVED:
            text = (
                f"starved: the supply cannot keep the film full. Oil fills {found.filled_percent:.0f} % of "
                f"the gap; in the last cycle {self.cycle.supplied / _L_MIN:.2g} l/min came in and "
                f"{found.flow_l_min:.2g} left, and the other figures are of that cycle. Turn the oil hole "
                "away from the load (film.hole_deg), or raise film.inlet_bar"
            )
            notes.append(doubt(text, TOPIC))
        elif self.verdict == Regime.OVERHEATED:
            text = (
                f"overheated: the heat of friction and of the oil do not balance below {HOTTEST:.0f} °C, "
                f"where the model ends; the last cycle was computed at {found.temperature_C:.0f} °C"
            )
            notes.append(doubt(text, TOPIC))
        elif self.verdict == Regime.METAL:
            text = "the film is thinner than the surfaces are rough: they touch, and wear or seize"
            notes.append(doubt(text, TOPIC))
        elif self.verdict == Regime.MIXED:
            text = f"asperities touch; they carry up to {found.asperity_percent:.2g} % of the load"
            notes.append(warning(text, TOPIC))
        if not self.cycle.repeats and self.sound:
            text = (
                f"it does not repeat itself within {MOST_CYCLES} cycles, although oil is supplied as it leaks"
            )
            notes.append(doubt(text, TOPIC))
        if found.temperature_C is not None and self.sound:
            text = (
                f"{100 * self.lubrication.heat:.0f} % of {found.power_W:.0f} W heat {found.flow_l_min:.2g} "
                f"l/min of oil from {self.lubrication.inlet_temperature:.0f} to {found.temperature_C:.0f} "
                f"°C, where it has {found.viscosity_mPas:.2f} mPa·s"
            )
            notes.append(remark(text, TOPIC))
        if found.lining_factor is not None and found.lining_factor < 1:
            text = (
                f"the specific load, {found.specific_load_MPa:.0f} MPa, exceeds what the lining endures, "
                f"{self.lubrication.lining:g} MPa (film.lining_MPa)"
            )
            notes.append(doubt(text, TOPIC))
        return tuple(notes)


def film_at(rod: PreparedRod, rpm: float) -> FilmResult:
    """Film of the big end at a speed, rpm. Raises `InvalidValue`: [film] does not suit it; `FilmError`."""
    cycle = rod.crank_cycle(rpm)
    fine, coarse = rod.films.at(cycle)
    engine = cycle.engine
    return FilmResult(
        fine, coarse, rod.films.lubrication, 2 * engine.crank_radius * math.pi / 4 * engine.bore**2
    )


def film_error(fine: float, coarse: float) -> float:
    """Error of the fine film's figure, percent: of first order, as at the edge of the oil hole."""
    return 100 * abs(fine - coarse) / (FINE[0] / COARSE[0] - 1) / abs(fine)
