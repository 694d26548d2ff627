"""Pins without friction: Persson's pin, a roller, the patch test of contact, the elastic pin, an eye."""

import math
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.integrate import quad
from scipy.optimize import brentq

from fea.base.material import Material
from fea.contact.active_set import FrictionlessState
from fea.contact.elastic_pin import ElasticPin, Pin
from fea.contact.interfaces import Multipliers, PinInBore, radial
from fea.contact.problem import ContactProblem
from fea.solid.assembly import pattern, stiffness
from fea.solid.bore import bore_facets, bore_load
from fea.solid.parity import Parity
from fea.solid.stress import principal
from fea.solvers.direct import direct_solver
from fea.solvers.static import displacement, unheld
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import (
    STEEL,
    SolvedBody,
    furthest,
    half_ring,
    held,
    hoop_stress,
    nodes_of,
    rectangle,
    uniform,
)
from fea.verify.cases.elasticity import ROUNDING, SHAKE, shaken
from geometry.arrays import Floats, Mask
from geometry.bodies import Prism, Side, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from loads.bearing import BorePressure, PressureArc
from mesh.generate import LocalSize, mesh_body
from mesh.tetmesh import TetMesh

ALUMINIUM = Material(70e3, 0.3, 2.7e-9, 400.0)
_CUT, _FREE, _INNER, _OUTER = Surface.SYMMETRY_Y, Surface.FREE, Surface.INNER, Surface.OUTER


class _TouchedBody:
    """A body, symmetric about y = 0, with its constraints and the one pin that touches it.

    The constrained degrees of freedom `fixed` (n_nodes, 3) include those of the mirror planes.
    """

    def __init__(self, mesh: TetMesh, material: Material, fixed: Mask, pin: PinInBore) -> None:
        self.mesh, self._material, self._fixed, self._pin = mesh, material, fixed.ravel(), pin
        self._solver = direct_solver(slots=1)
        nothing = {Parity.SYMMETRIC: np.zeros((mesh.points.size, 0))}
        self.problem = ContactProblem(self, mesh, [pin], nothing, both_sides=False)

    def compliance(self, _parity: Parity, forces: sparse.csc_array) -> Floats:
        """Work (k, k) of symmetric forces (3 n_nodes, k) on what they cause."""
        K = stiffness(self.mesh, self._material, pattern(self.mesh.tets, len(self.mesh.points)))
        return self._solver.condense(0, K.constrained(self._fixed), unheld(forces, self._fixed))

    def touched(self, clearance: float, force: float) -> FrictionlessState:
        """Pressures (n,) at the vertices under a force along x on the whole body, N."""
        gap = self.problem.initial + (clearance - self._pin.clearance) * self._weights
        return self.problem.system.solve(gap, np.array([force]))

    @cached_property
    def _weights(self) -> Floats:
        return self.problem.unfolding.moments({Parity.SYMMETRIC: self._pin.multipliers.weights})

    def stress(self, pressure: Floats) -> Floats:
        """Nodal stress (n_nodes, 6) under pressures (n,), MPa."""
        n_nodes = len(self.mesh.points)
        forces = np.where(self._fixed, 0.0, self.problem.forces @ pressure)
        u = self._solver.solve(0, forces[:, None]).reshape(n_nodes, 3, 1)
        pressed = self.problem.traction(pressure[:, None])
        return SolvedBody(self.mesh, self._material, u, tuple(pressed), pressed).stress


def _contact_end(place: Floats, p: Floats) -> float:
    """Where the pressure (n,) at places (n,) ends: near it, its square is linear."""
    places = np.unique(np.round(place, 9))
    mean = np.array([p[np.abs(place - at) < 1e-8].mean() for at in places])
    last = np.flatnonzero(mean > 0)[-4:-1]
    return float(np.polyfit(mean[last] ** 2, places[last], 1)[1])


def _plane_strain(mesh: TetMesh) -> Mask:
    """Hold the outside in x and y, and both faces of a slice in z."""
    fixed, z = held(mesh, {_OUTER: (0, 1)}), mesh.points[:, 2]
    fixed[z > z.max() * (1 - 1e-9), 2] = True
    return fixed


# Persson's elastic pin in the hole of a large plate of the same material, plane strain; mm, N/mm.
_RADIUS, _PLATE, _FORCE = 10.0, 600.0, 1000.0


