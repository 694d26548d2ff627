"""The oil film of the big end's bearing at one speed: how thin, at what pressure and cost, how certain."""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from fea.analysis.figures import FilmFigures
from fea.analysis.prepare import PreparedRod
from fea.base.checks import Check, check
from fea.base.note import Note, assumption, assumptions, doubt, warning
from fea.base.units import BAR, DEG, UM
from fea.film.cycle import FilmCycle, JournalLoads, integrate
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing
from fea.film.oil import Oil
from fea.film.reynolds import Reynolds
from fea.pins.fits import BIG_CLEARANCE
from fea.study import film_table as assumed
from geometry.arrays import Floats
from geometry.errors import require
from loads.gas import CYCLE

# Cells around the bore and steps of the cycle; and those of a coarser film, from which the error follows.
_FINE, _COARSE = (64, 180), (48, 120)
# Cells over half the width, unless those around the bore are longer.
_MOST_ALONG, _LEAST_ALONG = 12, 4
# Clearance over radius: beyond, the film is not thin, or there is none.
_CLEARANCES = (1e-4, 1e-2)
_MPAS, _PER_GPA = 1e-9, 1e-3  # MPa·s and 1/MPa
_W, _L_MIN = 1e3, 1e6 / 60  # N·mm/s and mm³/s
_TOPIC = "oil film"


class Regime(StrEnum):
    """How surfaces are kept apart, by the smallest gap over the roughness λ.

    Full films have λ > 3, asperities carry most of the load where λ < 1 (Hamrock, Schmid & Jacobson 2004,
    Fundamentals of Fluid Film Lubrication, section 3.8).
    """

    HYDRODYNAMIC = "hydrodynamic"
    MIXED = "mixed"
    METAL = "metal to metal"

    @classmethod
    def of(cls, ratio: float) -> "Regime":
        """Judge a ratio λ."""
        return cls.HYDRODYNAMIC if ratio > 3 else cls.MIXED if ratio > 1 else cls.METAL


@dataclass(frozen=True)
class Lubrication:
    """What [film] says of the bearing, completed."""

    oil: Oil
    clearance: float  #: radial, mm
    inlet: float  #: MPa
    hole: float  #: angle from the crank arm's outward direction, rad
    hole_diameter: float  #: mm
    roughness: float  #: mm
    notes: tuple[Note, ...]

    @classmethod
    def of(cls, rod: PreparedRod) -> "Lubrication":
        """Complete what the study says.

        Raises
        ------
        InvalidValue
            With this clearance there is no film, or the oil hole is wider than the bore.
        """
        table, radius, said = rod.study.film, rod.mesh.bores.big_radius, list[str]()

        def given(value: float | None, default: float, what: str, unit: str) -> float:
            if value is None:
                said.append(f"{what} {default:.3g} {unit}")
            return default if value is None else value

        fit = rod.study.contact.big_end_clearance_mm
        default = BIG_CLEARANCE * radius / UM if fit is None else fit / 2 / UM
        clearance = table.radial_clearance_um
        if clearance is None and fit is None:
            clearance = given(None, default, "radial clearance", "µm (film.radial_clearance_um)")
        elif clearance is None:
            clearance = default
        least, most = (share * radius / UM for share in _CLEARANCES)
        rule = f"must lie between {least:.3g} and {most:.3g} µm in this bore, or the oil is no film"
        remedy = "Check its unit; where it is left out, it is half of contact.big_end_clearance_mm."
        require(least <= clearance <= most, "film.radial_clearance_um", float(clearance), rule, remedy)
        viscosity = given(
            table.viscosity_mPas, assumed.VISCOSITY_MPAS, "viscosity", "mPa·s (film.viscosity_mPas)"
        )
        alpha = given(
            table.piezoviscosity_1_GPa,
            assumed.PIEZOVISCOSITY_1_GPA,
            "piezoviscosity",
            "1/GPa (film.piezoviscosity_1_GPa)",
        )
        inlet = given(table.inlet_bar, assumed.INLET_BAR, "oil pressure", "bar (film.inlet_bar)")
        hole = given(table.hole_deg, assumed.HOLE_DEG, "oil hole at", "° (film.hole_deg)")
        diameter = given(table.hole_diameter_mm, assumed.HOLE_MM, "oil hole of", "mm (film.hole_diameter_mm)")
        rule = f"must be less than the width of the big end's bore, {rod.mesh.bores.big_width:.4g} mm"
        require(diameter < rod.mesh.bores.big_width, "film.hole_diameter_mm", diameter, rule)
        rough = given(table.roughness_um, assumed.ROUGHNESS_UM, "roughness", "µm (film.roughness_um)")
        return cls(
            oil=Oil(viscosity * _MPAS, alpha * _PER_GPA),
            clearance=clearance * UM,
            inlet=inlet * BAR,
            hole=hole * DEG,
            hole_diameter=diameter,
            roughness=rough * UM,
            notes=(*assumptions(_TOPIC, said), *_LIMITS),
        )


