"""The oil film of the big end's bearing: what the study says of it, completed, and its cycles."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from fea.base.note import Assumed, Note, assumption, assumptions, warning
from fea.base.units import BAR, DEG, UM
from fea.film.asperities import Asperities
from fea.film.cycle import MOST_CYCLES, FilmCycle, HeatBalance, JournalLoads, integrate
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing, ElasticBore
from fea.film.oil import Oil, WarmOil
from fea.film.reynolds import Reynolds
from fea.pins.bonded import BondedBore
from fea.pins.fits import BIG_CLEARANCE, STEEL
from fea.pins.model import Structure, inertial_fields
from fea.solid.bore import BoreFacets, bore_facets, radial_forces
from fea.solid.parity import Parity, Split
from fea.solvers.static import Model
from fea.study import film_table as assumed
from fea.study.option_tables import CRANK_PIN
from geometry.arrays import Floats
from geometry.errors import require
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.gas import CYCLE
from loads.instants import Instants


@dataclass(frozen=True)
class YieldingBore:
    """The displacement of the big end's bore under pressures on it and all else that acts on the rod."""

    functions: BoreFunctions
    #: (n, n), mm³/N, between weights of the functions, without rigid translations: those are the journal's
    compliance: Floats
    #: (n, 6) weights of the displacement of unit forces of the piston pin along x and y and unit motions
    loaded: Floats

    @classmethod
    def of(cls, structure: Structure) -> "YieldingBore":
        """Solve for unit pressures on the bore, unit forces of the piston pin and unit motions.

        The sum of what acts at an instant balances; each unit alone does not, and is held by the restraints.
        """
        mesh, bores = structure.mesh, structure.bores
        functions, n_nodes = BoreFunctions(bores.big_radius, bores.big_width), len(mesh.points)
        facets = bore_facets(mesh, Surface.BIG_END_BORE, 0.0)
        pin = BondedBore.of(bore_facets(mesh, Surface.SMALL_END_BORE, bores.rod_length), n_nodes)
        even, odd = (
            np.stack([*pressed, force, *motions])
            for pressed, force, motions in zip(
                unit_forces(functions, facets, n_nodes),
                pin.forces,
                inertial_fields(structure.inertia),
                strict=True,
            )
        )
        moments = works(structure.model, facets, even, odd)
        # Of each parity, the last three are the force of the piston pin and the two motions.
        rest = np.concatenate([len(even) - 3 + np.arange(3), len(even) + len(odd) - 3 + np.arange(3)])
        own = np.setdiff1d(np.arange(len(moments)), rest)
        compliance, loaded = moments[np.ix_(own, own)], moments[np.ix_(own, rest[[0, 3, 1, 2, 4, 5]])]
        compliance = (compliance + compliance.T) / 2
        compliance[functions.translations] = loaded[functions.translations] = 0.0
        return cls(functions, compliance, loaded)

    def on(self, grid: FilmGrid) -> ElasticBore:
        """The bore for a film on a grid."""
        return ElasticBore(self.functions.means(grid), self.compliance)

    def caused(self, instants: Instants) -> Floats:
        """Weights (n_instants, n) of the displacement by all but the film: g of `ElasticBore`."""
        return np.concatenate([instants.pin, instants.motions]).T @ self.loaded.T


def unit_forces(functions: BoreFunctions, facets: BoreFacets, n_nodes: int) -> tuple[Floats, Floats]:
    """Nodal forces (n, n_nodes, 3) on the cell of pressures of 1 MPa·mm times each even and odd function."""
    z = facets.corners[..., 2] @ facets.shape_values.T
    even, odd = (
        np.stack([radial_forces(facets, n_nodes, each) for each in pressures])
        for pressures in functions.at(facets.angle, z)
    )
    return even, odd


def works(model: Model, facets: BoreFacets, even: Floats, odd: Floats) -> Floats:
    """Work (n, n) in the body of forces of both parities, (n_own, n_nodes, 3); even ones are not fewer."""
    if not facets.cut_y:
        every = np.concatenate([even, odd])
        u = model.solve([Split(forces, None) for forces in every]).displacement[Parity.SYMMETRIC]
        return np.asarray(facets.images * np.tensordot(every, u, axes=2))
    none = np.zeros((len(even) - len(odd), *even.shape[1:]))
    pairs = zip(even, np.concatenate([odd, none]), strict=True)
    u_of = model.solve([Split(*pair) for pair in pairs]).displacement
    of_parities = [
        np.tensordot(own, u_of[parity], axes=2)[:, : len(own)]
        for parity, own in ((Parity.SYMMETRIC, even), (Parity.ANTISYMMETRIC, odd))
    ]
    return np.asarray(facets.images * block_diag(*of_parities))


