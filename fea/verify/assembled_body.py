"""Separate parts that touch, with their bolts: the joined bodies of the benchmark cases."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from fea.base.choices import Support
from fea.base.material import Material, of_parts
from fea.contact.assembled import Assembled, TemperatureChange
from fea.contact.bolts import BoltPull
from fea.contact.friction_system import ContactState
from fea.contact.interfaces import MatingFaces
from fea.contact.problem import ContactProblem
from fea.solid.parity import Parity
from fea.solid.recovery import ElementStress, PartRecovery
from fea.solvers.static import Model
from fea.verify.body import rectangle
from geometry.arrays import Floats
from geometry.bodies import Body, Prism, SideBySide
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import Interfaces, TetMesh, numbered, separated

# From places (…, 3) to a measure (…,) that grows from part to part.
Measure = Callable[[Floats], Floats]


def along_x(places: Floats) -> Floats:
    """Measure of parts that lie beside each other."""
    return places[..., 0]


def radius(places: Floats) -> Floats:
    """Measure of parts that lie around each other."""
    return np.asarray(np.hypot(places[..., 0], places[..., 1]))


def parted(mesh: TetMesh, splits: Sequence[float], measure: Measure) -> TetMesh:
    """Number the parts of a mesh, which end where the measure reaches the `splits`."""
    furthest = measure(mesh.points)[mesh.tets[:, :4]].max(axis=1)
    part = np.searchsorted(np.asarray(splits) + 1e-9 * float(np.abs(splits).max()), furthest)
    return replace(mesh, part=part.astype(np.int64))


def apart(
    body: Body,
    size: float,
    splits: Sequence[float],
    measure: Measure,
    interfaces: Interfaces,
    *,
    order: int = 2,
) -> TetMesh:
    """Mesh a body and take it apart where the measure reaches the `splits`, as `parted`.

    Faces of elements lie where the parts touch; `interfaces` are named as for `mesh.tetmesh.separated`.
    """
    mesh = parted(mesh_body(body, size, order=order), splits, measure)
    return numbered(separated(mesh, interfaces)[0])[0]


def bars(ends: Sequence[float], width: tuple[float, float], height: float) -> SideBySide:
    """Bars one after another along x, from `Surface.BOLT_THREAD` to `Surface.BOLT_HEAD`.

    `ends` are the x where the first begins, where they touch and where the last ends, `width` the least and
    greatest y, mm. They are cut at `Surface.SYMMETRY_Z`.
    """

    def bar(number: int, first: float, last: float) -> Prism:
        start = Surface.BOLT_THREAD if number == 0 else Surface.FREE
        end = Surface.BOLT_HEAD if number == len(ends) - 2 else Surface.FREE
        return Prism(rectangle((first, last), width, (Surface.FREE, end, Surface.FREE, start)), (0.0, height))

    return SideBySide(tuple(bar(number, *pair) for number, pair in enumerate(pairwise(ends))))


class AssembledBody:
    """Parts that only contact, bolts and mirror planes hold, under loads that balance.

    The parts have no common nodes; `loads` (n_nodes, 3, n_loads), N, are symmetric about the mirror planes.
    """

    def __init__(
        self,
        mesh: TetMesh,
        materials: Sequence[Material],
        faces: Sequence[MatingFaces],
        bolts: Sequence[BoltPull],
        loads: Floats,
        *,
        friction: float = 0.0,
        preload: Sequence[float] = (),
        warming: TemperatureChange | None = None,
    ) -> None:
        self.mesh, self.materials = mesh, tuple(materials)
        self.model = Model(mesh, of_parts(materials, mesh.part), Support.INERTIA_RELIEF)
        self._loads = loads.reshape(mesh.points.size, -1)
        cut = Surface.SYMMETRY_Y in mesh.facets
        of_parity = {Parity.SYMMETRIC: self._loads, Parity.ANTISYMMETRIC: np.zeros_like(self._loads)}
        self.problem = ContactProblem(
            self.model, mesh, [], of_parity, both_sides=cut, faces=faces, bolts=bolts
        )
        nodes = [np.unique(mesh.tets[mesh.part == part]) for part in range(len(materials))]
        self.assembled = Assembled(self.problem, nodes, friction, np.array(preload), warming)

    @property
    def start(self) -> ContactState:
        """The parts put together."""
        return self.assembled.start

    def step(self, weights: Sequence[float] | Floats, state: ContactState | None = None) -> ContactState:
        """Go on from a state, or from the start, to weights (n_loads,) of the loads."""
        load = self.assembled.load([], np.array(weights))
        return self.assembled.steps().step(load, self.start if state is None else state)

    def stresses(self, state: ContactState) -> tuple[Floats, Floats, Floats]:
        """Pressures (n,) at the vertices of the first interface, and shear stresses along its tangents.

        Those that do not exist are zero.
        """
        mating = self.problem.faces[0]
        values = self._on_cell(state)[self.problem.own(0)]
        along, around = (np.where(at >= 0, values[at], 0.0) for at in mating.tangential)
        return values[: mating.pressing.size], along, around

    def tension(self, state: ContactState) -> Floats:
        """Force (n_bolts,) of each bolt of the cell, N."""
        return self._on_cell(state)[self.problem.starts[len(self.problem.faces)] :]

    def _on_cell(self, state: ContactState) -> Floats:
        return self.problem.unfolding.parts(state.values)[Parity.SYMMETRIC]

    def displacement(self, state: ContactState, weights: Sequence[float] | Floats | None = None) -> Floats:
        """Displacement (n_nodes, 3) of a state under weights (n_loads,) of the loads, mm."""
        applied = self._loads @ np.array(weights) if weights is not None else 0.0
        fixed, solve = self.model.restrained(Parity.SYMMETRIC)
        forces = np.where(fixed, 0.0, self.problem.forces @ self._on_cell(state) + applied)
        bent = solve(forces[:, None]).reshape(-1, 3)
        return np.asarray(bent + self.assembled.displacement(state)[Parity.SYMMETRIC])

    def stress(self, state: ContactState, weights: Sequence[float] | Floats | None = None) -> list[Floats]:
        """Nodal stress (n_nodes, 6) of each part, MPa; NaN outside the part.

        On the surfaces that the loads act on it is that of free ones.
        """
        u = self.displacement(state, weights)[..., None]
        traction = self.problem.traction(self._on_cell(state)[:, None])
        of_parts = self._recovery.nodal_stress(u, self.materials, Parity.SYMMETRIC, traction)
        return [stress[..., 0] for stress in of_parts]

    def gauss_stress(self, displacement: Floats) -> Floats:
        """Stress (n_elements, n_places, 6) at the integration points, of parts of one material, MPa."""
        return ElementStress(self.mesh)(displacement[..., None], self.materials[0])[..., 0]

    @cached_property
    def _recovery(self) -> PartRecovery:
        planes = self.mesh.planes
        return PartRecovery(self.mesh, tuple(s for s in self.mesh.facets if s not in planes))


def pulled(mesh: TetMesh, stiffness: float, *, share: float) -> BoltPull:
    """A bolt along x whose seats are all of `BOLT_THREAD`, at smaller x, and of `BOLT_HEAD`."""
    seats = {side: np.arange(len(mesh.facets[side])) for side in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    return BoltPull.of(mesh, seats, np.array([1.0, 0.0, 0.0]), stiffness, share=share)
