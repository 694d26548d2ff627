"""The oil film of rigid and elastic bearings: charts, tables, closed forms, a measurement and trends."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from fea.analysis.engine_study import engine_study
from fea.analysis.pipeline import prepare
from fea.base.choices import Support
from fea.base.material import Material
from fea.film.constitutive import Asperities, Oil
from fea.film.cycle import FilmCycle, between
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing, ElasticBore, JournalState
from fea.film.reynolds import Conditions, Reynolds, Supply
from fea.pins.lubrication import COARSE
from fea.pins.yielding import unit_forces, works
from fea.rod.loading import EngineLoading
from fea.solid.bore import bore_facets, radial_forces
from fea.solvers.static import Model
from fea.study.flags import Flags
from fea.study.study import parse_study
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import STEEL, half_ring, rectangle
from fea.verify.michell import displacement, pressed
from fea.verify.reproduce.tables import records
from geometry.arrays import Floats
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body

# A journal, mm and rad/s, and its oil, MPa·s: the figures compared do not depend on them.
_RADIUS, _CLEARANCE, _OMEGA, _VISCOSITY = 25.0, 0.025, 300.0, 1e-8
# The oil is supplied without pressure: with so little of it, MPa, that no figure changes.
_NO_PRESSURE = 1e-4


def _bearing(ratio: float, size: float) -> Bearing:
    """A bearing of a width over diameter, with cells of a length around the bore and 16 mm / that across."""
    cells = 4 * round(2 * math.pi * _RADIUS / size / 4)
    grid = FilmGrid(_RADIUS, 2 * _RADIUS * ratio, cells, max(4, round(16 / size)))
    return Bearing(Reynolds(grid, Oil(_VISCOSITY)), _CLEARANCE)


def _turning(
    bearing: Bearing, eccentricity: float, *speeds: float, slot: tuple[int, int] = (0, 1)
) -> JournalState:
    """A journal displaced towards −x, at the last of some speeds, mm/s; a slot supplies oil.

    `slot`: its middle and its length in cells, by default that at 0°.
    """
    grid, (middle, length) = bearing.reynolds.grid, slot
    supply = Supply(grid.groove(middle * grid.angle[1], length * grid.angle[1]), _NO_PRESSURE)
    state = bearing.start((-eccentricity * bearing.clearance, 0.0))
    for speed in speeds or (_OMEGA * _RADIUS,):
        state = bearing.solve(state, Conditions(speed, supply))
    return state


def _force(bearing: Bearing, state: JournalState) -> tuple[float, float]:
    """The film's force, N, and its angle behind the narrowest gap, degrees."""
    x, y = bearing.reynolds.grid.resultants(state.film.pressure)
    return math.hypot(x, y), 180 - math.degrees(math.atan2(y, x))


def _size(bearing: Bearing) -> int:
    return math.prod(bearing.reynolds.grid.shape)


def _printed(name: str) -> Iterator[list[float]]:
    """The rows of a published table of figures only."""
    return ([float(text) for text in row.values()] for row in records(name))


@benchmark("Raimondi & Boyd 1958, ASLE Transactions 1, 159-209, parts I-III", size=1.1)
def raimondi_boyd(size: float) -> Quantities:
    """Full journal bearing."""
    for ratio, thinnest, sommerfeld, attitude, friction in _printed("raimondi1958"):
        bearing = _bearing(ratio, size)
        state = _turning(bearing, 1 - thinnest)
        force, behind = _force(bearing, state)
        scale = _VISCOSITY * _OMEGA / (2 * math.pi) * 4 * ratio * _RADIUS**2 * (_RADIUS / _CLEARANCE) ** 2
        # The partly filled gap is sheared like a full one, as they assume.
        resists, _ = bearing.reynolds.friction(state.film, state.gap, _OMEGA * _RADIUS, full_shear=True)
        at, three = f"L/D {ratio:g}, h0/c {thinnest:g}", "the figures are printed with three digits"
        rubbing = resists / force * _RADIUS / _CLEARANCE
        angle = "half a degree: finite differences of 1958"
        yield Quantity(f"Sommerfeld number, {at}", "1", sommerfeld, scale / force, 1.0, three)
        yield Quantity(f"attitude, {at}", "°", attitude, behind, 50.0 / attitude, angle)
        yield Quantity(f"(r/c) f, {at}", "1", friction, rubbing, 1.0, three)
    return _size(bearing)