def _half_angle(X: float) -> float:
    """Half of the arc of contact, rad (Persson 1964)."""

    def off(angle: float) -> float:
        square = math.tan(angle / 2) ** 2
        return (2 - math.log(square + 1) - 2 * square**2) / (math.pi * square * (square + 1)) - X

    return float(brentq(off, math.radians(5), math.radians(170)))


def _pressure(X: float, theta: float) -> float:
    """P R / Q at an angle from the force, rad (Persson 1964)."""
    b, y = math.tan(_half_angle(X) / 2), math.tan(theta / 2)
    root, left = math.sqrt(b * b + 1), math.sqrt(max(b * b - y * y, 0.0))
    smooth = 2 * left / (math.pi * root * (1 + y * y))
    return float(smooth + math.log((root + left) / (root - left)) / (2 * math.pi * b * b * (b * b + 1)))


def _largest_hoop(X: float) -> float:
    """σ_θ R / Q where the contact ends."""
    end = _half_angle(X)
    mean = float(quad(lambda theta: _pressure(X, theta), 0, end)[0]) / math.pi
    kappa = 3 - 4 * STEEL.poissons_ratio
    return 2 * mean + 2 * kappa / (kappa + 1) / math.pi * math.cos(end)


def _steel_pin(mesh: TetMesh) -> PinInBore:
    height = float(mesh.points[:, 2].max())
    pin = Pin(_RADIUS, 0.0, height, None, STEEL.youngs_modulus, STEEL.poissons_ratio)
    multipliers = Multipliers.of(mesh, _INNER, radial(0.0))
    return PinInBore(multipliers, (0.0, 0.0), 0.0, pin, cut_y=True, cut_z=True)


def _persson_figures(body: _TouchedBody, material: Material, X: float) -> tuple[float, float, float]:
    """P R / Q, half angle, degrees, and hoop R / Q, at their largest."""
    clearance = X * _FORCE / (material.youngs_modulus / (1 - material.poissons_ratio**2))
    points, bore = body.mesh.points, body.mesh.facets[_INNER]
    on_bore, vertices = np.unique(bore), np.unique(bore[:, :3])
    p = body.touched(clearance, _FORCE * 2 * float(points[:, 2].max())).pressure
    end = math.degrees(_contact_end(np.arctan2(points[vertices, 1], points[vertices, 0]), p))
    hoop = hoop_stress(points[on_bore], body.stress(p)[on_bore])
    return float(p.max() * _RADIUS / _FORCE), end, float(hoop.max() * _RADIUS / _FORCE)


@benchmark("Persson 1964, plane strain, pin and plate of the same material", size=0.06)
def persson(size: float) -> Quantities:
    """Pin in a plate: contact with clearance and interference.

    Every fit of a plate with one factorisation, on half of a slice with elements of `size` at the hole.
    The pressure depends on X = E' ΔR / Q alone, with ΔR the difference of the radii, Q the force per
    thickness and E' = E / (1 − ν²): X = 0 is a neat fit, X < 0 a press fit that has not lifted off all the
    way round. With b the tangent of a quarter of the contact's arc, Persson gives X and the pressure in
    closed form. The stress around the hole follows from the pressure's Fourier coefficients p₀ and p₁
    (Michell 1899): σ_θ = −p + 2 p₀ + 2 κ / (κ + 1) p₁ cos θ with κ = 3 − 4 ν and p₁ = Q / (π R). It is
    largest where the contact ends, where its slope is infinite: hence the small elements.
    """
    plate = Prism(half_ring(_RADIUS, _PLATE), (0.0, size))
    mesh = mesh_body(plate, _PLATE / 10, fine={_INNER: LocalSize(size)})
    pin, fixed = _steel_pin(mesh), _plane_strain(mesh)
    steel, aluminium = (_TouchedBody(mesh, material, fixed, pin) for material in (STEEL, ALUMINIUM))
    large = "the plate is a ring, sixty times as large as the hole; the rest is the mesh"
    vertices, steep = "half a degree: the distance of two vertices", "its slope is infinite at its peak"
    for X in (5.0, 2.0, 1.0, 0.5, 0.2, 0.0, -0.2, -0.4):
        p, end, hoop = _persson_figures(steel, STEEL, X)
        angle = math.degrees(_half_angle(X))
        yield Quantity(f"p R / Q, X = {X:g}", "1", _pressure(X, 0.0), p, 0.5, large)
        yield Quantity(f"half angle, X = {X:g}", "°", angle, end, 50 / angle, vertices)
        yield Quantity(f"hoop R / Q, X = {X:g}", "1", _largest_hoop(X), hoop, 1.0, steep)
    # A steel pin in aluminium, X with the E' of the plate: p R / Q, half angle and hoop R / Q by collocation
    # of the integral equation, to three digits.
    digits = "the target has three digits"
    for X, (pressure, angle, around) in {1.0: (0.751, 55.1, 0.592), 0.0: (0.604, 82.4, 0.464)}.items():
        p, end, hoop = _persson_figures(aluminium, ALUMINIUM, X)
        pair = "steel in aluminium"
        yield Quantity(f"{pair}: p R / Q, X = {X:g}", "1", pressure, p, 1.0, digits)
        yield Quantity(f"{pair}: half angle, X = {X:g}", "°", angle, end, 100 / angle, digits)
        yield Quantity(f"{pair}: hoop R / Q, X = {X:g}", "1", around, hoop, 1.0, digits)
    one, thousand = (steel.touched(0.0, force).pressure for force in (1.0, 1e3))
    why = "the contact of a neat fit does not depend on the size of the force; only rounding errors remain"
    name, ratio = "pressures of 1000 N over those of 1 N, neat fit", thousand[one > 0] / one[one > 0]
    yield Quantity(name, "1", 1000.0, furthest(ratio, 1e3), 1e-7, why)
    return mesh.points.size


