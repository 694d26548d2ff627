"""The oil films of a rod's bearings: what the study says of them, completed, and their cycles."""

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fea.base.note import Assumed, Note, assumption, assumptions, warning
from fea.base.units import BAR, DEG, UM
from fea.contact.friction_system import ContactState
from fea.film.constitutive import Asperities, Oil, WarmOil
from fea.film.cycle import MOST_CYCLES, FilmCycle, HeatBalance, JournalLoads, integrate
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing
from fea.film.reynolds import Reynolds
from fea.pins.contact import ContactPins
from fea.pins.fits import BIG_CLEARANCE, STEEL, Fits
from fea.pins.model import PinModelContext
from fea.pins.yielding import End, YieldingBore
from fea.solid.bore import BoreFacets
from fea.solid.errors import FilmError
from fea.study import film_table as assumed
from fea.study.option_tables import CRANK_PIN, PISTON_PIN
from fea.study.pin_models import pin_model
from geometry.arrays import Floats
from geometry.errors import require
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

if TYPE_CHECKING:
    from fea.pins.assembly import AssemblyPins

# Cells around the bore and over half its width, and steps of the cycle; and those of a coarser film, from
# which the error follows.
FINE, COARSE = (96, 7, 144), (64, 5, 96)
# How much less exactly than the fine one films are solved of which only its error follows.
_SLACK = 10.0
# Clearance over radius: beyond, the film is not thin, or there is none.
_CLEARANCES = (1e-4, 1e-2)
MPAS, _PER_GPA = 1e-9, 1e-3  # MPa·s and 1/MPa
TOPIC = "oil film"
TOPICS = {End.BIG: TOPIC, End.SMALL: "oil film of the small end"}
# What says how thick the oil is, the first of them first.
_VISCOSITIES = ("viscosity_mPas", "viscosity_100C_mPas", "oil")
# σβη and σ/β, by which asperities are stiff: of an engine's big end after running-in, where the factor before
# E* F_5/2 is 1e-3 (Sander, Allmaier, Priebsch, Witt & Skiadas, Simulation of journal bearing friction in
# severe mixed lubrication; read as the input of a public program that repeats it, not in the paper).
_CROWDING, _SLOPE = 0.05, 7.1e-3


@dataclass(frozen=True)
class Hole:
    """A round hole in the middle of a bearing's width."""

    angle: float  #: in a bore from rod +x, in the crank pin from the crank arm's outward direction, rad
    diameter: float  #: mm
    above: float = 0.0  #: pressure of its oil above that of the inlet, MPa

    def share(self, grid: FilmGrid) -> Floats:
        """Share (n_angle, n_width) of each cell of a film that it covers."""
        return grid.hole(self.angle, self.diameter)


@dataclass(frozen=True)
class Grooves:
    """Grooves that oil of the inlet's pressure fills, in the middle of a bearing's width."""

    angles: tuple[float, ...]  #: of the middle of each, rad; in the pin as its hole
    arc: float  #: length of each around the bearing, rad
    width: float  #: mm
    turn: bool  #: whether they are in the pin

    @classmethod
    def of(cls, table: assumed.FilmTable) -> "Grooves | None":
        """What a study says of them."""
        if not table.grooves_deg:
            return None
        arc, width = table.groove_arc_deg or 0.0, table.groove_width_mm or 0.0
        return cls(tuple(np.multiply(DEG, table.grooves_deg)), arc * DEG, width, table.grooves_in == "pin")

    def share(self, grid: FilmGrid, turned: float = 0.0) -> Floats:
        """Share (n_angle, n_width) of each cell of a film that they cover, turned by an angle."""
        each = [grid.groove(angle + turned, self.arc, self.width) for angle in self.angles]
        return np.asarray(np.max(each, axis=0))