@benchmark(
    "Butenschön 1976, Das hydrodynamische, zylindrische Gleitlager endlicher Breite unter instationärer "
    "Belastung, thesis, Karlsruhe",
    size=1.6,
)
def butenschoen(size: float) -> Quantities:
    """Bearing of finite width, rotating and squeezed."""
    swift = 100.0  # clearances per second, from a full film
    why = "the figures are results of finite differences, and agree with others within 1 %"
    for row in records("butenschoen1976"):
        ratio, eccentricity, target = 1 / float(row["D_over_B"]), float(row["eccentricity"]), float(row["So"])
        bearing, rate = _bearing(ratio, size), _OMEGA
        if row["motion"] == "rotation":
            state = _turning(bearing, eccentricity)
        else:
            place, rate = (-eccentricity * _CLEARANCE, 0.0), swift
            state = bearing.squeezed(place, (-swift * _CLEARANCE, 0.0))
        force, _ = _force(bearing, state)
        # Fψ²/(BDηω), of squeezing with ε̇ in place of ω.
        number = force * (_CLEARANCE / _RADIUS) ** 2 / (4 * ratio * _RADIUS**2 * _VISCOSITY * rate)
        name = f"So, {row['motion']}, B/D {ratio:.2g}, ε {eccentricity:g}"
        yield Quantity(name, "1", target, number, 2.0, why)
    return _size(bearing)


@benchmark("Ocvirk 1952, NACA TN 2808; Dubois & Ocvirk 1953, NACA TR 1157", size=1.1)
def ocvirk(size: float) -> Quantities:
    """Very short bearing."""
    ratio = 0.02  # in the limit no pressure drives oil around the bore; here the rest is below 0.1 %
    width = 2 * ratio * _RADIUS
    why = "the pressure is a parabola over the width, whose mean the cells have to 1/2n²"
    for eccentricity in (0.3, 0.6, 0.8):
        bearing = _bearing(ratio, size)
        force, behind = _force(bearing, _turning(bearing, eccentricity))
        square = 1 - eccentricity**2
        scale = _VISCOSITY * _OMEGA * _RADIUS * width**3 / (4 * _CLEARANCE**2)
        exact = scale * eccentricity / square**2 * math.hypot(4 * eccentricity, math.pi * math.sqrt(square))
        attitude = math.degrees(math.atan2(math.pi * math.sqrt(square), 4 * eccentricity))
        yield Quantity(f"load, ε {eccentricity:g}", "N", exact, force, 0.5, why)
        yield Quantity(f"attitude, ε {eccentricity:g}", "°", attitude, behind, 0.5, why)
    return _size(bearing)


@benchmark(
    "Lund & Thomsen 1978, in Topics in Fluid Film Bearing and Rotor Bearing System Design, ASME, 1-28",
    size=1.6,
)
def lund_thomsen(size: float) -> Quantities:
    """Bearing with two axial grooves."""
    close = "within 0.01: how the table agrees with other programs"
    turned = "within 1°: a hundredth of the eccentricity turns the lightly loaded journal by as much"
    for ratio, number, eccentricity, attitude in _printed("lund1978"):
        bearing = _bearing(ratio, size)
        grid = bearing.reynolds.grid
        share = sum(grid.groove(side * math.pi / 2, math.radians(20)) for side in (1, -1))
        area = 4 * ratio * _RADIUS**2
        load = _VISCOSITY * _OMEGA / (2 * math.pi) * area * (_RADIUS / _CLEARANCE) ** 2 / number
        start = bearing.start((0.3 * _CLEARANCE, 0.3 * _CLEARANCE))
        supply = Supply(np.asarray(share), _NO_PRESSURE)
        state = bearing.solve(start, Conditions(_OMEGA * _RADIUS, supply), load=np.array([load, 0.0]))
        x, y = state.position / _CLEARANCE
        at, away, angle = f"L/D {ratio:g}, S {number:g}", math.hypot(x, y), math.degrees(math.atan2(y, x))
        yield Quantity(f"eccentricity, {at}", "1", eccentricity, away, 1.0 / eccentricity, close)
        yield Quantity(f"attitude, {at}", "°", attitude, angle, 100.0 / attitude, turned)
    return _size(bearing)


