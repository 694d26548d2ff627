"""Plastic flow of a rod under loads that follow one another, turn by turn."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from fea.analysis.prepared_rod import PreparedRod
from fea.judge.history import deviatoric, mean_shift
from fea.plastic.cycling import MOST_TURNS, YIELD_TOLERANCE, Flow, PlasticAnswer, cycled
from fea.plastic.increment import ElasticBody, projected
from fea.plastic.zone import Zone, equivalent_strain
from fea.solid.assembly import mean_at_nodes
from fea.solid.parity import Parity
from fea.solid.stress import principal, von_mises
from geometry.arrays import Floats, Ints, Mask
from loads.instants import Instants

# Elements whose elastic stress reaches this share of the yield strength may flow, as others flow beside them.
_NEAR = 0.85
# Times that the zone may grow, until nothing yields outside of it.
_GROWTHS = 6


@dataclass(frozen=True)
class FlowingRod:
    """The loads of a rod at a speed, ready to be followed at any multiple of them."""

    rod: PreparedRod
    loads: Mapping[str, Floats]  #: displacement (n_nodes, 3) of the whole rod, mm, in the order they act
    worst: Floats  #: (n_nodes,) largest elastic von Mises stress of any load, MPa
    counts: Mask  #: (n_nodes,) nodes away from singular places, whose elements alone may flow
    #: Displacement (n_nodes, 3) under bolts and fits alone, mm, which stays at any multiple; None without
    rest: Floats | None = None

    @cached_property
    def nodes(self) -> Ints:
        """Node (n_halves, n_cell) of the whole rod at each node of the cell, and at its image about y = 0."""
        mirrored, cell = self.rod.mesh.mirrored, self.rod.mesh.cell
        own, image = np.empty((2, len(cell.points)), dtype=np.int64)
        above = mirrored.sign[:, 2] > 0
        for nodes, side in ((own, 1), (image, -1)):
            nodes[:] = own
            there = np.flatnonzero(above & (mirrored.sign[:, 1] == side))
            nodes[mirrored.source[there]] = there
        return np.stack([own, image]) if self.rod.mesh.cut_y else own[None]

    @cached_property
    def displacements(self) -> list[Floats]:
        """Displacement (n_halves, n_cell, 3) of each load, mm, the second half mirrored to the cell."""
        return [self._on_halves(displacement) for displacement in self.loads.values()]

    def _on_halves(self, displacement: Floats) -> Floats:
        signs = np.array([[[1.0, 1.0, 1.0]], [[1.0, -1.0, 1.0]]])[: len(self.nodes)]
        return np.asarray(displacement[self.nodes] * signs)

    def _times(self, multiple: float) -> list[Floats]:
        """A multiple of the loads, (n_halves, n_cell, 3) each; what bolts and fits do stays."""
        rest = 0.0 if self.rest is None else self._on_halves(self.rest)
        return [rest + multiple * (u - rest) for u in self.displacements]

    @cached_property
    def _counts(self) -> Mask:
        """Elements (n_elements,) of the cell away from singular places."""
        masked = ~self.counts[self.nodes[0]]
        return np.asarray(~masked[self.rod.mesh.cell.tets].any(axis=1))

    @cached_property
    def nodal(self) -> Floats:
        """Largest elastic von Mises stress at the nodes of each element, (n_halves, n_elements), MPa."""
        worst = self.worst[self.nodes][:, self.rod.mesh.cell.tets].max(axis=-1)
        return np.asarray(np.where(self._counts, worst, 0.0))

    def _zone(self, elements: Mask, strength: float = 1.0) -> Zone:
        """Some elements (n_halves, n_elements); with a strength of 1, usage is stress."""
        half, element = np.nonzero(elements)
        strengths = np.full(len(element), strength)
        return Zone.of(self.rod.mesh.cell, self.rod.material, half, element, strengths)

    @cached_property
    def _elastic(self) -> tuple[float, float]:
        """Largest stress, and largest range of stress between two loads, at the Gauss points, MPa.

        Of the elements with half the largest stress: no range elsewhere exceeds it.
        """
        zone = self._zone(self.nodal >= self.nodal.max() / 2)
        deviators = [zone.trial(u[:, zone.nodes], zone.virgin) for u in self.displacements]
        largest = max(von_mises(stress).max() for stress in deviators)
        ranges = [von_mises(one - other).max() for one, other in combinations(deviators, 2)]
        return float(largest), float(max(ranges, default=0.0))

    @property
    def surface(self) -> float:
        """By how much the stress at the nodes exceeds that at the Gauss points, which lie inside."""
        return max(1.0, float(self.nodal.max()) / self._elastic[0])

    def reversing(self, strength: float) -> float:
        """Multiple of the loads above which flow never ends: a range of stress exceeds twice the strength.

        No residual stress brings both of its ends within the yield condition (Melan 1938).
        """
        return 2 * strength / max(self.surface * self._elastic[1], strength / 50)

    def follow(self, strength: float, multiple: float = 1.0, most_turns: int = MOST_TURNS) -> "FollowedFlow":
        """Repeat the loads, all of them multiplied, with a yield strength, MPa, until the end is known.

        They are raised by `surface`. Whole sections that give way do not depend on that: a collapse counts if
        it follows without, too; if the rod settles then, what happens is not known.
        """
        found = self.followed(strength, multiple, most_turns, self.surface)
        if found.flow.answer is not PlasticAnswer.COLLAPSES:
            return found
        bare = self.followed(strength, multiple, most_turns)
        return bare.undecided if bare.settles else bare

    def followed(
        self, strength: float, multiple: float, most_turns: int, raised: float = 1.0
    ) -> "FollowedFlow":
        """Do so with the loads multiplied; `raised`: with what bolts and fits do."""
        loads, scale = [raised * u for u in self._times(multiple)], raised * multiple
        may_flow = self.nodal >= min(_NEAR * strength / scale, float(self.nodal.max()))
        parities = tuple(Parity) if len(may_flow) > 1 else (Parity.SYMMETRIC,)
        solvers = {parity: self.rod.model.restrained(parity) for parity in parities}
        for _ in range(_GROWTHS):
            zone = self._zone(may_flow, strength)
            body = ElasticBody(zone, solvers)
            acting = [projected(zone, body, u[:, zone.nodes]) for u in loads]
            flow = cycled(zone, body, acting, most_turns, endless=scale * self._elastic[1] > 2 * strength)
            state = flow.state
            # Of what has flowed, and not of the forces that balance it within a tolerance: small sets count.
            forces = zone.initial_forces(zone.strain(state.moved)[1], state.plastic, body.halves)
            share, moved = self._refitted(body.everywhere(forces))
            missed = self._beyond(strength, [u + moved for u in loads]) & ~may_flow
            if flow.answer is PlasticAnswer.COLLAPSES or not missed.any():
                return FollowedFlow(self, zone, flow, moved, share)
            may_flow |= missed
        return FollowedFlow(self, zone, flow, moved, share).undecided

    def _refitted(self, moved: Floats) -> tuple[float, Floats]:
        """Bring parts that have flowed together again; by how much their contact changes, relative to it."""
        if (pins := self.rod.assembly_contact) is None:
            return 0.0, moved
        own, image = moved[0], moved[-1]
        even, odd = ((own + side * image).ravel() / 2 for side in (1, -1))
        share, motion = pins.assembly.assembled.refitted(even, odd)
        parts = [motion.get(parity, 0.0) for parity in (Parity.SYMMETRIC, Parity.ANTISYMMETRIC)]
        return share, moved + np.stack([parts[0] + parts[1], parts[0] - parts[1]])[: len(moved)]

    @cached_property
    def every(self) -> Zone:
        """All elements of one half."""
        return self._zone(np.ones((1, len(self.rod.mesh.cell.tets)), dtype=bool))

    def _beyond(self, strength: float, displacements: Sequence[Floats]) -> Mask:
        """Elements (n_halves, n_elements) that yield under any of these, where nothing has flowed."""
        zone = self.every
        stress = [
            [zone.usage(u[[half]], zone.virgin).max(axis=1) for half in range(len(u))] for u in displacements
        ]
        return np.asarray((np.max(stress, axis=0) > (1 + YIELD_TOLERANCE) * strength) & self._counts)


def ready(rod: PreparedRod, loads: Mapping[str, Floats], worst: Floats, counts: Mask) -> FlowingRod:
    """Make loads ready to be followed: see `FlowingRod`. A single load comes and goes.

    `loads`: displacements with thermal expansion. Of a rod in parts only those of its own material flow.
    """
    rest: Floats | None = None
    if rod.assembly_contact is not None:
        solved = rod.equilibrium(rod.pins.resting)
        rest = rod.fields.displacement(solved.solution)[..., 0]
        growth = rod.fields.displaced(solved)[..., 0] - rest
        loads = {name: u - growth for name, u in loads.items()}
        flows = [material == rod.materials[0] for material in rod.materials]
        part = rod.mesh.whole.part
        counts, stiff = counts.copy(), [] if part is None else rod.mesh.whole.tets[~np.array(flows)[part]]
        counts[np.unique(stiff).astype(int)] = False
    if len(loads) == 1:
        loads = {**loads, "no load": np.zeros((len(worst), 3)) if rest is None else rest}
    return FlowingRod(rod, loads, worst, counts, rest)


def flowing_under(rod: PreparedRod, instants: Instants) -> FlowingRod:
    """Solve instants that follow one another: see `ready`. Errors as of `PreparedRod.equilibrium`."""
    loads, worst, masked = dict[str, Floats](), np.zeros(1), np.zeros(1, dtype=bool)
    for instant, (fields, stresses) in zip(instants, rod.fields(rod.equilibrium(instants)), strict=True):
        loads[instant.name], masked = fields.displacement, fields.error.masked
        worst = np.maximum(worst, np.nanmax([von_mises(each) for each in stresses], axis=0))
    return ready(rod, loads, worst, masked if masked.all() else ~masked)


@dataclass(frozen=True)
class FollowedFlow:
    """What the rod did at a multiple of its loads."""

    rod: FlowingRod
    zone: Zone
    flow: Flow
    moved: Floats  #: (n_halves, n_cell, 3) displacement that is left without load, mm
    contact_change: float = 0.0  #: of the largest pressure and bolt force between parts, if they stick

    @property
    def settles(self) -> bool:
        """Whether nothing flows any more."""
        return self.flow.answer in {PlasticAnswer.ELASTIC, PlasticAnswer.SHAKES_DOWN}

    @property
    def undecided(self) -> "FollowedFlow":
        """The same, but what it leads to is not known."""
        return replace(self, flow=replace(self.flow, answer=PlasticAnswer.UNDECIDED))

    @property
    def ends_with_flow(self) -> bool:
        """Whether it has flowed and is in equilibrium."""
        return bool(self.flow.strain.any()) and self.flow.answer is not PlasticAnswer.COLLAPSES

    @property
    def elements(self) -> int:
        """Elements of the whole rod that have flowed."""
        copies = self.rod.rod.mesh.symmetry.copies // len(self.moved)
        return copies * int((self.flow.strain > 0).any(axis=1).sum())

    @property
    def node(self) -> int:
        """Node of the whole rod where most has flowed: of that element, the most stressed one."""
        stress = self.rod.nodal[self.zone.half, self.zone.element]  # decides where nothing has flowed yet
        return self.most_stressed(int((self.flow.strain.max(axis=1) + 1e-12 * stress).argmax()))

    def most_stressed(self, element: int) -> int:
        """Node of the whole rod that is the most stressed of an element of the zone."""
        nodes = self.rod.nodes[self.zone.half[element]][self.zone.nodes[self.zone.corners[element]]]
        return int(nodes[self.rod.worst[nodes].argmax()])

    @property
    def residual(self) -> float:
        """Principal stress of largest magnitude, MPa, that is left without load where most has flowed."""
        state = self.flow.state
        stress = self.zone.stress(0 * state.moved, state.moved, state.plastic)
        place = np.unravel_index(self.flow.strain.argmax(), self.flow.strain.shape)
        principals = principal(stress[place])
        return float(principals[np.abs(principals).argmax()])

    @property
    def mean_shift(self) -> tuple[Floats, Mask]:
        """By how much what is left moves the signed stress, MPa, and whether it has flowed, each (n_nodes,).

        A node has the largest of its elements that have flowed, each where it flowed most, as the loads are
        raised to what the surface bears. Elsewhere what is left is neglected.
        """
        state, zone, whole = self.flow.state, self.zone, self.rod.rod.mesh.mirrored
        nothing, strain = 0 * state.moved, self.flow.strain
        path = [zone.stress(u[:, zone.nodes], nothing, zone.virgin) for u in self.rod.displacements]
        chosen = np.flatnonzero((strain > 0).any(axis=1))
        points = chosen, strain[chosen].argmax(axis=1)
        history = deviatoric(np.stack([stress[points] for stress in path], axis=-1))
        left = deviatoric(zone.stress(nothing, state.moved, state.plastic)[points][..., None])[..., 0]
        found = np.full(self.moved.shape[:2], -np.inf)
        nodes = zone.half[chosen, None], self.rod.rod.mesh.cell.tets[zone.element[chosen]]
        np.maximum.at(found, nodes, mean_shift(history, left)[:, None])
        own = found[(whole.sign[:, 1] < 0).astype(int) % len(found), whole.source]
        return np.where(np.isfinite(own), own, 0.0), np.isfinite(own)

    def unfolded(self, extend: Callable[[Floats, Floats | None], Floats], halves: Floats) -> Floats:
        """Extend a field of both halves, which stand on the cell, to the whole rod: see `MirroredMesh`."""
        own, image = halves[0], halves[-1]
        return extend((own + image) / 2, None if len(halves) == 1 else (own - image) / 2)

    @property
    def whole(self) -> Floats:
        """What of the displacement (n_nodes, 3) of the whole rod is left without load, mm."""
        return self.unfolded(self.rod.rod.mesh.mirrored.vector, self.moved)

    @property
    def left(self) -> dict[str, Floats]:
        """Nodal arrays of the whole rod without load: displacement, mm, stress, MPa, and plastic strain.

        Stress and strain of the Gauss points are extrapolated linearly, and the mean over the elements.
        """
        rod, state, whole = self.rod, self.flow.state, self.rod.rod.mesh.mirrored
        every, cell = rod.every, rod.rod.mesh.cell
        values = np.zeros((len(self.moved), len(cell.points), 7))
        for half in range(len(self.moved)):
            plastic, own = every.virgin, self.zone.half == half
            plastic[self.zone.element[own]] = state.plastic[own]
            moved = self.moved[[half]]
            stress = every.stress(0 * moved, moved, plastic)
            points = np.concatenate([stress, equivalent_strain(plastic)[..., None]], axis=-1)
            values[half] = mean_at_nodes(cell, points)
        stress = self.unfolded(whole.tensor, values[..., :6])
        strain = self.unfolded(whole.scalar, np.maximum(values[..., 6], 0.0))
        arrays = {"permanent_displacement": self.whole, "plastic_strain_percent": 100 * strain}
        numbered = {f"principal_{number}": each for number, each in enumerate(principal(stress).T, 1)}
        return {**arrays, "stress": stress, "von_mises": von_mises(stress), **numbered}