@dataclass(frozen=True, kw_only=True)
class Lubrication:
    """What [film] says of a bearing, completed."""

    end: End = End.BIG
    oil: Oil | WarmOil  #: at the temperature of the film, or of which this follows from the heat
    clearance: float  #: radial, mm
    inlet: float  #: MPa; at the small end of the oil around it
    inlet_temperature: float = 0.0  #: °C
    heat: float = 0.0  #: share of the friction power that the oil carries away
    temperature: float | None = None  #: of a film that takes that of the surfaces, °C
    pin_hole: Hole | None = None  #: in the crank pin
    holes: tuple[Hole, ...]  #: in the bore
    grooves: Grooves | None = None
    swing: float = 1.0  #: rotation of the small end on its pin over that of the rod
    asperities: Asperities | None
    lining: float | None = None  #: specific load that it endures, MPa
    notes: tuple[Note, ...]

    @classmethod
    def of(cls, structure: PinModelContext) -> "Lubrication":
        """Complete the study for the big end.

        Raises `InvalidValue`: no film with this clearance, too wide an oil hole, grooves that leave no land.
        """
        bores, table, said = structure.bores, structure.film, Assumed()
        radius, fit = bores.big_radius, structure.contact.big_end_clearance_mm
        clearance = table.radial_clearance_um
        if clearance is None and fit is not None:
            clearance = fit / 2 / UM
        text = "radial clearance {:.3g} µm (film.radial_clearance_um)"
        clearance = said.or_else(clearance, BIG_CLEARANCE * radius / UM, text)
        remedy = "Check its unit; where it is left out, it is half of contact.big_end_clearance_mm."
        _require_film("film.radial_clearance_um", clearance, "µm", radius / UM, remedy)
        oil, warm, heat = _oil(table, said), 0.0, 0.0
        if isinstance(oil, WarmOil):
            warm = said.or_else(table.inlet_C, assumed.INLET_C, "inlet at {:.3g} °C (film.inlet_C)")
            text = "heat into the oil {:.3g} % (film.heat_percent)"
            heat = said.or_else(table.heat_percent, assumed.HEAT_PERCENT, text) / 100
        first, *twice = [key for key in _VISCOSITIES if getattr(table, key) is not None] or ["oil"]
        if isinstance(oil, Oil):
            twice += [key for key in ("inlet_C", "heat_percent") if getattr(table, key) is not None]
        because = f"is not used: film.{first} gives the viscosity"
        unused = [warning(f"film.{key} {because}", TOPIC) for key in twice]
        inlet = said.or_else(table.inlet_bar, assumed.INLET_BAR, "oil pressure {:.3g} bar (film.inlet_bar)")
        angle = said.or_else(table.hole_deg, assumed.HOLE_DEG, "oil hole at {:.3g} ° (film.hole_deg)")
        text = "oil hole of {:.3g} mm (film.hole_diameter_mm)"
        diameter = said.or_else(table.hole_diameter_mm, assumed.HOLE_MM, text)
        _require_hole("film.hole_diameter_mm", diameter, End.BIG, bores.big_width)
        table.require_land(bores.big_width)
        asperities = _asperities(structure, End.BIG, clearance * UM, said)
        halved = Surface.SYMMETRY_Z in structure.mesh.facets
        return cls(
            oil=oil,
            clearance=clearance * UM,
            inlet=inlet * BAR,
            inlet_temperature=warm,
            heat=heat,
            pin_hole=Hole(angle * DEG, diameter),
            holes=_openings(structure, End.BIG, said),
            grooves=Grooves.of(table),
            asperities=asperities,
            lining=table.lining_MPa,
            notes=(*unused, *assumptions(TOPIC, said), assumption(_LIMITS[halved], TOPIC)),
        )

    @classmethod
    def of_small_end(cls, structure: PinModelContext, fits: Fits) -> "Lubrication":
        """Complete the study for the small end, whose sides stand in oil; errors as of `of`."""
        bores, table, said = structure.bores, structure.film, Assumed()
        in_contact = pin_model(structure.pressure, in_parts=structure.mesh.part is not None).in_contact
        said.extend(fits.assumed_in_film(in_contact=in_contact))
        remedy = "Check its unit; without a film at the small end, leave out [film]."
        key, diameter = "contact.small_end_clearance_mm", 2 * bores.small_radius
        _require_film(key, 2 * fits.small_clearance, "mm", diameter, remedy)
        oil, warm = _oil(table, Assumed()), None  # what that assumes is said of the big end
        if isinstance(oil, WarmOil):
            warm = said.or_else(
                table.small_end_C, assumed.SMALL_END_C, "film at {:.3g} °C (film.small_end_C)"
            )
        text = "its sides in oil of {:.3g} bar above that of a ruptured film (film.small_end_inlet_bar)"
        around = said.or_else(table.small_end_inlet_bar, assumed.SMALL_END_BAR, text)
        drilled = 0.0 if structure.drawn is None else structure.drawn.oil_hole
        hole = Hole(table.small_end_hole_deg * DEG, table.small_end_hole_diameter_mm or drilled)
        _require_hole("film.small_end_hole_diameter_mm", hole.diameter, End.SMALL, bores.small_width)
        holes = _openings(structure, End.SMALL, said)
        kind = table.piston_pin or assumed.FLOATING
        if table.piston_pin is None:
            said.append("a floating piston pin (film.piston_pin)")
        if kind == assumed.FLOATING:
            said.append("that it shares half of the rod's rotation, as where its bosses rub as the small end")
        return cls(
            end=End.SMALL,
            oil=oil,
            clearance=fits.small_clearance,
            inlet=around * BAR,
            temperature=warm,
            holes=(hole, *holes) if hole.diameter else holes,
            swing=1 - assumed.TURNS[kind],
            asperities=_asperities(structure, End.SMALL, fits.small_clearance, Assumed()),
            notes=assumptions(TOPICS[End.SMALL], said),
        )