@benchmark(
    "Michell 1899, Proceedings of the London Mathematical Society 31, 100-124; Timoshenko & Goodier 1970, "
    "article 43",
    size=3.0,
    converges=True,
)
def elastic_ring(size: float) -> Quantities:
    """Elastic ring under the pressures of a film."""
    inner, outer, half_width = 25.0, 35.0, 1.0
    ring = Prism(half_ring(inner, outer), (0.0, half_width))
    mesh = mesh_body(ring, size, fine={Surface.INNER: LocalSize(size / 2)})
    functions, facets = BoreFunctions(inner, 2 * half_width), bore_facets(mesh, Surface.INNER, 0.0)
    even, odd = unit_forces(functions, facets, len(mesh.points))
    compliance, _ = works(Model(mesh, STEEL, Support.INERTIA_RELIEF), facets, even, odd)
    why = "displacements of quadratic elements that resolve the wave"
    for n in (2, 3, 6):
        moves = displacement(STEEL, inner, n)
        (number,) = np.flatnonzero((functions.terms == [n, 0]).all(axis=1))
        for name, row in (("cos", number), ("sin", len(even) + number - 1)):
            exact, computed = float(moves @ pressed(inner, outer, n)), float(compliance[row, row])
            yield Quantity(f"displacement under {name} {n}φ", "mm", exact, computed, 1.0, why)
    return mesh.points.size


# Freund's bearing: behind its wall from the oil slot at 0° on, which is held at its other edges, is nothing.
_ARC, _WALL, _WIDE, _NARROW = math.radians(132), 1.0, 64.0, 7.5  # rad and mm, half widths at both ends


def _with_diaphragm(grid: FilmGrid, size: float) -> tuple[ElasticBore, int]:
    """The bore whose cells yield where the wall does, and the degrees of freedom of its mesh."""
    free, inner, held = Surface.FREE, Surface.INNER, Surface.BIG_END_BORE  # which a support clamps
    sides = rectangle((0.0, _WALL), (0.0, _ARC * grid.radius), (free, free, held, inner))
    flat = mesh_body(Prism(sides, (0.0, _WIDE), top=held), size)
    depth, along, z = flat.points.T
    r, angle = grid.radius + depth, along / grid.radius
    z = z * (1 + (_NARROW / _WIDE - 1) * angle / _ARC)
    mesh = replace(flat, points=np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1))
    facets = bore_facets(mesh, inner, 0.0)
    around = np.rint(facets.angle / grid.angle[1]).astype(np.int64)
    across = np.searchsorted(grid.edges, facets.corners[..., 2] @ facets.shape_values.T) - 1
    cell = around * grid.n_width + across
    cells = np.unique(cell)
    forces = np.stack([radial_forces(facets, len(mesh.points), cell == each) for each in cells])
    steel = replace(STEEL, youngs_modulus=200e3)
    work, _ = works(Model(mesh, steel, Support.CLAMPED), facets, forces, forces[:0])
    area = grid.images * grid.area[cells % grid.n_width]
    functions = np.eye(math.prod(grid.shape))[:, cells].reshape(*grid.shape, -1)
    ends = np.zeros((grid.n_angle, 1, len(cells)))
    return ElasticBore(functions, ends, work / np.outer(area, area)), mesh.points.size


@benchmark("Freund 1995, A thermo-elasto-hydrodynamic study of journal bearings, figure 46b", size=5.0)
def freund(size: float) -> Quantities:
    """Bearing whose wall yields to the film as a thin diaphragm.

    A bearing of 200 by 200 mm with a slot for the oil turns at a fixed eccentricity of 0.3; the diaphragm
    moves by more than the clearance. Pressure and displacement are those of the middle of the width. Beyond
    160°, where the film ruptures, the pressure is up to 12 % of the largest higher than in the figure.
    """
    grid = FilmGrid(100.0, 200.0, 90, 10)
    bore, dofs = _with_diaphragm(grid, size)
    bearing = Bearing(Reynolds(grid, Oil(9.29e-9)), 0.15, bore)
    state = _turning(bearing, 0.3, 500.0, 3e3, 8e3, 16e3, 28e3, slot=(-1, 2))  # up to 0°
    fields = {"pressure": 1e3 * state.film.pressure, "displacement": 1e3 * bore.functions @ state.bulge}
    why = "the target is read from a figure, in steps of 25 kPa"
    for row in records("freund1995_figure46b"):
        at, around = row["angle_deg"], fields[row["quantity"]][:, 0]
        computed = float(np.interp(math.radians(float(at)), grid.angle, around))
        yield Quantity(f"{row['quantity']} at {at}°", row["unit"], float(row["value"]), computed, 10.0, why)
    return dofs