_LIMITS = (
    assumption(
        "the film has one temperature; the crank pin is rigid, round and parallel to the bore; asperities "
        "carry nothing",
        _TOPIC,
    ),
)


@dataclass(frozen=True)
class FilmResult:
    """The film at one speed, and a coarser one of the same bearing."""

    cycle: FilmCycle
    coarse: FilmCycle
    lubrication: Lubrication

    @property
    def degrees(self) -> Floats:
        """Crank angle (n,) of the steps."""
        return _angles(self.cycle.acting.count) / DEG

    @property
    def figures(self) -> FilmFigures:
        """The figures of `summary.json`."""
        cycle, roughness = self.cycle, self.lubrication.roughness
        thinnest, highest = cycle.thinnest.min(), cycle.highest.max()
        ratio = float(thinnest / roughness) if roughness else math.inf
        return FilmFigures(
            h_min_um=float(thinnest) / UM,
            h_min_deg=float(self.degrees[cycle.thinnest.argmin()]),
            h_min_error_percent=_error(float(thinnest), float(self.coarse.thinnest.min())),
            p_max_MPa=float(highest),
            p_max_deg=float(self.degrees[cycle.highest.argmax()]),
            p_max_error_percent=_error(float(highest), float(self.coarse.highest.max())),
            power_W=cycle.dissipated / _W,
            flow_l_min=cycle.leaked / _L_MIN,
            viscosity_mPas=self.lubrication.oil.viscosity / _MPAS,
            radial_clearance_um=self.lubrication.clearance / UM,
            lambda_min=ratio if roughness else None,
            verdict=Regime.of(ratio).value,
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
        }

    @property
    def checks(self) -> dict[str, Check]:
        """Balances of oil, power and force, and whether the cycle repeats."""
        cycle = self.cycle
        grid = cycle.bearing.reynolds.grid
        forces = np.array([grid.resultant(state.film.pressure) for state in cycle.states])
        off = np.abs(forces - cycle.acting.load).max() / np.abs(cycle.acting.load).max()
        return {
            "film_repeats": check("film_repeats", cycle.unrepeated),
            "film_oil": check("film_oil", abs(cycle.supplied / cycle.leaked - 1)),
            "film_power": check("film_power", abs(cycle.driven / cycle.dissipated - 1)),
            "film_force": check("film_force", float(off)),
        }

    @property
    def notes(self) -> tuple[Note, ...]:
        """What a reader must know."""
        found, notes = self.figures, [*self.lubrication.notes]
        if found.verdict == Regime.METAL:
            text = "the film is thinner than the surfaces are rough, where the model ends: they touch"
            notes.append(doubt(text, _TOPIC))
        elif found.verdict == Regime.MIXED:
            text = "asperities touch where the film is thinnest, and what they carry and rub is left out"
            notes.append(warning(text, _TOPIC))
        return tuple(notes)


def film_at(rod: PreparedRod, rpm: float) -> FilmResult:
    """Integrate the film of the big end at a speed, rpm.

    Raises
    ------
    InvalidValue
        A value of [film] does not suit the bore.
    FilmError
        The film was not solved.
    """
    lubrication = Lubrication.of(rod)
    with rod.clock("film"):
        fine, coarse = (_integrated(rod, rpm, lubrication, *size) for size in (_FINE, _COARSE))
    return FilmResult(fine, coarse, lubrication)


def _integrated(rod: PreparedRod, rpm: float, lubrication: Lubrication, cells: int, steps: int) -> FilmCycle:
    radius, width = rod.mesh.bores.big_radius, rod.mesh.bores.big_width
    along = round(width / 2 / (2 * math.pi * radius / cells))
    grid = FilmGrid(radius, width, cells, min(max(along, _LEAST_ALONG), _MOST_ALONG))
    cycle, bore = rod.crank_cycle(rpm), rod.yielding_bore
    instants = cycle.at(_angles(steps))
    bearing = Bearing(Reynolds(grid, lubrication.oil), lubrication.clearance, bore.on(grid))
    acting = JournalLoads(
        period=CYCLE / cycle.speed,
        load=instants.crank.T,
        speed=(cycle.speed - instants.angular_velocity) * radius,
        inlet=lubrication.inlet,
        hole_diameter=lubrication.hole_diameter,
        # The crank arm is turned by θ, and the rod by −β.
        hole_angle=instants.crank_angle + instants.motion.rod_angle + lubrication.hole,
        loaded=bore.caused(instants),
    )
    return integrate(bearing, acting)


def _angles(steps: int) -> Floats:
    """Crank angles (steps,) of a cycle, rad."""
    return np.linspace(0.0, CYCLE, steps + 1)[:-1]


def _error(fine: float, coarse: float) -> float:
    """Error of the fine film's figure, percent: of first order, as at the edge of the oil hole."""
    return 100 * abs(fine - coarse) / (_FINE[0] / _COARSE[0] - 1) / abs(fine)