# By whether z = 0 is a mirror plane of the mesh.
_ONE = "the film has one temperature, that of the oil that leaves; the crank pin is rigid"
_LIMITS = {
    True: f"{_ONE}, round and parallel to the bore",
    False: f"{_ONE} and round; the rod tilts on its pins, and the film of either end is computed as if the "
    "other pin took no moment",
}


def _require_film(key: str, clearance: float, unit: str, size: float, remedy: str) -> None:
    """Refuse a clearance in which there is no film: radial of a radius, or diametral of a diameter."""
    least, most = (share * size for share in _CLEARANCES)
    rule = f"must lie between {least:.3g} and {most:.3g} {unit} in this bore, or there is no oil film"
    require(least <= clearance <= most, key, float(clearance), rule, remedy)


def _require_hole(key: str, diameter: float, end: End, width: float) -> None:
    most = assumed.WIDEST * width
    rule = f"leaves no land at the ends of the {end.words}'s bore: at most {most:.4g} mm"
    require(diameter <= most, key, diameter, rule)


def _openings(structure: PinModelContext, end: End, said: Assumed) -> tuple[Hole, ...]:
    """Where what is drilled along the rod opens into a bore, full of the oil that feeds the big end."""
    drawn = structure.drawn
    diameter = 0.0 if drawn is None else drawn.big_end_opening if end is End.BIG else drawn.oil_gallery
    if not diameter:
        return ()
    inlet = assumed.INLET_BAR if structure.film.inlet_bar is None else structure.film.inlet_bar
    oil = f"oil of {inlet:.3g} bar (film.inlet_bar)"
    said.append(f"the hole of {diameter:.3g} mm along the rod full of {oil}")
    if end is End.BIG:
        return (Hole(0.0, diameter),)
    return (Hole(math.pi, diameter, inlet * BAR),)


def _oil(table: assumed.FilmTable, said: Assumed) -> Oil | WarmOil:
    text = "piezoviscosity {:.3g} 1/GPa (film.piezoviscosity_1_GPa)"
    alpha = _PER_GPA * said.or_else(table.piezoviscosity_1_GPa, assumed.PIEZOVISCOSITY_1_GPA, text)
    if table.viscosity_mPas is not None:
        return Oil(table.viscosity_mPas * MPAS, alpha)
    if table.viscosity_40C_mPas is not None and table.viscosity_100C_mPas is not None:
        dynamic = ((40.0, table.viscosity_40C_mPas), (100.0, table.viscosity_100C_mPas))
        return WarmOil.of(dynamic, assumed.DENSITY_15_KG_M3, alpha)
    if table.oil is None:
        said.append(f"oil {assumed.OIL} (film.oil)")
    kinematic, sheared = assumed.grade(table.oil or assumed.OIL)
    oil = WarmOil.of(((150.0, sheared),), assumed.DENSITY_15_KG_M3, alpha)
    return replace(oil, temperatures=(100.0, 150.0), kinematic=(kinematic, *oil.kinematic))


def _asperities(structure: PinModelContext, end: End, clearance: float, said: Assumed) -> Asperities | None:
    table = structure.film
    text = "roughness {:.3g} µm (film.roughness_um)"
    rough = said.or_else(table.roughness_um, assumed.ROUGHNESS_UM, text)
    rule = f"must be less than the radial clearance of the {end.words}, {clearance / UM:.3g} µm"
    require(rough * UM < clearance, "film.roughness_um", rough, rule)
    if not rough:
        return None
    text = "boundary friction {:.3g} (film.boundary_friction)"
    friction = said.or_else(table.boundary_friction, assumed.BOUNDARY_FRICTION, text)
    of_pin = structure.pin_stiffness.get(CRANK_PIN if end is End.BIG else PISTON_PIN, STEEL)
    bore = end.material(structure)
    yields = (1 - of_pin[1] ** 2) / of_pin[0] + (1 - bore.poissons_ratio**2) / bore.youngs_modulus
    return Asperities.of(rough * UM, _CROWDING, _SLOPE, 1 / yields, friction)