_ROLLER = 50.0  # radius, mm


class _RollerOnBlock(PinInBore):
    """A roller beside a body instead of in a bore: the gap is that of their shapes."""

    def initial(self) -> Floats:
        """Moments (n,) of the distance from the roller, which touches the side of the block."""
        away = self.multipliers.places[..., :2] - [self.center[0], 0.0]
        return self.multipliers.moments(np.linalg.norm(away, axis=-1) - _ROLLER)


@benchmark("Konter 2006 (NAFEMS R0094), benchmark 1; Hertz 1881", size=0.3)
def roller(size: float) -> Quantities:
    """NAFEMS R0094-1: steel roller on an aluminium block.

    A steel roller pressed onto an aluminium block, plane strain, no friction.
    The targets are those of Hertz for a cylinder and a half-space. The roller is the elastic pin of
    `fea.contact`, whose surface curves away from the flat side of the block.
    """
    force, depth, half_width, near = 35e3, 200.0, 100.0, 12.0  # N/mm, mm
    corners = (
        ((0.0, 0.0), _CUT),
        ((depth, 0.0), _OUTER),
        ((depth, half_width), _FREE),
        ((0.0, half_width), _FREE),
        ((0.0, near), _INNER),
    )
    mesh = mesh_body(Prism(polygon(*corners), (0.0, size)), 20.0, fine={_INNER: LocalSize(size, near)})
    steel = (210e3, 0.3)
    pin = Pin(_ROLLER, 0.0, size, None, *steel)
    multipliers = Multipliers.of(mesh, _INNER, radial(-_ROLLER))
    touching = _RollerOnBlock(multipliers, (-_ROLLER, 0.0), 0.0, pin, cut_y=True, cut_z=True, harmonics=512)
    p = _TouchedBody(mesh, ALUMINIUM, _plane_strain(mesh), touching).touched(0.0, force * 2 * size).pressure
    y = mesh.points[np.unique(mesh.facets[_INNER][:, :3]), 1]
    both = (steel, (ALUMINIUM.youngs_modulus, ALUMINIUM.poissons_ratio))
    half = math.sqrt(4 * force * _ROLLER * sum((1 - nu**2) / E for E, nu in both) / math.pi)
    why = "Hertz's half-space is sixteen times as wide as the contact here, and his cylinder is a parabola"
    peak = 2 * force / (math.pi * half)
    yield Quantity("half the width of contact", "mm", half, _contact_end(y, p), 2.0, why)
    yield Quantity("largest pressure", "MPa", peak, float(p.max()), 2.0, why)
    return mesh.points.size