# Cells around the bore and steps of the cycle; and those of a coarser film, from which the error follows.
FINE, COARSE = (64, 180), (48, 120)
# Cells over half the width, unless those around the bore are longer.
_MOST_ALONG, _LEAST_ALONG = 12, 4
# Clearance over radius: beyond, the film is not thin, or there is none.
_CLEARANCES = (1e-4, 1e-2)
MPAS, _PER_GPA = 1e-9, 1e-3  # MPa·s and 1/MPa
TOPIC = "oil film"
# What says how thick the oil is, the first of them first.
_VISCOSITIES = ("viscosity_mPas", "viscosity_100C_mPas", "oil")
# σβη and σ/β, by which asperities are stiff: of an engine's big end after running-in, where the factor before
# E* F_5/2 is 1e-3 (Sander, Allmaier, Priebsch, Witt & Skiadas, Simulation of journal bearing friction in
# severe mixed lubrication; read as the input of a public program that repeats it, not in the paper).
_CROWDING, _SLOPE = 0.05, 7.1e-3


@dataclass(frozen=True)
class Lubrication:
    """What [film] says of the bearing, completed."""

    oil: Oil | WarmOil  #: at the temperature of the film, or of which this follows from the heat
    clearance: float  #: radial, mm
    inlet: float  #: MPa
    inlet_temperature: float  #: °C
    heat: float  #: share of the friction power that the oil carries away
    hole: float  #: angle from the crank arm's outward direction, rad
    hole_diameter: float  #: mm
    asperities: Asperities | None
    lining: float | None  #: specific load that it endures, MPa
    notes: tuple[Note, ...]

    @classmethod
    def of(cls, structure: Structure) -> "Lubrication":
        """Complete the study. Raises `InvalidValue`: no film with this clearance, or too wide an oil hole."""
        bores, table, said = structure.bores, structure.film, Assumed()
        radius, fit = bores.big_radius, structure.contact.big_end_clearance_mm
        clearance = table.radial_clearance_um
        if clearance is None and fit is not None:
            clearance = fit / 2 / UM
        default = BIG_CLEARANCE * radius / UM
        text = "radial clearance {:.3g} µm (film.radial_clearance_um)"
        clearance = said.or_else(clearance, default, text)
        least, most = (share * radius / UM for share in _CLEARANCES)
        rule = f"must lie between {least:.3g} and {most:.3g} µm in this bore, or there is no oil film"
        remedy = "Check its unit; where it is left out, it is half of contact.big_end_clearance_mm."
        require(least <= clearance <= most, "film.radial_clearance_um", float(clearance), rule, remedy)
        text = "piezoviscosity {:.3g} 1/GPa (film.piezoviscosity_1_GPa)"
        alpha = said.or_else(table.piezoviscosity_1_GPa, assumed.PIEZOVISCOSITY_1_GPA, text)
        oil, warm, heat = _oil(table, alpha * _PER_GPA), 0.0, 0.0
        if isinstance(oil, WarmOil):
            if table.oil is None and table.viscosity_100C_mPas is None:
                said.append(f"oil {assumed.OIL} (film.oil)")
            warm = said.or_else(table.inlet_C, assumed.INLET_C, "inlet at {:.3g} °C (film.inlet_C)")
            text = "heat into the oil {:.3g} % (film.heat_percent)"
            heat = said.or_else(table.heat_percent, assumed.HEAT_PERCENT, text) / 100
        twice = [key for key in _VISCOSITIES if getattr(table, key) is not None]
        unused = [
            warning(f"film.{key} is not used: film.{twice[0]} says the viscosity", TOPIC) for key in twice[1:]
        ]
        inlet = said.or_else(table.inlet_bar, assumed.INLET_BAR, "oil pressure {:.3g} bar (film.inlet_bar)")
        hole = said.or_else(table.hole_deg, assumed.HOLE_DEG, "oil hole at {:.3g} ° (film.hole_deg)")
        text = "oil hole of {:.3g} mm (film.hole_diameter_mm)"
        diameter = said.or_else(table.hole_diameter_mm, assumed.HOLE_MM, text)
        rule = f"must be less than the width of the big end's bore, {bores.big_width:.4g} mm"
        require(diameter < bores.big_width, "film.hole_diameter_mm", diameter, rule)
        text = "roughness {:.3g} µm (film.roughness_um)"
        rough = said.or_else(table.roughness_um, assumed.ROUGHNESS_UM, text)
        rubs = assumed.BOUNDARY_FRICTION if table.boundary_friction is None else table.boundary_friction
        return cls(
            oil=oil,
            clearance=clearance * UM,
            inlet=inlet * BAR,
            inlet_temperature=warm,
            heat=heat,
            hole=hole * DEG,
            hole_diameter=diameter,
            asperities=_asperities(rough * UM, structure, rubs) if rough else None,
            lining=table.lining_MPa,
            notes=(*unused, *assumptions(TOPIC, said), *_LIMITS),
        )