# Share of the joint's area that may open under loads before the film follows it.
_OPENED = 0.01


class Films:
    """The films of one end of a rod, each computed once; `parts`: those of a rod in parts, and its pins."""

    def __init__(
        self, structure: PinModelContext, end: End = End.BIG, parts: "AssemblyPins | None" = None
    ) -> None:
        self._structure, self.end, self.parts = structure, end, parts
        # By the speed and the gas, which is kept so that its number stays its own.
        self._found: dict[tuple[float, int], tuple[FilmCycle, FilmCycle, FilmCycle | None, object]] = {}

    @cached_property
    def _fits(self) -> Fits:
        return (self.parts or ContactPins(self._structure)).fits.in_film

    @cached_property
    def bore(self) -> YieldingBore:
        """How the bore yields to the pressure of a film, and the piston pin with it."""
        parts = None if self.parts is None else self.parts.assembly.assembled
        with self._structure.clock("film"):
            bore = YieldingBore.of(self._structure, self.end, parts)
            return bore if self.end is End.BIG else bore.with_fits(self._fits)

    @property
    def facets(self) -> BoreFacets:
        """The bore in the mesh."""
        return self.end.facets(self._structure)

    @property
    def functions(self) -> BoreFunctions:
        """Those in which the bore yields."""
        return self.end.functions(self._structure)

    @cached_property
    def lubrication(self) -> Lubrication:
        """What the study says, completed."""
        if self.end is End.BIG:
            return Lubrication.of(self._structure)
        return Lubrication.of_small_end(self._structure, self._fits)

    def at(self, cycle: CrankCycle) -> tuple[FilmCycle, FilmCycle, FilmCycle | None]:
        """The film of a cycle, a coarser one, and that one in a bore that yields as on much smaller elements.

        The last is None where it was not solved. Raises `InvalidValue`: unsuitable [film]; `FilmError`.
        """
        require(cycle.speed > 0, "speed.rpm", cycle.speed, "must be above 0: motion carries an oil film")
        key = _key(cycle)
        if key not in self._found:
            bore = self.bore
            with self._structure.clock("film"):
                coarse = self._integrated(cycle, bore, COARSE, None, _SLACK)
                fine = self._integrated(cycle, bore, FINE, coarse)
            if min(fine.thinnest.min(), coarse.thinnest.min()) < 0:  # smooth ones alone
                raise FilmError("smooth surfaces meet at an edge of the bore. Give film.roughness_um")
            self._found[key] = fine, coarse, self._softer(cycle, coarse), cycle.gas
        return self._found[key][:3]

    def prepare(self, cycle: CrankCycle) -> None:
        """Find what films in two processes would both look for: the bore, and where the joint opens."""
        bore = self.bore
        with self._structure.clock("film"):
            for _, _, steps in (COARSE, FINE):
                self._bores(cycle, cycle.at(crank_angles(steps, cycle.engine.cycle)), bore)

    def remember(self, cycle: CrankCycle, found: tuple[FilmCycle, FilmCycle, FilmCycle | None]) -> None:
        """Take over what `at` returned in another process."""
        self._found[_key(cycle)] = *found, cycle.gas

    def coarse(self, cycle: CrankCycle, size: tuple[int, int, int] = COARSE) -> FilmCycle:
        """The coarse one alone, or one of other cells and steps as `COARSE`; errors as of `at`."""
        return self._integrated(cycle, self.bore, size, None)

    def opened(self, state: ContactState) -> float:
        """Share of the joint of a rod in parts that loads open: 0 where that is next to nothing."""
        if self.parts is None:
            return 0.0
        share, parts = self.parts.assembly.sums.open_share, self.parts.assembly.assembled
        more = share(state) - share(parts.start)
        return more if more > _OPENED else 0.0

    def openings(self, cycle: CrankCycle) -> dict[str, float]:
        """That of the load cases of a cycle in which the joint opens; none of a rod of one piece."""
        cases = cycle.peaks.cases
        states = () if self.parts is None else self.parts.states(cases)
        opened = {case.name: self.opened(state) for case, state in zip(cases, states, strict=False)}
        return {name: share for name, share in opened.items() if share}

    def _bores(self, cycle: CrankCycle, instants: Instants, bore: YieldingBore) -> list[YieldingBore]:
        """The bore at each instant, where the joint opens in the cycle; none where it does not."""
        if self.parts is None or not self.openings(cycle):
            return []
        states, known = self.parts.states(instants, cycle), dict[bytes, YieldingBore]()
        keys = [state.guess.opened.tobytes() for state in states]
        for key, state in zip(keys, states, strict=True):
            if key not in known:
                known[key] = bore.with_joint(state)
        return [known[key] for key in keys]

    def _softer(self, cycle: CrankCycle, film: FilmCycle) -> FilmCycle | None:
        """A film as warm as before in a bore that lacks nothing of its compliance; None: not solved."""
        bore, bearing, acting = self.bore, film.bearing, film.acting
        root = np.sqrt(1 + bore.lacking)
        more = (np.outer(root, root) - 1) * bore.compliance
        if acting.loaded is not None:
            angles = crank_angles(acting.count, cycle.engine.cycle)
            afar = bore.caused_from_afar(cycle.at(angles))
            acting = replace(acting, loaded=acting.loaded + bore.lacking[bore.functions.oval] * afar)
        if acting.compliance is not None:
            acting = replace(acting, compliance=acting.compliance + more)
        if bearing.bore is not None:
            bearing = bearing.yielding_by(bearing.bore.compliance + more)
        with suppress(FilmError), self._structure.clock("film"):
            return integrate(bearing, acting, before=film, most=1)
        return None

    def _integrated(
        self,
        cycle: CrankCycle,
        bore: YieldingBore,
        size: tuple[int, int, int],
        before: FilmCycle | None,
        slack: float = 1.0,
    ) -> FilmCycle:
        said, (around, along, steps), end = self.lubrication, size, self.end
        (radius, width), halved = end.size(self._structure.bores), bore.functions.mirrored
        grid = FilmGrid(radius, width, around, along if halved else 2 * along, halved, graded=1.0)
        instants, heat, oil = cycle.at(crank_angles(steps, cycle.engine.cycle)), None, said.oil
        if isinstance(oil, WarmOil) and said.temperature is not None:
            oil = oil.at(said.temperature)
        elif isinstance(oil, WarmOil):
            heat, oil = HeatBalance(oil, said.inlet_temperature, said.heat), oil.at(said.inlet_temperature)
        bearing = Bearing(Reynolds(grid, oil), said.clearance, bore.on(grid), said.asperities, slack)
        bores = self._bores(cycle, instants, bore)
        caused = [each.caused(instant[None])[0] for each, instant in zip(bores, instants, strict=False)]
        grooves, pin_hole = said.grooves, said.pin_hole
        fixed: list[Hole | Grooves] = [*said.holes]
        if grooves is not None and not grooves.turn:
            fixed.append(grooves)
        acting = JournalLoads(
            period=cycle.engine.cycle / cycle.speed,
            load=bore.carried(instants),
            speed=((cycle.speed if end is End.BIG else 0.0) - said.swing * instants.angular_velocity)
            * radius,
            inlet=said.inlet,
            above=sum([hole.above * np.ceil(hole.share(grid)) for hole in said.holes if hole.above], 0.0),
            grooves=np.max([each.share(grid) for each in fixed], axis=0) if fixed else None,
            flooded=end is End.SMALL,
            loaded=np.stack(caused) if bores else bore.caused(instants),
            compliance=np.stack([each.with_pin for each in bores]) if bores else None,
        )
        if pin_hole is not None:
            # The crank arm is turned by θ, and the rod by −β.
            angle = instants.crank_angle + instants.motion.rod_angle + pin_hole.angle
            acting = replace(acting, hole_diameter=pin_hole.diameter, hole_angle=angle)
            if grooves is not None and grooves.turn:
                acting = replace(acting, turning=lambda turned: grooves.share(grid, turned - pin_hole.angle))
        fails = before is not None and (before.starved or before.too_hot)
        found = integrate(bearing, acting, heat=heat, before=before, most=2 if fails else MOST_CYCLES)
        if fails and not (found.starved or found.too_hot or found.repeats):
            found = integrate(bearing, acting, heat=heat, before=found)
        return found


def _key(cycle: CrankCycle) -> tuple[float, int]:
    return cycle.speed, id(cycle.gas)


def crank_angles(steps: int, cycle: float = 4 * math.pi) -> Floats:
    """Crank angles (steps,) of a cycle, rad, of so many rad; by default of a four-stroke engine."""
    return np.linspace(0.0, cycle, steps + 1)[:-1]