class _PlateOnBlock(PinInBore):
    """A flat rigid plate instead of a pin."""

    def shifted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of a unit shift along x, and of none."""
        return self.multipliers.weights, np.zeros(self.multipliers.size)


@benchmark("Taylor & Papadopoulos 1991, On a patch test for contact problems in two dimensions", size=0.2)
def contact_patch(size: float) -> Quantities:
    """Contact patch test on an irregular mesh."""
    width, height, force = 0.6, 0.5, 100.0
    exact = force / (4 * width * height)  # a rigid plate that presses on the end of a block
    for order in (1, 2):
        sides = rectangle((0.0, 1.0), (0.0, width), (_CUT, _OUTER, _FREE, _INNER))
        mesh = shaken(mesh_body(Prism(sides, (0.0, height)), size, order=order), SHAKE * size)
        multipliers = Multipliers.of(mesh, _INNER, uniform(1.0, 0.0, 0.0))
        plate = _PlateOnBlock(multipliers, (0.0, 0.0), 0.0, None, cut_y=True, cut_z=True)
        body = _TouchedBody(mesh, STEEL, held(mesh, {_OUTER: (0,)}), plate)
        pressure = body.touched(0.0, force).pressure
        fields = {"contact pressure": pressure, "axial stress": -body.stress(pressure)[:, 0]}
        for what, values in fields.items():
            name, worst = f"P{order} {what} / F/A, worst node", furthest(values / exact, 1.0)
            yield Quantity(name, "1", 1.0, worst, 1e-8, ROUNDING)
    return mesh.points.size


# The elastic pin: modulus, MPa, Poisson's ratio, and the radius of slices, mm.
E, NU, SLICE = 206e3, 0.3, 10.0


def pressed_pin(pin: Pin, order: int) -> tuple[Floats, Floats, Floats]:
    """Stations and inward displacements there, mm, under 1 MPa cos nφ on the contact, and on the supports."""
    half = ElasticPin(pin)
    (harmonic,) = half.harmonics(np.array([order]))
    z = half.stations
    load = np.zeros(len(z))
    for first in range(0, len(z) - 2, 2):  # Simpson's rule along the quadratic elements
        load[first : first + 3] += (z[first + 2] - z[first]) * np.array([1, 4, 1]) / 6
    around = math.pi * (1 + (order == 0))
    return z, harmonic.compliance @ (around * pin.radius * load), harmonic.carried


def solid_slice(order: int) -> float:
    """Inward displacement, mm, of a solid slice under cos nφ of 1 MPa, n ≥ 2 (Michell 1899)."""
    n, mu = order, E / (2 * (1 + NU))
    # Airy's function (A rⁿ + B rⁿ⁺²) cos nφ with a radial traction of −cos nφ and no shear at the surface.
    a, b = np.linalg.solve([[n * (1 - n), n + 2 - n * n], [n * (n - 1), n * (n + 1)]], [-1.0, 0.0])
    return float((a * n - b * (2 - 4 * NU - n)) * SLICE / (2 * mu))


def _sag(inner: float) -> tuple[float, float]:
    """Sag, mm, between the middle and four fifths of the half width: of a pin, and of Timoshenko's beam."""
    slender, touched, span, boss = 5.0, 25.0, 100.0, 2.0  # radius, half the bore, to the boss, its length
    z, inward, carried = pressed_pin(Pin(slender, inner, touched, (span, span + boss), E, NU), 1)
    deflection = inward - touched / boss * carried  # the bosses carry what the bore presses with
    last = int(np.flatnonzero(z <= 0.8 * touched)[-1])
    x, force = float(z[last]), math.pi * slender * touched  # on half of the pin
    area, inertia = math.pi * (slender**2 - inner**2), math.pi / 4 * (slender**4 - inner**4)
    m = inner / slender
    shear = 6 * (1 + NU) * (1 + m**2) ** 2 / ((7 + 6 * NU) * (1 + m**2) ** 2 + (20 + 12 * NU) * m**2)
    q, moment = force / touched, force * (span + boss / 2) - force * touched / 2
    bent = (moment * x**2 / 2 - q * x**4 / 24) / (E * inertia)
    return float(deflection[0] - deflection[last]), bent + q * x**2 / 2 / (shear * E / (2 * (1 + NU)) * area)