_LIMITS = (
    assumption(
        "the film has one temperature, that of the oil that leaves; the crank pin is rigid, round and "
        "parallel to the bore",
        TOPIC,
    ),
)


def _oil(table: assumed.FilmTable, piezoviscosity: float) -> Oil | WarmOil:
    if table.viscosity_mPas is not None:
        return Oil(table.viscosity_mPas * MPAS, piezoviscosity)
    if table.viscosity_40C_mPas is not None and table.viscosity_100C_mPas is not None:
        dynamic = ((40.0, table.viscosity_40C_mPas), (100.0, table.viscosity_100C_mPas))
        return WarmOil.of(dynamic, assumed.DENSITY_15_KG_M3, piezoviscosity)
    kinematic, sheared = assumed.grade(table.oil or assumed.OIL)
    oil = WarmOil.of(((150.0, sheared),), assumed.DENSITY_15_KG_M3, piezoviscosity)
    return replace(oil, temperatures=(100.0, 150.0), kinematic=(kinematic, *oil.kinematic))


def _asperities(roughness: float, structure: Structure, friction: float) -> Asperities:
    pin, rod = structure.pin_stiffness.get(CRANK_PIN, STEEL), structure.materials[0]
    yields = (1 - pin[1] ** 2) / pin[0] + (1 - rod.poissons_ratio**2) / rod.youngs_modulus
    return Asperities.of(roughness, _CROWDING, _SLOPE, 1 / yields, friction)


class Films:
    """The films of the big end of a rod, each computed once."""

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        # By the speed and the gas, which is kept so that its number stays its own.
        self._pairs: dict[tuple[float, int], tuple[FilmCycle, FilmCycle, object]] = {}

    @cached_property
    def bore(self) -> YieldingBore:
        """How the bore yields to the pressure of a film."""
        with self._structure.clock("film"):
            return YieldingBore.of(self._structure)

    @cached_property
    def lubrication(self) -> Lubrication:
        """What the study says, completed."""
        return Lubrication.of(self._structure)

    def at(self, cycle: CrankCycle) -> tuple[FilmCycle, FilmCycle]:
        """The film of a cycle, and a coarser one. Raises `InvalidValue` (unsuitable [film]), `FilmError`."""
        rule = "must be above 0: the rotation of the crank pin carries its oil film"
        require(cycle.speed > 0, "speed.rpm", cycle.speed, rule)
        key = cycle.speed, id(cycle.gas)
        if key not in self._pairs:
            bore = self.bore
            with self._structure.clock("film"):
                coarse = self._integrated(cycle, bore, COARSE, None)
                self._pairs[key] = self._integrated(cycle, bore, FINE, coarse), coarse, cycle.gas
        return self._pairs[key][:2]

    def coarse(self, cycle: CrankCycle) -> FilmCycle:
        """The coarse one alone; errors as `at`."""
        return self._integrated(cycle, self.bore, COARSE, None)

    def _integrated(
        self, cycle: CrankCycle, bore: YieldingBore, size: tuple[int, int], before: FilmCycle | None
    ) -> FilmCycle:
        bores, said, (cells, steps) = self._structure.bores, self.lubrication, size
        along = round(bores.big_width / 2 / (2 * math.pi * bores.big_radius / cells))
        grid = FilmGrid(bores.big_radius, bores.big_width, cells, min(max(along, _LEAST_ALONG), _MOST_ALONG))
        instants, heat, oil = cycle.at(crank_angles(steps)), None, said.oil
        if isinstance(oil, WarmOil):
            heat, oil = HeatBalance(oil, said.inlet_temperature, said.heat), oil.at(said.inlet_temperature)
        bearing = Bearing(Reynolds(grid, oil), said.clearance, bore.on(grid), said.asperities)
        acting = JournalLoads(
            period=CYCLE / cycle.speed,
            load=instants.crank.T,
            speed=(cycle.speed - instants.angular_velocity) * bores.big_radius,
            inlet=said.inlet,
            hole_diameter=said.hole_diameter,
            # The crank arm is turned by θ, and the rod by −β.
            hole_angle=instants.crank_angle + instants.motion.rod_angle + said.hole,
            loaded=bore.caused(instants),
        )
        most = 2 if before is not None and before.starved else MOST_CYCLES
        return integrate(bearing, acting, heat=heat, before=before, most=most)


def crank_angles(steps: int) -> Floats:
    """Crank angles (steps,) of a cycle, rad."""
    return np.linspace(0.0, CYCLE, steps + 1)[:-1]