class _Raised(Asperities):
    """Asperities whose summits lie 0.6 µm above the mean planes."""

    def pressure(self, gap: Floats) -> tuple[Floats, Floats]:
        return super().pressure(gap - 0.6e-3)


def _in_ring(diameter: float, width: float, outer: float, material: Material) -> Bearing:
    """A bearing of the rig in a ring in plane stress (Michell 1899, Lamé 1852)."""
    radius, nu = diameter / 2, material.poissons_ratio
    grid, functions = FilmGrid(radius, width, 72, 8, graded=1.0), BoreFunctions(radius, width)
    wider = radius / material.youngs_modulus * ((outer**2 + radius**2) / (outer**2 - radius**2) + nu)
    n = functions.terms[:, 0]
    bent = (displacement(material, radius, k) @ pressed(radius, outer, k) for k in range(2, n.max() + 1))
    yields, ends = np.array([wider, 0.0, *bent]), functions.at(grid.angle[:, None], grid.ends[None])
    compliance = np.diag(yields[np.concatenate([n, n[n > 0]])])
    bore = ElasticBore(functions.means(grid), np.moveaxis(np.concatenate(ends), 0, -1), compliance)
    rough = _Raised(math.hypot(0.13e-3, 0.28e-3), 1e-3 * 53.3e3, friction=0.02)
    return Bearing(Reynolds(grid, Oil(6.8e-9, 13e-3)), 1e-3 * radius, bore, rough)


@benchmark("Sander et al., Simulation of journal bearing friction in severe mixed lubrication", size=1.0)
def sander(_size: float) -> Quantities:
    """Torque of a rig, from full to mixed films.

    A big end of 47.8 by 17.2 mm runs at 10 MPa between two support bearings of 54 by 25 mm. Dimensions, oil,
    surfaces and the measured torque are published; clearances and the shapes of rod and supports are not:
    they are rings here, with an axial groove opposite to the load.
    """
    measured = {float(row["rpm"]): float(row["torque_Nm"]) for row in records("sander_torque")}
    torques, force = dict.fromkeys(measured, 0.0), 10.0 * 47.8 * 17.2
    rod = _in_ring(47.8, 17.2, 50.0, replace(STEEL, youngs_modulus=70e3))
    for bearing, load, count in ((rod, force, 1), (_in_ring(54.0, 25.0, 60.0, STEEL), force / 2, 2)):
        grid, state = bearing.reynolds.grid, bearing.start()
        supply = Supply(grid.groove(math.pi, 0.25), 0.1)
        for share, rpm in ((0.1, 3000.0), (0.5, 3000.0), *((1.0, rpm) for rpm in measured)):
            conditions = Conditions(rpm * math.pi / 30 * grid.radius, supply)
            state = bearing.solve(state, conditions, load=np.array([share * load, 0.0]))
            torques[rpm] += (share == 1) * count * state.friction[0] * grid.radius / 1e3
    why = "clearances and shapes are assumed"
    for rpm in (3000.0, 1000.0):
        yield Quantity(f"torque at {rpm:g} rpm", "N·m", measured[rpm], torques[rpm], 10.0, why)
    least, computed = (min(each, key=lambda rpm: each[rpm]) for each in (measured, torques))
    yield Quantity("speed of the least torque", "rpm", least, computed, 10.0, "it is one of those measured")
    return 0


