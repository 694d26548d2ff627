"""Plastic flow without hardening against closed forms: sphere, beam, and a wall with a thermal gradient."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import log

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from fea.plastic.cycling import PlasticAnswer, cycled
from fea.plastic.increment import ElasticBody, FlowState, NoEquilibriumError, at_rest, increment
from fea.plastic.zone import Zone
from fea.solid.assembly import pattern, stiffness
from fea.solid.element import gauss_places, shape_functions
from fea.solid.parity import Parity
from fea.solid.stress import matrices
from fea.solid.traction import traction_forces
from fea.solvers.direct import factorise
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import STEEL, eighth_ball, held, pressure, rectangle
from geometry.arrays import Floats
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body
from mesh.tetmesh import TetMesh

YIELD = STEEL.yield_strength


def _all_elements(mesh: TetMesh, poissons_ratio: float = STEEL.poissons_ratio) -> Zone:
    every = np.arange(len(mesh.tets))
    material = replace(STEEL, poissons_ratio=poissons_ratio)
    return Zone.of(mesh, material, np.zeros_like(every), every, np.full(len(every), YIELD))


def _places(mesh: TetMesh) -> Floats:
    """Places (n_elements, n_points, 3) of the Gauss points."""
    values, _ = shape_functions(mesh.tets.shape[1], gauss_places(mesh.tets.shape[1]).T)
    return np.asarray(values @ mesh.points[mesh.tets])


CAVITY, BALL = 10.0, 20.0


def sphere_pressure(front: float) -> float:
    """Pressure, MPa, in a hollow sphere that has flowed up to the radius `front`, mm; exact for any ν."""
    return 2 * YIELD * (log(front / CAVITY) + (1 - (front / BALL) ** 3) / 3)


@dataclass(frozen=True)
class FlowingSphere:
    """An eighth of a hollow sphere, all of which may flow."""

    size: float  #: of the elements outside, mm; inside half of it

    @cached_property
    def mesh(self) -> TetMesh:
        """Its mesh."""
        fine = {Surface.INNER: LocalSize(self.size / 2)}
        return mesh_body(eighth_ball(CAVITY, BALL, 4), self.size, fine=fine)

    @cached_property
    def zone(self) -> Zone:
        """Every element."""
        return _all_elements(self.mesh)

    @cached_property
    def body(self) -> ElasticBody:
        """The elastic sphere."""
        mesh, fixed = self.mesh, held(self.mesh, {}).ravel()
        K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
        return ElasticBody(self.zone, {Parity.SYMMETRIC: (fixed, factorise(K.constrained(fixed)))})

    @cached_property
    def unit(self) -> Floats:
        """Displacement (1, n_nodes, 3), mm, of the elastic sphere under 1 MPa inside."""
        inside = traction_forces(self.mesh, Surface.INNER, pressure(1.0))
        return self.body(inside[None])

    def pressed(self, *fronts: float) -> FlowState:
        """Return the state after pressures that should move the front of flow to these radii, mm."""
        state = at_rest(self.zone, 1)
        for front in fronts:
            state = increment(self.zone, self.body, sphere_pressure(front) * self.unit, state)
        return state

    def carries(self, load: float) -> bool:
        """Whether equilibrium is found at a pressure, MPa."""
        state = at_rest(self.zone, 1)
        try:
            for share in np.linspace(0.5, 1.0, 4):
                state = increment(self.zone, self.body, share * load * self.unit, state)
        except NoEquilibriumError:
            return False
        return True


@benchmark("Hill 1950, The Mathematical Theory of Plasticity, chapter V, section 2", size=2.0, converges=True)
def plastic_sphere(size: float) -> Quantities:
    """Hollow sphere that flows to half its wall under internal pressure, and is unloaded.

    Outside the front c the sphere is elastic and at yield on the front, so that it widens by
    (1 − ν) σ_y c³ / (E b²). At the cavity, flow leaves the hoop stress σ_y − p, of which unloading takes the
    elastic one.
    """
    sphere, front = FlowingSphere(size), 15.0
    zone, load = sphere.zone, sphere_pressure(front)
    state = sphere.pressed(12.0, front)
    outside = np.unique(sphere.mesh.facets[Surface.OUTER])  # a zone of every element has every node in order
    moved = (load * sphere.unit + state.moved)[0, outside]
    widening = float((moved * sphere.mesh.points[outside] / BALL).sum(axis=1).mean())
    wanted = (1 - STEEL.poissons_ratio) * YIELD * front**3 / (STEEL.youngs_modulus * BALL**2)
    yield Quantity("widening outside, mean", "mm", wanted, widening, 3.0, _PROJECTED)
    # Hoop less radial stress: σ_y where it flows, less that of the elastic sphere, 3/2 p a³/r³ b³/(b³ − a³).
    radius = np.linalg.norm(_places(sphere.mesh), axis=-1)
    near = radius < 1.1 * CAVITY
    left = hoop_less_radial(zone, state, _places(sphere.mesh))[near]
    elastic = 1.5 * load * (CAVITY / radius[near]) ** 3 / (1 - (CAVITY / BALL) ** 3)
    share = float((left / (YIELD - elastic)).mean())
    name = "residual hoop less radial stress over the exact one, inside"
    yield Quantity(name, "1", 1.0, share, 2.0, _PROJECTED)
    return sphere.mesh.points.size


def hoop_less_radial(zone: Zone, state: FlowState, places: Floats) -> Floats:
    """Hoop less radial stress (n_elements, n_points), MPa, that flow leaves in a sphere without load."""
    outward = places / np.linalg.norm(places, axis=-1, keepdims=True)
    tensor = matrices(zone.stress(0 * state.moved, state.moved, state.plastic))
    radial = np.einsum("epi,epij,epj->ep", outward, tensor, outward)
    return np.asarray((np.trace(tensor, axis1=-2, axis2=-1) - radial) / 2 - radial)


_PROJECTED = "one pressure for each element: the error falls with the size of the elements"


# A wall of which a slice is computed, with its curvature restrained.
DEPTH, SLICE = 2.0, 0.5


@dataclass(frozen=True)
class BentSlice:
    """A slice of a beam or wall, ν = 0, whose ends stay plane: one is held, one moves along x."""

    size: float  #: of the elements, mm

    @cached_property
    def mesh(self) -> TetMesh:
        """Its mesh: x along the beam, y over its depth."""
        names = (Surface.FREE, Surface.LOADED, Surface.FREE, Surface.CLAMPED)
        half = DEPTH / 2
        return mesh_body(Prism(rectangle((0.0, SLICE), (-half, half), names), (0.0, SLICE)), self.size)

    @cached_property
    def zone(self) -> Zone:
        """Every element."""
        return _all_elements(self.mesh, 0.0)

    @cached_property
    def _movable(self) -> sparse.csc_array:
        """Displacements (n, m) of unit unknowns: those of the nodes, and one of the end that moves."""
        mesh = self.mesh
        kept, end = np.zeros((2, *mesh.points.shape), dtype=bool)
        kept[mesh.facets[Surface.CLAMPED], 0] = True
        kept[mesh.facets[Surface.SYMMETRY_Z], 2] = True
        corner = int(np.abs(mesh.points).sum(axis=1).argmin())
        kept[corner, 1] = True
        end[mesh.facets[Surface.LOADED], 0] = True
        free = np.flatnonzero(~(kept | end).ravel())
        together = np.flatnonzero(end.ravel())
        rows = np.concatenate([free, together])
        columns = np.concatenate([np.arange(len(free)), np.full(len(together), len(free))])
        return sparse.csc_array((np.ones(len(rows)), (rows, columns)), shape=(end.size, len(free) + 1))

    @cached_property
    def _K(self) -> sparse.csr_array:
        mesh, material = self.mesh, replace(STEEL, poissons_ratio=0.0)
        return sparse.csr_array(stiffness(mesh, material, pattern(mesh.tets, len(mesh.points))).full())

    @cached_property
    def body(self) -> ElasticBody:
        """The elastic slice."""
        T = self._movable
        factor = splu(sparse.csc_array(T.T @ self._K @ T))
        free = np.zeros(T.shape[0], dtype=bool)
        solver = free, lambda forces: T @ factor.solve(T.T @ forces)
        return ElasticBody(self.zone, {Parity.SYMMETRIC: solver})

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


@benchmark("Budynas & Nisbett 2011, section 3-10; M/M_y = 1.5 − 0.5 (κ_y/κ)²", size=0.4)
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


def bree_region(primary: float, secondary: float) -> PlasticAnswer:
    """Bree's regions by mean stress X and thermal stress Y over the yield strength (Bree 1967)."""
    if primary > 1:
        return PlasticAnswer.COLLAPSES
    if primary + secondary <= 1:
        return PlasticAnswer.ELASTIC
    if secondary <= (2 if primary <= 0.5 else 4 * (1 - primary)):
        return PlasticAnswer.SHAKES_DOWN
    reverses = secondary > 2 and primary * secondary <= 1
    return PlasticAnswer.CYCLIC if reverses else PlasticAnswer.RATCHETS


def bree_points() -> Iterator[tuple[float, float]]:
    """Points of the diagram, none within 5 % of a border."""
    yield from (
        (0.3, 0.6),
        (0.3, 1.5),
        (0.6, 1.4),
        (0.2, 2.3),
        (0.6, 2.0),
        (0.3, 2.8),
        (0.5, 2.6),
        (0.8, 1.0),
    )
    yield from ((0.8, 0.7), (1.05, 0.0), (0.45, 1.9), (0.4, 2.2))


@benchmark("Bree 1967, J. Strain Analysis 2, 226", size=0.4)
def bree(size: float) -> Quantities:
    """Wall under a steady mean stress and a thermal gradient that comes and goes, without hardening."""
    wall, right, points = BentSlice(size), 0, list(bree_points())
    for primary, secondary in points:
        cases = [wall.elastic(primary * YIELD, secondary * YIELD * on) for on in (0.0, 1.0)]
        right += cycled(wall.zone, wall.body, cases).answer is bree_region(primary, secondary)
    why = "points of the diagram that lie 5 % and more from its borders"
    yield Quantity("share of the points in the right region", "1", 1.0, right / len(points), 0.1, why)
    return wall.mesh.points.size