@benchmark(
    "Michell 1899; Timoshenko 1940, Strength of Materials II; Cowper 1966 (shear coefficients)", size=1.0
)
def elastic_pin(_size: float) -> Quantities:
    """Elastic pin: harmonics, ovalisation, bending."""
    exact = "the closed form is exact; the rest is the mesh of the pin"
    thin = "the closed form neglects stretching and shear, of the order of the square of wall over radius"
    beam = "Timoshenko's beam, whose sections stay plane; the pin is ten times as long as thick"
    ratios = []
    for n in (2, 9):
        slice_ = pressed_pin(Pin(SLICE, 0.0, 4.0, None, E, NU), n)[1].mean() / solid_slice(n)
        ratios.append((f"deflection of a solid slice under p cos {n}φ", slice_, 0.2, exact))
    # Inward displacement of a thin long ring under cos 2φ of 1 MPa (Timoshenko 1940, article 78).
    wall = 0.2
    oval = SLICE * (SLICE - wall / 2) ** 3 * (1 - NU**2) / (E * wall**3 / 12 * 9)
    ring = pressed_pin(Pin(SLICE, SLICE - wall, 4.0, None, E, NU), 2)[1].mean() / oval
    ratios.append(("ovalisation of a ring", ring, 1.0, thin))
    for inner in (0.0, 3.5):
        sag, bent = _sag(inner)
        ratios.append((f"sag of a pin with a bore of {2 * inner:g} mm", sag / bent, 1.0, beam))
    for what, ratio, tolerance, why in ratios:
        yield Quantity(f"{what} / exact", "1", 1.0, float(ratio), tolerance, why)
    return 0  # the pin meshes itself


@benchmark("reference calculation with curved second-order tetrahedra and averaged stress", size=1.0)
def pin_loaded_eye(size: float) -> Quantities:
    """Pin-loaded eye, d/W = 0.5, round end.

    Eye with a round end, pulled by its pin: effect of the assumed pressure on the peak stress.
    The eye is flat, with a thickness of half the bore diameter and a bore of half its width; the strip is
    held far away. The peak is the largest principal stress on the bore over the mean stress P/((W − d) t) of
    the net section.
    """
    radius, outside, length, half_thickness, force = 10.0, 20.0, 100.0, 5.0, 10e3
    sides = (
        Side(Line((-length, 0.0), (-radius, 0.0)), _CUT),
        Side(Arc((0.0, 0.0), radius, math.pi, -math.pi), _INNER),
        Side(Line((radius, 0.0), (outside, 0.0)), _CUT),
        Side(Arc((0.0, 0.0), outside, 0.0, math.pi / 2), _OUTER),
        Side(Line((0.0, outside), (-length, outside)), _FREE),
        Side(Line((-length, outside), (-length, 0.0)), Surface.CLAMPED),
    )
    mesh = mesh_body(Prism(sides, (0.0, half_thickness)), 6 * size, fine={_INNER: LocalSize(size)})
    fixed, bore = held(mesh, {Surface.CLAMPED: (0,)}), bore_facets(mesh, _INNER, 0.0)
    net = force / (2 * (outside - radius) * 2 * half_thickness)
    why = (
        "the reference is an earlier calculation with three digits and stress averaged over elements; it "
        "does not state its thickness, which was chosen here to agree (in plane strain the cosine pressures "
        "give 3 to 4 % less)"
    )
    jump = f"{why}; this pressure jumps where the stress has its peak"
    factors = {
        "cosine-180": (3.23, 1.0, why),
        "cosine-120": (3.89, 1.0, why),
        "uniform-180": (2.68, 3.0, jump),
    }
    resultants = []
    for name, (factor, tolerance, reason) in factors.items():
        arc = BorePressure.parse(name).tension
        peak = arc.peak(force, radius, 2 * half_thickness)

        def pressure(psi: Floats, peak: float = peak, arc: PressureArc = arc) -> Floats:
            return peak * arc.unbounded(psi)

        load = bore_load(bore, len(mesh.points), (force, 0.0), pressure, arc.angle / 2)
        u = displacement(mesh, STEEL, load.forces.symmetric, fixed)
        pressed = {_INNER: load.traction.symmetric[:, :, None]}
        body = SolvedBody(mesh, STEEL, u, (_INNER, _OUTER, _FREE), pressed)
        stress = float(principal(body.stress[nodes_of(mesh, _INNER)])[:, 0].max() / net)
        yield Quantity(f"peak stress / net stress, {name}", "1", factor, stress, tolerance, reason)
        resultants.append(4 * load.forces.symmetric[:, 0].sum() / force)
    why = (
        "the pressure is scaled so that the nodal forces have the resultant of the force; only rounding "
        "errors remain"
    )
    resultant = furthest(np.array(resultants), 1.0)
    yield Quantity("resultant / pin force", "1", 1.0, resultant, 1e-10, why)
    return mesh.points.size
