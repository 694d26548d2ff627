"""Plastic flow without hardening against closed forms: vessels, plate, beam, wall, bars and notched block."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import log

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from fea.plastic.cycling import PlasticAnswer, cycled
from fea.plastic.increment import (
    ElasticBody,
    FlowState,
    NoEquilibriumError,
    at_rest,
    increment,
    projected,
)
from fea.plastic.zone import Zone, equivalent_strain
from fea.solid.assembly import gauss_places, pattern, shape_functions, stiffness
from fea.solid.parity import Parity
from fea.solid.stress import von_mises
from fea.solid.traction import traction_forces
from fea.solvers.direct import factorise
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import (
    STEEL,
    eighth_ball,
    held,
    pressure,
    quarter_ring,
    rectangle,
    straightened,
    uniform,
)
from geometry.arrays import Floats, Mask
from geometry.bodies import Prism, Side, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body
from mesh.tetmesh import TetMesh

YIELD = STEEL.yield_strength


_ELASTIC, _SETTLES, _CYCLIC, _RATCHETS = (
    PlasticAnswer.ELASTIC,
    PlasticAnswer.SHAKES_DOWN,
    PlasticAnswer.CYCLIC,
    PlasticAnswer.RATCHETS,
)


def _all_elements(
    mesh: TetMesh, poissons_ratio: float = STEEL.poissons_ratio, strength: float = YIELD
) -> Zone:
    every = np.arange(len(mesh.tets))
    material = replace(STEEL, poissons_ratio=poissons_ratio)
    return Zone.of(mesh, material, np.zeros_like(every), every, np.full(len(every), strength))


def _places(mesh: TetMesh) -> Floats:
    """Places (n_elements, n_points, 3) of the Gauss points."""
    values, _ = shape_functions(mesh.tets.shape[1], gauss_places(mesh.tets.shape[1]).T)
    return np.asarray(values @ mesh.points[mesh.tets])


CAVITY, BALL = 10.0, 20.0


def sphere_pressure(front: float) -> float:
    """Pressure, MPa, in a hollow sphere that has flowed up to the radius `front`, mm; exact for any ν."""
    return 2 * YIELD * (log(front / CAVITY) + (1 - (front / BALL) ** 3) / 3)


SPHERE_LIMIT = 2 * YIELD * log(BALL / CAVITY)


class FlowingBody:
    """A body, all of which may flow, held at degrees of freedom (n_nodes, 3), under a traction on a surface.

    `unit` is the displacement (1, n_nodes, 3), mm, of the elastic body under 1 MPa; `most` of that may act.
    """

    def __init__(
        self,
        mesh: TetMesh,
        supports: Mapping[Surface, tuple[int, ...]],
        loaded: tuple[Surface, Callable[[Floats, Floats], Floats]],
        most: float,
        poissons_ratio: float = STEEL.poissons_ratio,
    ) -> None:
        self.mesh, self.zone = mesh, _all_elements(mesh, poissons_ratio)
        fixed, material = held(mesh, supports).ravel(), replace(STEEL, poissons_ratio=poissons_ratio)
        K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
        self.body = ElasticBody(self.zone, {Parity.SYMMETRIC: (fixed, factorise(K.constrained(fixed)))})
        unit, self._most = self.body(traction_forces(mesh, *loaded)[None]), most
        self.unit = projected(self.zone, self.body, most * unit) / most

    def flowed(self, *loads: float) -> FlowState:
        """Return the state after loads, MPa."""
        state = at_rest(self.zone, 1)
        for load in loads:
            state = increment(self.zone, self.body, load * self.unit, state)
        return state

    def carried(self, *shares: float) -> float:
        """Return the largest of these rising shares of `most`, MPa, that it carries."""
        state, carried = at_rest(self.zone, 1), 0.0
        for share in shares:
            try:
                state = increment(self.zone, self.body, share * self._most * self.unit, state)
            except NoEquilibriumError:
                break
            carried = share * self._most
        return carried

    def pulsating(self, share: float) -> PlasticAnswer:
        """Say what a share of the shakedown load leads to, twice that at first yield, that comes and goes.

        Gauss points lie inside the elements: the load is raised by what they miss.
        """
        stress = YIELD * self.zone.usage(self.unit, self.zone.virgin).max()
        load = share * 2 * YIELD / stress * self.unit
        return cycled(self.zone, self.body, [load, 0 * load]).answer

    def beside_shakedown(self) -> Quantity:
        """Share of the right answers beside the shakedown load."""
        answers = [self.pulsating(share) for share in (0.99, 1.01)]
        right = np.mean([found is wanted for found, wanted in zip(answers, (_SETTLES, _CYCLIC), strict=True)])
        name, why = "share of right answers beside the shakedown limit", "loads 1 % below and beyond it"
        return Quantity(name, "1", 1.0, float(right), 0.1, why)


class FlowingSphere(FlowingBody):
    """An eighth of a hollow sphere under pressure inside: elements of a size, mm, and half of it inside."""

    def __init__(self, size: float) -> None:
        fine = {Surface.INNER: LocalSize(size / 2)}
        mesh = mesh_body(eighth_ball(CAVITY, BALL, 4), size, fine=fine)
        super().__init__(mesh, {}, (Surface.INNER, pressure(1.0)), SPHERE_LIMIT)


@benchmark("Hill 1950, The Mathematical Theory of Plasticity, chapter V, section 2", size=2.5, converges=True)
def plastic_sphere(size: float) -> Quantities:
    """Hollow sphere that flows to half its wall under internal pressure, and is unloaded; its limits.

    Outside the front c the sphere is elastic and at yield on the front, so that it widens by
    (1 − ν) σ_y c³ / (E b²); inside, the equivalent plastic strain is 2 (1 − ν) σ_y / E (c³/r³ − 1). At the
    cavity, flow leaves the hoop stress σ_y − p, of which unloading takes the elastic one.
    """
    sphere, front = FlowingSphere(size), 15.0
    load, state = sphere_pressure(front), sphere.flowed(sphere_pressure(12.0), sphere_pressure(front))
    outside = np.unique(sphere.mesh.facets[Surface.OUTER])  # a zone of every element has every node in order
    moved = (load * sphere.unit + state.moved)[0, outside]
    widening = float((moved * sphere.mesh.points[outside] / BALL).sum(axis=1).mean())
    wanted = (1 - STEEL.poissons_ratio) * YIELD * front**3 / (STEEL.youngs_modulus * BALL**2)
    yield Quantity("widening outside, mean", "mm", wanted, widening, 1.0, _FALLS)
    radius = np.linalg.norm(_places(sphere.mesh), axis=-1)
    yield Quantity("radius of the front", "mm", front, _front(radius, 3, state), 1.0, _FALLS)
    # Von Mises stress, which is that of hoop less radial stress: σ_y where it flows, less the elastic one.
    near = radius < 1.1 * CAVITY
    left = von_mises(sphere.zone.stress(0 * state.moved, state.moved, state.plastic))[near]
    elastic = 1.5 * load * (CAVITY / radius[near]) ** 3 / (1 - (CAVITY / BALL) ** 3)
    share = float((left / (elastic - YIELD)).mean())
    yield Quantity("residual von Mises stress over the exact one, inside", "1", 1.0, share, 1.0, _FALLS)
    return sphere.mesh.points.size


def _front(radius: Floats, power: int, state: FlowState) -> float:
    """Return the radius at which the plastic strain vanishes, which is a line in 1/r to the `power`."""
    strain = equivalent_strain(state.plastic)
    slope, at_zero = np.polyfit(radius[strain > 0] ** -power, strain[strain > 0], 1)
    return float((-slope / at_zero) ** (1 / power))


_FALLS = "the error falls with the size of the elements, but not from each mesh to the next"


@benchmark("Hill 1950, The Mathematical Theory of Plasticity, chapter V; Melan 1938", size=3.0)
def sphere_limits(size: float) -> Quantities:
    """Hollow sphere at the pressure at which all of it flows, and beside its shakedown limit.

    The one is 2 σ_y ln(b/a), the other twice the pressure at first yield: beyond it flow never ends.
    """
    sphere = FlowingSphere(size)
    carried = sphere.carried(0.7, 0.9, 0.96, 0.98, 0.99, 0.995, 1.0, 1.005, 1.01, 1.015)
    yield Quantity("limit pressure", "MPa", SPHERE_LIMIT, carried, 1.0, "steps of half a per cent")
    yield sphere.beside_shakedown()
    return sphere.mesh.points.size


# Radii of a cylinder in plane strain; thick enough to flow back when it is unloaded (b/a above 2.22).
_BORE, _OUTSIDE = 10.0, 25.0
# Yield strength in plane strain of a material that keeps its volume (von Mises), MPa.
_PLANE = 2 / 3**0.5 * YIELD


@benchmark("Hill 1950, The Mathematical Theory of Plasticity, chapter V; Melan 1938", size=3.0)
def plastic_cylinder(size: float) -> Quantities:
    """Thick cylinder in plane strain that flows to half its wall under internal pressure; its limits.

    With σ_p = 2 σ_y/√3 the pressure at the front c is σ_p (ln(c/a) + (1 − c²/b²)/2): exact for von Mises if
    the elastic strain keeps the volume, too, and here for ν = 0.49. Outside of the front the cylinder is
    elastic and widens by (1 − ν²) σ_p c² / (E b). Autofrettage beyond twice the pressure at first yield flows
    back as it is unloaded; limits do not depend on ν.
    """
    fine, section = {Surface.INNER: LocalSize(size / 2)}, quarter_ring(_BORE, _OUTSIDE)
    mesh = mesh_body(Prism(section, (0.0, size / 2), top=Surface.ROLLER), size, fine=fine)
    supports, loaded = {Surface.ROLLER: (2,)}, (Surface.INNER, pressure(1.0))
    limit, front, ratio = _PLANE * log(_OUTSIDE / _BORE), 17.5, 0.49
    soft = FlowingBody(mesh, supports, loaded, limit, ratio)
    loads = [_PLANE * (log(c / _BORE) + (1 - (c / _OUTSIDE) ** 2) / 2) for c in (13.0, front)]
    state, outside = soft.flowed(*loads), np.unique(mesh.facets[Surface.OUTER])
    radius = np.linalg.norm(_places(mesh)[..., :2], axis=-1)
    yield Quantity("radius of the front", "mm", front, _front(radius, 2, state), 1.0, _FALLS)
    moved = (loads[-1] * soft.unit + state.moved)[0, outside, :2]
    widening = float((moved * mesh.points[outside, :2] / _OUTSIDE).sum(axis=1).mean())
    wanted = (1 - ratio**2) * _PLANE * front**2 / (STEEL.youngs_modulus * _OUTSIDE)
    yield Quantity("widening outside, mean", "mm", wanted, widening, 1.0, _FALLS)
    steel = FlowingBody(mesh, supports, loaded, limit)
    carried = steel.carried(0.7, 0.9, 0.96, 0.98, 0.99, 0.995, 1.0, 1.005, 1.01, 1.015)
    yield Quantity("limit pressure", "MPa", limit, carried, 1.0, "steps of half a per cent")
    yield steel.beside_shakedown()
    return mesh.points.size


@benchmark("Brady & Drucker 1953, Proc. ASCE 79, separate 296", size=1.5)
def plastic_plate(size: float) -> Quantities:
    """Thin plate with a hole, pulled until its net section flows.

    σ_y in straight strips beside the hole and nothing before and behind it is in equilibrium, and necks from
    the hole to the sides dissipate no more: both limit theorems give σ_y (1 − d/w), for von Mises, too.
    """
    hole, half, quarter = 4.0, 10.0, np.pi / 2
    sides = (
        Side(Line((hole, 0.0), (1.5 * half, 0.0)), Surface.SYMMETRY_Y),
        Side(Line((1.5 * half, 0.0), (1.5 * half, half)), Surface.LOADED),
        Side(Line((1.5 * half, half), (0.0, half)), Surface.FREE),
        Side(Line((0.0, half), (0.0, hole)), Surface.SYMMETRY_X),
        Side(Arc((0.0, 0.0), hole, quarter, -quarter), Surface.INNER),
    )
    mesh = mesh_body(Prism(sides, (0.0, 0.5)), size, fine={Surface.SYMMETRY_X: LocalSize(size / 2)})
    limit = YIELD * (1 - hole / half)
    plate = FlowingBody(mesh, {}, (Surface.LOADED, uniform(1.0, 0.0, 0.0)), limit)
    carried = plate.carried(0.6, 0.8, 0.9, 0.96, 0.98, 0.99, 1.0, 1.005, 1.01, 1.015, 1.02, 1.03)
    yield Quantity("mean stress that it carries", "MPa", limit, carried, 1.5, "steps of half a per cent")
    return mesh.points.size


# A wall of which a slice is computed, with its curvature restrained.
DEPTH, SLICE = 2.0, 0.5


def _with_plane_end(mesh: TetMesh, fixed: Mask) -> tuple[Zone, ElasticBody]:
    """Return a body, ν = 0, held at degrees of freedom (n_nodes, 3), whose loaded end moves as a plane."""
    end = np.zeros_like(fixed)
    end[mesh.facets[Surface.LOADED], 0] = True
    # Displacements of unit unknowns: those of the nodes, and one of the end that moves.
    own, together = np.flatnonzero(~(fixed | end).ravel()), np.flatnonzero(end.ravel())
    columns = np.concatenate([np.arange(len(own)), np.full(len(together), len(own))])
    entries = np.ones(len(columns)), (np.concatenate([own, together]), columns)
    T = sparse.csc_array(sparse.coo_array(entries, shape=(fixed.size, len(own) + 1)))
    material = replace(STEEL, poissons_ratio=0.0)
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points))).full()
    factor = splu(sparse.csc_array(T.T @ K @ T))
    solver = np.zeros(fixed.size, dtype=bool), lambda forces: T @ factor.solve(T.T @ forces)
    zone = _all_elements(mesh, 0.0)
    return zone, ElasticBody(zone, {Parity.SYMMETRIC: solver})


class BentSlice:
    """A slice of a beam or wall, ν = 0, x along it and y over its depth: its ends stay plane, one moves."""

    def __init__(self, size: float) -> None:
        names, half = (Surface.FREE, Surface.LOADED, Surface.FREE, Surface.CLAMPED), DEPTH / 2
        body = Prism(rectangle((0.0, SLICE), (-half, half), names), (0.0, SLICE))
        mesh = mesh_body(body, size)
        # Thin layers at both faces, so that the outermost Gauss points lie close to them.
        graded = mesh.points * (1.0, 0.0, 1.0) + np.sin(np.pi / DEPTH * mesh.points) * (0.0, half, 0.0)
        self.mesh = mesh = replace(mesh, points=straightened(graded, mesh.tets))
        fixed = held(mesh, {Surface.CLAMPED: (0,)})
        fixed[np.abs(mesh.points).sum(axis=1).argmin(), 1] = True
        self.zone, self.body = _with_plane_end(mesh, fixed)

    def elastic(self, axial: float, bending: float) -> Floats:
        """Displacement (1, n_nodes, 3), mm, of the elastic slice: mean and largest bending stress, MPa."""
        mesh = self.mesh
        x, y, _ = mesh.points.T
        bent = np.zeros(mesh.points.shape)
        bent[:, 0] = -bending / STEEL.youngs_modulus * x * y / (DEPTH / 2)
        bent[:, 1] = bending / STEEL.youngs_modulus * x**2 / DEPTH
        pulled = traction_forces(mesh, Surface.LOADED, lambda places, _: np.eye(3)[:1] * axial + 0 * places)
        return self.body(pulled[None]) + bent

    def moment(self, state: FlowState, u: Floats) -> float:
        """Mean bending moment over that at first yield."""
        y = _places(self.mesh)[..., 1]
        axial = self.zone.stress(u, state.moved, state.plastic)[..., 0]
        first = YIELD * (y**2 * self.zone.volumes).sum() / (DEPTH / 2)
        return float(abs((axial * y * self.zone.volumes).sum()) / first)


@benchmark("Budynas & Nisbett 2011, section 3-10; M/M_y = 1.5 − 0.5 (κ_y/κ)²", size=0.3)
def plastic_hinge(size: float) -> Quantities:
    """Rectangular beam bent to twice and three times the curvature at first yield."""
    beam = BentSlice(size)
    state = at_rest(beam.zone, 1)
    for times in (2, 3):
        u = beam.elastic(0.0, times * YIELD)
        state = increment(beam.zone, beam.body, u, state)
        name, wanted = f"moment at {times} times the curvature", 1.5 - 0.5 / times**2
        yield Quantity(
            name, "1", wanted, beam.moment(state, u), 0.5, "ten Gauss points and more over the depth"
        )
    return beam.mesh.points.size


#: Points of Bree's borders by mean stress X and thermal stress Y over the yield strength, with what happens
#: below and beyond: X + Y = 1; Y = 2 and, of X above 1/2, Y = 4 (1 − X); of Y above 2, X Y = 1.
_BREE = {
    (0.2, 0.8): (_ELASTIC, _SETTLES),
    (0.7, 0.3): (_ELASTIC, _SETTLES),
    (0.1, 2.0): (_SETTLES, _CYCLIC),
    (0.4, 2.0): (_SETTLES, _CYCLIC),
    (0.6, 1.6): (_SETTLES, _RATCHETS),
    (0.8, 0.8): (_SETTLES, _RATCHETS),
    (0.45, 1 / 0.45): (_CYCLIC, _RATCHETS),
    (0.36, 1 / 0.36): (_CYCLIC, _RATCHETS),
}
#: Likewise of two bars, one of which is heated: X + Y = 1, X + Y / 2 = 1, and without a mean stress Y = 2.
_TWO_BARS = {
    (0.4, 0.6): (_ELASTIC, _SETTLES),
    (0.2, 1.6): (_SETTLES, _RATCHETS),
    (0.7, 0.6): (_SETTLES, _RATCHETS),
    (0.0, 2.0): (_SETTLES, _CYCLIC),
}
_Borders = Mapping[tuple[float, float], tuple[PlasticAnswer, PlasticAnswer]]


def _beside(body: "BentSlice | TwoBars", borders: _Borders) -> Quantity:
    """Share of the right answers 2 % below and beyond borders, the second stress coming and going."""
    right = list[bool]()
    for (steady, pulsating), answers in borders.items():
        for share, answer in zip((0.98 * YIELD, 1.02 * YIELD), answers, strict=True):
            cases = [body.elastic(share * steady, share * pulsating * on) for on in (0.0, 1.0)]
            right.append(cycled(body.zone, body.body, cases).answer is answer)
    name, why = "share of right answers", "loads of 2 % less and more than on the borders of the diagram"
    return Quantity(name, "1", 1.0, float(np.mean(right)), 0.1, why)


@benchmark("Bree 1967, J. Strain Analysis 2, 226", size=0.4)
def bree(size: float) -> Quantities:
    """Wall under a steady mean stress and a thermal gradient that comes and goes, without hardening."""
    wall = BentSlice(size)
    yield _beside(wall, _BREE)
    return wall.mesh.points.size


class TwoBars:
    """Two equal bars, ν = 0, x along them, whose ends at `Surface.LOADED` move together."""

    def __init__(self, size: float) -> None:
        names = (Surface.SYMMETRY_Y, Surface.LOADED, Surface.FREE, Surface.CLAMPED)
        bar = mesh_body(Prism(rectangle((0.0, 1.0), (0.0, 1.0), names), (0.0, 1.0)), size)
        count = len(bar.points)
        facets = {name: np.concatenate([each, each + count]) for name, each in bar.facets.items()}
        self.mesh = TetMesh(np.tile(bar.points, (2, 1)), np.concatenate([bar.tets, bar.tets + count]), facets)
        self.zone, self.body = _with_plane_end(self.mesh, held(self.mesh, {Surface.CLAMPED: (0,)}))

    def elastic(self, axial: float, thermal: float) -> Floats:
        """Displacement (1, n_nodes, 3), mm, that stresses the bars: mean, and ± thermal stress, MPa."""
        strain = np.repeat([axial + thermal, axial - thermal], len(self.mesh.points) // 2)
        strain /= STEEL.youngs_modulus
        return np.asarray((self.mesh.points * (1.0, 0.0, 0.0) * strain[:, None])[None])


@benchmark("Melan 1938; by equilibrium and the yield condition", size=1.0)
def two_bars(size: float) -> Quantities:
    """Two bars that share a steady force, one of which is heated and cools, without hardening.

    Residual stress ± ρ shakes the bars down if |X + Y + ρ|, |X + ρ| and |X − Y − ρ|, |X − ρ| are at most 1:
    with ρ = −Y/2 if X + Y/2 is at most 1. Beyond, they grow longer in turns, however small X is.
    """
    bars = TwoBars(size)
    yield _beside(bars, _TWO_BARS)
    return bars.mesh.points.size


# Half the ligament between the notches, and half of width and height of the block: notches deeper than 0.884
# of the half width do not change the limit load (Ewing & Hill 1967).
_LIGAMENT, _BLOCK = 1.0, 9.0
# A yield strength, MPa, at which the plastic strain stays small.
_WEAK = YIELD / 100


def notched(size: float) -> tuple[TetMesh, Mask]:
    """A quarter of a block with two deep notches, in plane strain, and what holds it and pulls at its end."""
    corners = ((0.0, 0.0), (_LIGAMENT, 0.0), (_BLOCK, 0.0), (_BLOCK, _BLOCK), (0.0, _BLOCK))
    names = Surface.SYMMETRY_Y, Surface.FREE, Surface.OUTER, Surface.LOADED, Surface.SYMMETRY_X
    body = Prism(polygon(*zip(corners, names, strict=True)), (0.0, size), top=Surface.ROLLER)
    mesh = mesh_body(body, _BLOCK / 3, fine={Surface.SYMMETRY_Y: LocalSize(size)})
    return mesh, held(mesh, {Surface.ROLLER: (2,), Surface.LOADED: (1,)})


@benchmark("Prandtl 1920; Nagtegaal, Parks & Rice 1974", size=0.18)
def notched_block(size: float) -> Quantities:
    """Block with two deep notches, pulled in plane strain until the ligament between them flows.

    It carries a mean stress of (2 + π) k, k = σ_y/√3; the mean of the principal stresses is largest in the
    ligament, (1 + π) k. Elements that cannot keep their volume carry more and more.
    """
    mesh, fixed = notched(size)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    solver = fixed.ravel(), factorise(K.constrained(fixed.ravel()))
    zone = _all_elements(mesh, strength=_WEAK)
    body, pulled = ElasticBody(zone, {Parity.SYMMETRIC: solver}), np.zeros((1, *mesh.points.shape))
    end = np.unique(mesh.facets[Surface.LOADED])
    pulled[0, end, 1] = _WEAK / STEEL.youngs_modulus
    far = 96.0 * (pulled + body(-(K @ pulled.ravel()).reshape(pulled.shape)))
    far, state = projected(zone, body, far), at_rest(zone, 1)
    for times in (8, 16, 32, 48, 64, 96):
        state = increment(zone, body, times / 96 * far, state)
    stress, limit = zone.stress(far, state.moved, state.plastic), (2 + np.pi) / 3**0.5 * _WEAK
    carried = float(zone.forces(stress, 1)[0, end, 1].sum()) / (_LIGAMENT * size)
    yield Quantity(
        "mean stress in the ligament", "MPa", limit, carried, 2.0, "6 % with elements three times as large"
    )
    mean, wanted = float(stress[..., :3].mean(axis=-1).max()), (1 + np.pi) / 3**0.5 * _WEAK
    why = "near the tips of the notches; without a projection of the volumetric strain, four times as much"
    yield Quantity("largest mean of the principal stresses", "MPa", wanted, mean, 10.0, why)
    return mesh.points.size
