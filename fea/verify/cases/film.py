"""The oil film of rigid bearings, and how a ring yields to one: charts, tables and closed forms."""

import math

import numpy as np

from fea.base.choices import Support
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing, JournalState
from fea.film.oil import Oil
from fea.film.reynolds import Conditions, Reynolds, Supply
from fea.pins.yielding import unit_forces, works
from fea.solid.bore import bore_facets
from fea.solvers.static import Model
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import STEEL, half_ring
from fea.verify.michell import displacement, pressed
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body

# A journal, mm and rad/s, and its oil, MPa·s: the figures compared do not depend on them.
_RADIUS, _CLEARANCE, _OMEGA, _VISCOSITY = 25.0, 0.025, 300.0, 1e-8
# The oil is supplied without pressure: with so little of it, MPa, that no figure changes.
_NO_PRESSURE = 1e-4
# Cells along half the width by the length of a cell around the bore, mm.
_ALONG = 16.0


def _bearing(ratio: float, size: float) -> Bearing:
    """A bearing of a width over diameter, with cells of a length around the bore."""
    cells = 4 * round(2 * math.pi * _RADIUS / size / 4)
    grid = FilmGrid(_RADIUS, 2 * _RADIUS * ratio, cells, max(4, round(_ALONG / size)))
    return Bearing(Reynolds(grid, Oil(_VISCOSITY)), _CLEARANCE)


def _turning(bearing: Bearing, eccentricity: float) -> JournalState:
    """A journal displaced towards −x that turns; the oil is supplied where the gap is widest, at 0°."""
    grid = bearing.reynolds.grid
    supply = Supply(grid.groove(0.0, 2 * math.pi / grid.n_angle), _NO_PRESSURE)
    start = bearing.start((-eccentricity * _CLEARANCE, 0.0))
    return bearing.solve(start, Conditions(_OMEGA * _RADIUS, supply))


def _force(bearing: Bearing, state: JournalState) -> tuple[float, float]:
    """The film's force, N, and its angle behind the narrowest gap, degrees."""
    x, y = bearing.reynolds.grid.resultant(state.film.pressure)
    return math.hypot(x, y), 180 - math.degrees(math.atan2(y, x))


def _size(bearing: Bearing) -> int:
    return math.prod(bearing.reynolds.grid.shape)


# Width over diameter; h₀/c; Sommerfeld number, attitude, (r/c) f: as printed in charts of three digits.
_RAIMONDI = (
    (1.0, 0.8, 0.631, 74.02, 12.8),
    (1.0, 0.4, 0.121, 50.58, 3.22),
    (1.0, 0.2, 0.0446, 36.24, 1.70),
    (1.0, 0.1, 0.0188, 26.45, 1.05),
    (0.5, 0.8, 2.03, 74.94, 40.9),
    (0.5, 0.4, 0.319, 48.14, 8.10),
    (0.5, 0.2, 0.0923, 33.31, 3.26),
    (0.5, 0.1, 0.0313, 23.66, 1.60),
)


@benchmark("Raimondi & Boyd 1958, ASLE Transactions 1, 159-209, parts I-III", size=1.1)
def raimondi_boyd(size: float) -> Quantities:
    """Full journal bearing."""
    for ratio, thinnest, sommerfeld, attitude, friction in _RAIMONDI:
        bearing = _bearing(ratio, size)
        state = _turning(bearing, 1 - thinnest)
        force, behind = _force(bearing, state)
        mean = force / (4 * ratio * _RADIUS**2)
        number = _VISCOSITY * _OMEGA / (2 * math.pi) / mean * (_RADIUS / _CLEARANCE) ** 2
        # The partly filled gap is sheared like a full one, as they assume.
        resists, _ = bearing.reynolds.friction(state.film, state.gap, _OMEGA * _RADIUS, full_shear=True)
        at, three = f"L/D {ratio:g}, h0/c {thinnest:g}", "the figures are printed with three digits"
        rubbing = resists / force * _RADIUS / _CLEARANCE
        angle = "half a degree: finite differences of 1958"
        yield Quantity(f"Sommerfeld number, {at}", "1", sommerfeld, number, 1.0, three)
        yield Quantity(f"attitude, {at}", "°", attitude, behind, 50.0 / attitude, angle)
        yield Quantity(f"(r/c) f, {at}", "1", friction, rubbing, 1.0, three)
    return _size(bearing)


# So = Fψ²/(BDηω) of rotation and of squeezing (ε̇ in place of ω), by B/D and eccentricity.
_RATIOS = (1.0, 1 / 2, 1 / 3, 1 / 5)
_ROTATION = {
    0.1: (0.1196, 0.0368, 0.0171, 0.0063),
    0.5: (0.8903, 0.3124, 0.1522, 0.0579),
    0.8: (3.5663, 1.7339, 0.9687, 0.4085),
    0.9: (8.4352, 5.0881, 3.2201, 1.5261),
}
_SQUEEZE = {
    -0.5: (0.971, 0.2664, 0.1211, 0.0442),
    0.0: (2.4076, 0.7224, 0.3355, 0.1238),
    0.5: (9.7319, 3.675, 1.8236, 0.7005),
    0.9: (160.25, 104.75, 68.484, 33.102),
}


@benchmark(
    "Butenschön 1976, Das hydrodynamische, zylindrische Gleitlager endlicher Breite unter instationärer "
    "Belastung, thesis, Karlsruhe",
    size=1.6,
)
def butenschoen(size: float) -> Quantities:
    """Bearing of finite width, rotating and squeezed."""
    swift = 100.0  # clearances per second, from a full film
    why = "the figures are results of finite differences, and agree with others within 1 %"
    for kind, table in (("rotation", _ROTATION), ("squeeze", _SQUEEZE)):
        for eccentricity, row in table.items():
            for ratio, target in zip(_RATIOS, row, strict=True):
                bearing = _bearing(ratio, size)
                place, rate = (-eccentricity * _CLEARANCE, 0.0), _OMEGA
                if kind == "rotation":
                    state = _turning(bearing, eccentricity)
                else:
                    state, rate = bearing.squeezed(place, (-swift * _CLEARANCE, 0.0)), swift
                force, _ = _force(bearing, state)
                psi, area = _CLEARANCE / _RADIUS, 4 * ratio * _RADIUS**2
                number = force * psi**2 / (area * _VISCOSITY * rate)
                name = f"So, {kind}, B/D {ratio:.2g}, ε {eccentricity:g}"
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


# Width over diameter, Sommerfeld number, eccentricity, attitude.
_LUND = (
    (0.5, 1.656, 0.244, 65.85),
    (0.5, 0.580, 0.477, 51.01),
    (0.5, 0.244, 0.655, 40.25),
    (1.0, 0.991, 0.150, 70.58),
    (1.0, 0.235, 0.460, 49.27),
    (1.0, 0.108, 0.650, 39.72),
)


@benchmark(
    "Lund & Thomsen 1978, in Topics in Fluid Film Bearing and Rotor Bearing System Design, ASME, 1-28",
    size=1.6,
)
def lund_thomsen(size: float) -> Quantities:
    """Bearing with two axial grooves."""
    close = "within 0.01: how the table agrees with other programs"
    turned = "within 1°: a hundredth of the eccentricity turns the lightly loaded journal by as much"
    for ratio, number, eccentricity, attitude in _LUND:
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
    mesh = mesh_body(ring, size, fine={Surface.INNER: Fine(size / 2)})
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