def _mobility(across: float, along: float, ratio: float) -> tuple[float, float]:
    """Mobility of a short bearing, along the load and across it, at an eccentricity along and across it.

    `ratio`: width over diameter. Within 10 % of the integrals of its film, as a test checks.
    """
    near = max(1 - along, 0.0)
    least = near**1.5 / (math.pi * ratio**2)
    return least * near, -4 / math.pi * across * least


def _by_mobility(film: FilmCycle) -> Floats:
    """Thinnest film (n,), mm, by the Mobility method: short and rigid, viscosity and load of another film."""
    acting, bearing = film.acting, film.bearing
    grid, clearance = bearing.reynolds.grid, bearing.clearance
    ratio, viscosity = grid.width / (2 * grid.radius), bearing.reynolds.oil.viscosity
    scale = (clearance / grid.radius) ** 2 / (viscosity * grid.width * 2 * grid.radius)

    def velocity(time: float, place: Floats) -> list[float]:
        step, at = time / acting.period * acting.count, complex(*place)
        load = complex(*between(acting.load, step)[:2])
        direction = load / abs(load)
        seen = at * direction.conjugate()
        squeezed = scale * abs(load) * complex(*_mobility(seen.imag, seen.real, ratio)) * direction
        turned = 1j * float(between(acting.speed, step)) / (2 * grid.radius) * at
        return [(squeezed + turned).real, (squeezed + turned).imag]

    times = acting.period * (2 + np.arange(acting.count) / acting.count)
    most = (0.0, 3 * acting.period)
    found = solve_ivp(velocity, most, [0.0, 0.0], "LSODA", times, rtol=1e-6, atol=1e-9)
    return np.asarray(clearance * (1 - np.hypot(*found.y)))


@benchmark(
    "Bates & Benwell 1988, SAE 880679; Choi, Hur & Han 1993, SAE 930694: what their abstracts state",
    size=12.0,
)
def measured_trends(size: float) -> Quantities:
    """Big end of an engine, beside what was measured in two others.

    In a V6 of 2.8 litres the thinnest film occurred during induction and at high speed, and hardly depended
    on torque; in a four-cylinder engine it was below that of the Mobility method (Booth 1965) from 1500 to
    5500 rpm. Their dimensions are not stated: this is the V6 of 4.0 litres of the library, with its usual
    rod, clearance and oil. `size` is that of the rod's elements and, in proportion, of the film's cells.
    """
    study = parse_study(engine_study("ford-cologne-4.0"), "trends", Path.cwd())
    rod = prepare(Flags(size=size, tolerance=0.0).applied(study).with_(film={"oil": "5W-30"}))
    cells, width, steps = (round(count * 12.0 / size) for count in COARSE)
    slow, fast, throttled = ((2000.0, 1.0), (5500.0, 1.0), (5500.0, 0.4))  # rpm, share of the gas load
    films = {}
    for rpm, share in (slow, fast, throttled):
        table = replace(study.require_engine(), gas_scale=share)
        cycle = EngineLoading.of(table, rod.mesh.bores.rod_length).crank_cycle(rod.mass, rpm)
        films[rpm, share] = rod.films.coarse(cycle, (4 * round(cells / 4), width, steps))
    least = {at: float(film.thinnest.min()) for at, film in films.items()}
    course = films[fast].thinnest
    induction = float(course[: len(course) // 4].min())  # from the dead centre of gas exchange on
    below = sum(least[at] < _by_mobility(film).min() for at, film in films.items())
    name, exact = "thinnest film of the induction stroke over that of the cycle, 5500 rpm", "it is the same"
    yield Quantity(name, "1", 1.0, induction / least[fast], 0.1, exact)
    name = "thinnest film at full load over that at 40 % of the gas load, 5500 rpm"
    why = "torque is uncritical; 3 % is the standard error of their measurements"
    yield Quantity(name, "1", 1.0, least[fast] / least[throttled], 10.0, why)
    thinner = min((slow, fast), key=lambda at: least[at])[0]
    name, why = "speed of the thinner film at full load, 2000 or 5500 rpm", "it is one of both"
    yield Quantity(name, "rpm", fast[0], thinner, 0.1, why)
    name, why = "films of 3 that are thinner than by the Mobility method", "all of them, as measured"
    yield Quantity(name, "1", 3.0, float(below), 0.1, why)
    return rod.mesh.whole.points.size
