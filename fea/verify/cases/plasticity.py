"""Plastic flow without hardening against closed forms: sphere, beam, and a wall with a thermal gradient."""

from dataclasses import replace
from math import log

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from fea.plastic.cycling import PlasticAnswer, cycled
from fea.plastic.increment import ElasticBody, FlowState, at_rest, increment, projected
from fea.plastic.zone import Zone
from fea.solid.assembly import pattern, stiffness
from fea.solid.element import gauss_places, shape_functions
from fea.solid.parity import Parity
from fea.solid.stress import von_mises
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


class FlowingSphere:
    """An eighth of a hollow sphere, all of which may flow: elements of a size, mm, and half of it inside.

    `unit` is the displacement (1, n_nodes, 3), mm, of the elastic sphere under 1 MPa inside.
    """

    def __init__(self, size: float) -> None:
        fine = {Surface.INNER: LocalSize(size / 2)}
        self.mesh = mesh_body(eighth_ball(CAVITY, BALL, 4), size, fine=fine)
        self.zone, fixed = _all_elements(self.mesh), held(self.mesh, {}).ravel()
        K = stiffness(self.mesh, STEEL, pattern(self.mesh.tets, len(self.mesh.points)))
        self.body = ElasticBody(self.zone, {Parity.SYMMETRIC: (fixed, factorise(K.constrained(fixed)))})
        unit = self.body(traction_forces(self.mesh, Surface.INNER, pressure(1.0))[None])
        self.unit = projected(self.zone, self.body, YIELD * unit) / YIELD

    def pressed(self, *fronts: float) -> FlowState:
        """Return the state after pressures that should move the front of flow to these radii, mm."""
        state = at_rest(self.zone, 1)
        for front in fronts:
            state = increment(self.zone, self.body, sphere_pressure(front) * self.unit, state)
        return state


@benchmark("Hill 1950, The Mathematical Theory of Plasticity, chapter V, section 2", size=2.0, converges=True)
def plastic_sphere(size: float) -> Quantities:
    """Hollow sphere that flows to half its wall under internal pressure, and is unloaded.

    Outside the front c the sphere is elastic and at yield on the front, so that it widens by
    (1 − ν) σ_y c³ / (E b²). At the cavity, flow leaves the hoop stress σ_y − p, of which unloading takes the
    elastic one.
    """
    sphere, front = FlowingSphere(size), 15.0
    load, state = sphere_pressure(front), sphere.pressed(12.0, front)
    outside = np.unique(sphere.mesh.facets[Surface.OUTER])  # a zone of every element has every node in order
    moved = (load * sphere.unit + state.moved)[0, outside]
    widening = float((moved * sphere.mesh.points[outside] / BALL).sum(axis=1).mean())
    wanted = (1 - STEEL.poissons_ratio) * YIELD * front**3 / (STEEL.youngs_modulus * BALL**2)
    yield Quantity("widening outside, mean", "mm", wanted, widening, 3.0, _PROJECTED)
    # Von Mises stress, which is that of hoop less radial stress: σ_y where it flows, less the elastic one.
    radius = np.linalg.norm(_places(sphere.mesh), axis=-1)
    near = radius < 1.1 * CAVITY
    left = von_mises(sphere.zone.stress(0 * state.moved, state.moved, state.plastic))[near]
    elastic = 1.5 * load * (CAVITY / radius[near]) ** 3 / (1 - (CAVITY / BALL) ** 3)
    share = float((left / (elastic - YIELD)).mean())
    yield Quantity("residual von Mises stress over the exact one, inside", "1", 1.0, share, 3.0, _PROJECTED)
    return sphere.mesh.points.size


_PROJECTED = "one pressure for each element: the error falls with the size of the elements"


# A wall of which a slice is computed, with its curvature restrained.
DEPTH, SLICE = 2.0, 0.5


class BentSlice:
    """A slice of a beam or wall, ν = 0, x along it and y over its depth: its ends stay plane, one moves."""

    def __init__(self, size: float) -> None:
        names, half = (Surface.FREE, Surface.LOADED, Surface.FREE, Surface.CLAMPED), DEPTH / 2
        body = Prism(rectangle((0.0, SLICE), (-half, half), names), (0.0, SLICE))
        self.mesh = mesh = mesh_body(body, size)
        fixed = held(mesh, {Surface.CLAMPED: (0,)})
        fixed[np.abs(mesh.points).sum(axis=1).argmin(), 1] = True
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
        self.zone = _all_elements(mesh, 0.0)
        self.body = ElasticBody(self.zone, {Parity.SYMMETRIC: solver})

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


# Bree's regions by mean stress X and thermal stress Y over the yield strength: points 5 % and more from their
# borders X + Y = 1; Y = 2 and, of X above 1/2, Y = 4 (1 − X); of Y above 2, X Y = 1; X = 1.
_BREE = {
    PlasticAnswer.ELASTIC: ((0.3, 0.6),),
    PlasticAnswer.SHAKES_DOWN: ((0.3, 1.5), (0.6, 1.4), (0.8, 0.7), (0.45, 1.9)),
    PlasticAnswer.CYCLIC: ((0.2, 2.3), (0.3, 2.8), (0.4, 2.2)),
    PlasticAnswer.RATCHETS: ((0.6, 2.0), (0.5, 2.6), (0.8, 1.0)),
    PlasticAnswer.COLLAPSES: ((1.05, 0.0),),
}


@benchmark("Bree 1967, J. Strain Analysis 2, 226", size=0.4)
def bree(size: float) -> Quantities:
    """Wall under a steady mean stress and a thermal gradient that comes and goes, without hardening."""
    wall, right = BentSlice(size), list[bool]()
    for answer, points in _BREE.items():
        for primary, secondary in points:
            cases = [wall.elastic(primary * YIELD, secondary * YIELD * on) for on in (0.0, 1.0)]
            right.append(cycled(wall.zone, wall.body, cases).answer is answer)
    why = "points of the diagram that lie 5 % and more from its borders"
    yield Quantity("share of the points in the right region", "1", 1.0, float(np.mean(right)), 0.1, why)
    return wall.mesh.points.size
