"""From the unknowns of an assembly to the figures of its bolts and interfaces."""

from copy import copy
from functools import cached_property

import numpy as np

from fea.contact.assembled import Assembled
from fea.contact.assembly_state import AssemblyState, BoltBeam, BoltState, FaceState
from fea.contact.bolts import BoltBending
from fea.contact.friction_system import ContactState
from fea.contact.problem import ContactProblem
from fea.solid.parity import Parity, ParityPair
from geometry.arrays import Floats, Ints, Mask, vector
from geometry.surfaces import Surface

# Distance of vertices from the bore, over its radius, within which they are on its edge.
_ON_EDGE = 1e-4


class AssemblyStates:
    """Sums up steps of an assembly. `bolts` (n, 3): where the axes of the cell's bolts meet the joint, mm."""

    def __init__(
        self, assembled: Assembled, friction: float, bolts: Floats, bending: BoltBending, big_radius: float
    ) -> None:
        self._assembled, self._friction, self._bending = assembled, friction, bending
        problem = assembled.problem
        self._names = [Surface(face.name) for face in problem.faces]
        both = problem.unfolding.both_sides
        self._bolts = np.concatenate([bolts, bolts * [1.0, -1.0, 1.0]]) if both else bolts
        pulls, stops = problem.bolts[: problem.pulls], problem.bolts[problem.pulls :]
        self._count = [round(2 * bolt.share) if problem.cut_z else 1 for bolt in pulls]
        self._sheared = np.array([stop.area for stop in stops])
        away = np.hypot(*assembled.vertices.place[:, :2].T)
        joint = self._names.index(Surface.JOINT) if Surface.JOINT in self._names else -1
        near = np.abs(away - big_radius) < _ON_EDGE * big_radius
        self._joint = assembled.vertices.face == joint
        self._edge = self._joint & near

    def of(self, assembled: Assembled, beam: BoltBeam | None = None) -> "AssemblyStates":
        """Return what sums up states of the parts under another preload, or with other bolts in the seats."""
        other = copy(self)
        other._assembled, other._bending = assembled, self._bending.of(assembled, beam)  # noqa: SLF001
        return other

    def held(self, state: ContactState) -> tuple[Floats, Floats]:
        """Return what holds the heads of the bolts: see `BoltBending.held`."""
        return self._bending.held(state)

    def open_share(self, state: ContactState) -> float:
        """Share of the joint's area that is open."""
        opened = state.guess.opened[: len(self._joint)]
        return _share(self._assembled.vertices.area[self._joint], opened[self._joint])

    def __call__(self, state: ContactState, *known: Floats) -> AssemblyState:
        """Sum up one state; `known`: what `vertices` says of it, if that is at hand."""
        forces, beam = state.values[self._assembled.bolts], self._bending.beam
        counts, bent_by = np.resize(self._count, len(forces)), self._bending.moments(state)
        bearing = np.resize(self._sheared, len(self._assembled.stops)) * state.values[self._assembled.stops]
        shear = bearing.reshape(-1, 2).max(axis=1) if bearing.size else np.zeros(len(forces))
        bolts = []
        for at, force, count, moments, cut in zip(self._bolts, forces, counts, bent_by, shear, strict=True):
            head, thread = np.hypot(*moments).tolist()
            stress = beam.bending(moments)
            bent = np.hypot(*stress.T)
            bolts.append(
                BoltState(
                    vector(at),
                    float(force),
                    int(count),
                    float(bent.max()),
                    (float(stress[0, 0]), float(stress[0, 1])),
                    float((force / beam.areas + bent).max()),
                    (head, thread),
                    float(max(cut, 0.0)),
                )
            )
        known = known or self.vertices(state)
        faces = {name: self._face(number, state, *known) for number, name in enumerate(self._names)}
        return AssemblyState(tuple(bolts), faces)

    def vertices(self, state: ContactState) -> tuple[Floats, Floats]:
        """Pressure (k,), MPa, and mean gap (k,), mm, about `Assembled.vertices`; 0 where there is none."""
        vertices, opened = self._assembled.vertices, state.guess.opened[: len(self._position)]
        pressure = np.where(opened, 0.0, np.maximum(state.values[vertices.normal], 0.0))
        return pressure, np.where(opened, state.gap[self._position] / vertices.area, 0.0)

    @cached_property
    def _position(self) -> Ints:
        """Of the normal gaps (k,) among those of all interfaces."""
        return np.searchsorted(self._assembled.interface, self._assembled.vertices.normal)

    def _face(self, number: int, state: ContactState, *known: Floats) -> FaceState:
        vertices = self._assembled.vertices
        mine = np.flatnonzero(vertices.face == number)
        area, pressure, gap = (values[mine] for values in (vertices.area, *known))
        opened, slipping = state.guess.opened[mine], state.guess.slipping[mine]
        force, widest = float(pressure @ area), int(gap.argmax())
        plane = self._names[number] is Surface.JOINT
        edge = self._edge[mine]
        slipped = self._assembled.slipped(state.gap - self._assembled.tightened.gap)[mine]  # since assembly
        slip = np.hypot(*slipped.T)
        return FaceState(
            area=float(area.sum()),
            force=force,
            min_pressure=float(pressure.min()),
            max_pressure=float(pressure.max()),
            open_share=_share(area, opened),
            opening=float(gap[widest]),
            opening_at=vector(vertices.place[mine[widest]]) if gap[widest] > 0 else None,
            slipping_share=_share(area[~opened], slipping[~opened]),
            slip=float(np.where(opened, 0.0, slip).max()),
            shear=float(np.linalg.norm(self._shear(mine, state))) if plane else 0.0,
            friction=self._friction * force,
            edge_pressure=float(pressure[edge].min()) if edge.any() else None,
        )

    def _shear(self, mine: Ints, state: ContactState) -> Floats:
        """Resultant (2,) along the tangents of a plane interface, N.

        Of a shear stress at an image across y = 0 the direction is the image of the tangent: the second one
        reverses. About z = 0 stresses along z cancel.
        """
        problem, vertices = self._assembled.problem, self._assembled.vertices
        at = vertices.shear[mine]
        stress = np.where(at >= 0, state.values[at], 0.0)
        image = vertices.normal[mine] >= len(problem.unfolding.on_y)
        stress[:, 1] *= np.where(image, -1.0, 1.0)
        sums = vertices.area[mine] @ stress
        return np.asarray(sums * [0.0 if problem.cut_z else 1.0, 1.0])


def _share(area: Floats, mask: Mask) -> float:
    total = float(area.sum())
    return float(area[mask].sum() / total) if total > 0 else 0.0


def gap_at_nodes(problem: ContactProblem, normal: Ints, gap: Floats) -> ParityPair:
    """Gap (n_nodes,) on both sides of interfaces: mm, 0 elsewhere; where two of them meet, that of the joint.

    `normal` (k,) unknowns that are pressures between parts; `gap` (k,) at their places, mm.
    """
    every = np.zeros(problem.unfolding.size)
    every[normal] = gap
    parts = {}
    for parity, part in problem.unfolding.parts(every).items():
        parts[parity] = np.zeros(len(problem.mesh.points))
        for number, faces in reversed(list(enumerate(problem.faces, len(problem.bores)))):
            for side, _ in faces.sides(faces.pressing):
                nodes, values = side.at_nodes(part[problem.own(number)][: side.size, None])
                parts[parity][nodes] = values[:, 0]
    return ParityPair(parts[Parity.SYMMETRIC], parts.get(Parity.ANTISYMMETRIC))
