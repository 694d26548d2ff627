"""How a bore yields to the pressures of its film and to all else on the rod, in smooth functions.

In a rod in parts, what is closed in a given state sticks and what is open moves freely: the parts respond in
proportion to the load.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from fea.base.material import Material
from fea.contact.assembled import Assembled
from fea.contact.elastic_pin import HALF_COSINE, ORDERS, Pin, harmonics
from fea.contact.friction_system import ContactState
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import ElasticBore
from fea.pins.bonded import BondedBore
from fea.pins.fits import Fits
from fea.pins.model import PinModelContext, inertial_fields
from fea.rod.meshed_rod import Bores
from fea.solid.bore import BoreFacets, bore_facets, radial_forces
from fea.solid.parity import Parity
from fea.solvers.static import Model
from geometry.arrays import Floats, Ints
from geometry.errors import require
from geometry.surfaces import Surface
from loads.instants import Instants

# On −1…1, and weights of a quadratic function's ends and middle, in sixths of its length.
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_SIMPSON = np.array([1.0, 4.0, 1.0])
# Share of its compliance that a bore lacks, by the order of the elements: of waves of the length of 2π
# elements, beside others in proportion to the square, and of waves of every length, by bending, if elements
# were as long as the bore's radius. Of both ends of leon-2001 with 18 to 72 elements around; the last is 0.7
# to 2.8 for 24 to 72 elements, more at the big end, whose ring is thinner.
_STIFFER = {1: (0.2, 2.5), 2: (0.02, 0.0)}


class End(StrEnum):
    """The ends of a rod, each with a bearing."""

    BIG = "big_end"
    SMALL = "small_end"

    @property
    def words(self) -> str:
        """The name in a sentence."""
        return self.value.replace("_", " ")

    @property
    def pin(self) -> str:
        """The pin in it."""
        return "crank pin" if self is End.BIG else "piston pin"

    @property
    def bore(self) -> Surface:
        """The surface of its bore."""
        return Surface(f"{self}_bore")

    def pressed_in(self, structure: PinModelContext) -> bool:
        """Whether the pin is pressed into it, so that there is no film."""
        fit = structure.contact.small_end_clearance_mm
        return self is End.SMALL and fit is not None and fit <= 0

    @property
    def other(self) -> "End":
        """The end across the rod."""
        return End.SMALL if self is End.BIG else End.BIG

    def facets(self, structure: PinModelContext) -> BoreFacets:
        """Its bore in the mesh, about its middle; of a slanted one, the mean width is that everywhere.

        Places along the width and areas are those of this width, so that forces are those of the pressures.
        """
        bores, taper = structure.bores, 0.0 if self is End.BIG else structure.bores.small_taper
        x, width = (0.0 if self is End.BIG else bores.rod_length), self.size(bores)[1]
        facets = bore_facets(structure.mesh, self.bore, x)
        corners = facets.corners - [0.0, 0.0, self.middle(structure)]
        at_nodes, there = (1 + taper / width * np.cos(angle) for angle in (facets.node_angle, facets.angle))
        corners[..., 2] /= at_nodes
        return replace(facets, corners=corners, areas=facets.areas / there)

    def middle(self, structure: PinModelContext) -> float:
        """Place of the middle of its bore along z, mm."""
        mesh = structure.mesh
        z = mesh.points[np.unique(mesh.facets[self.bore]), 2]
        return 0.0 if Surface.SYMMETRY_Z in mesh.facets else float(z.min() + z.max()) / 2

    def material(self, structure: PinModelContext) -> Material:
        """That of the part at its bore."""
        mesh = structure.mesh
        if mesh.part is None:
            return structure.materials[0]
        beside = np.isin(mesh.tets, mesh.facets[self.bore][0]).sum(axis=1)
        return structure.materials[int(mesh.part[beside.argmax()])]

    def size(self, bores: Bores) -> tuple[float, float]:
        """Radius and mean width of its bore, mm."""
        if self is End.BIG:
            return bores.big_radius, bores.big_width
        return bores.small_radius, bores.small_width

    def functions(self, structure: PinModelContext) -> BoreFunctions:
        """Smooth functions on its bore."""
        mirrored = Surface.SYMMETRY_Z in structure.mesh.facets
        return BoreFunctions(*self.size(structure.bores), mirrored=mirrored)

    def grown(self, parts: Assembled | None) -> float:
        """Radial expansion of its pin up to the engine's temperature, mm."""
        warming = None if parts is None else parts.warming
        return 0.0 if warming is None else warming.pins[0 if self is End.SMALL else 1]

    def force(self, instants: Instants) -> Floats:
        """Force (2, n) of its pin on the rod, N."""
        return instants.crank if self is End.BIG else instants.pin


@dataclass(frozen=True)
class HeldParts:
    """Parts that are put together, and loads on them; made by `under`."""

    assembled: Assembled
    gap: Floats  #: (n, k) moments of the gaps that k loads open where each part is held by itself
    resultant: Floats  #: (m, k) of these loads along the free motions of the parts
    grown: Floats  #: (k,) their work on the free thermal expansion

    @classmethod
    def under(
        cls, assembled: Assembled, forces: Mapping[Parity, Floats], u: Mapping[Parity, Floats]
    ) -> "HeldParts":
        """Load parts.

        `forces`: (n_own, n_nodes, 3) of each parity on the cell, N, and `u` (n_nodes, 3, n_own), mm, what
        they do to the parts as each is held by itself. Raises `InvalidValue`: nothing but the pins holds a
        part.
        """
        problem, images = assembled.problem, assembled.problem.unfolding.images
        rule = "leaves a part that nothing but the pins holds, so that its bore cannot carry an oil film"
        held = not assembled.system.pin_held.size
        require(held, "assembly.joint_friction", 0.0, rule, "Give friction, or shells that centre the cap.")
        gaps, resultants = [], []
        for parity, own in forces.items():
            flat = own.reshape(len(own), -1)
            opened = problem.forces.T @ u[parity].reshape(flat.shape[1], -1)
            even = parity is Parity.SYMMETRIC
            gaps.append(problem.gaps(opened) if even else problem.gaps(0.0 * opened, opened))
            along = [(of is parity) * (flat @ motion) for of, motion in assembled.motions]
            resultants.append(images * np.reshape(along, (-1, len(own))))
        gap, grown = np.hstack(gaps), np.zeros(sum(map(len, forces.values())))
        if assembled.warming is not None:
            own = forces[Parity.SYMMETRIC]
            grown[: len(own)] = images * own.reshape(len(own), -1) @ assembled.warming.displacement
        return cls(assembled, gap, np.hstack(resultants), grown)

    @cached_property
    def _closed(self) -> tuple[Floats, Floats]:
        """What `adding` finds where everything sticks (k, k + 1), and the stresses that loads cause there.

        The last of the columns is the way from where the parts were put together to the engine's temperature.
        """
        parts, start, before = self.assembled, self.assembled.start, self.assembled.tightened
        unloaded = start.load.gap.copy()
        unloaded[parts.interface] -= start.gap
        values, motions = parts.sticking(
            np.column_stack([self.gap, unloaded]), np.pad(self.resultant, [(0, 0), (0, 1)])
        )
        stress = values[parts.interface]
        values[:, -1] -= before.values
        motions[:, -1] -= parts.system.part_motion(before)
        return self.gap.T @ values + self.resultant.T @ motions, stress

    def adding(self, state: ContactState | None = None) -> tuple[Floats, Floats]:
        """Work (k, k) that the hold of the parts adds to that of the loads, and made (k,).

        `state`: what is open in it moves freely, by default at the engine's temperature: the stresses there
        are released, which adds their work on the gaps that open. The second is the work of the loads on what
        the parts move by themselves from where they were put together, when the bores were made, to the
        state.
        """
        work, stress = self._closed
        opened = self.assembled.opened(state or self.assembled.start)
        if opened.size:
            stiffness = self.assembled.system.condensed.S[opened][:, opened]
            work = work + stress[opened, :-1].T @ np.linalg.solve(stiffness, stress[opened])
        return work[:, :-1], work[:, -1] + self.grown


@dataclass(frozen=True)
class _Answers:
    """What unit pressures on a bore, forces of the other pin and unit motions do to the bore."""

    work: Floats  #: (k, k) of all of these, in each part by itself
    held: HeldParts | None  #: how parts hold together
    own: Ints  #: (n,) the pressures among them
    rest: Ints  #: (6,) the others
    rigid: Ints  #: of the pressures, those that move the bore as a whole
    grown: Floats  #: (n,) weights of the expansion of the pin

    def at(self, state: ContactState | None = None) -> tuple[Floats, Floats, Floats]:
        """Compliance, `loaded` and `relief` of `YieldingBore`, with parts as open as in a state."""
        work, made = (0.0, np.zeros(len(self.work))) if self.held is None else self.held.adding(state)
        work = self.work + work
        compliance, loaded = work[np.ix_(self.own, self.own)], work[np.ix_(self.own, self.rest)]
        found = (compliance + compliance.T) / 2, loaded, made[self.own] - self.grown
        for of_rigid in found:
            of_rigid[self.rigid] = 0.0
        return found

    @cached_property
    def relief(self) -> Floats:
        return self.at()[2]


@dataclass(frozen=True)
class YieldingBore:
    """The displacement of a bore under pressures on it and all else that acts on the rod.

    In a rod without mirror plane z = 0 the pin may tilt in it. Its film then has the moment that leaves the
    other pin none about the middle of its bore.
    """

    end: End
    functions: BoreFunctions
    #: (n, n), mm³/N, between weights of the functions, without rigid motions: those are the journal's
    compliance: Floats
    #: (n, 6) weights of the displacement of unit forces of the other pin along x and y and unit motions
    loaded: Floats
    #: (n,) weights of how the bore widens as it is made, and from where its parts were put together
    relief: Floats
    #: (2, 6) moments of these, by their forces along x and along y, about the middle of the bore, over half
    #: its width, N; without meaning where z = 0 is a mirror plane
    turning: Floats
    #: By estimate, (n,) how much more each function yields on much smaller elements, relative to what it does
    lacking: Floats
    answers: _Answers
    pin: "YieldingPin | None" = None  #: None for a rigid one

    @classmethod
    def of(
        cls, structure: PinModelContext, end: End = End.BIG, parts: Assembled | None = None
    ) -> "YieldingBore":
        """Solve for unit pressures on the bore, unit forces of the other pin and unit motions.

        The sum of what acts at an instant balances; each unit alone does not, and is held by the restraints.
        `parts`: those of a rod in parts, which hold together as without loads; errors as of
        `HeldParts.under`.
        """
        n_nodes, functions = len(structure.mesh.points), end.functions(structure)
        facets, pin = end.facets(structure), BondedBore.of(end.other.facets(structure), n_nodes)
        even, odd = (
            np.stack([*pressed, force, *motions])
            for pressed, force, motions in zip(
                unit_forces(functions, facets, n_nodes),
                pin.forces,
                inertial_fields(structure.inertia),
                strict=True,
            )
        )
        z = (structure.mesh.points[:, 2] - end.middle(structure)) / (functions.width / 2)
        about = [facets.images * np.tensordot(each, z, axes=((1,), (0,)))[:, :2] for each in (even, odd)]
        if facets.cut_y:  # components that the images across y = 0 cancel
            about[0][:, 1] = about[1][:, 0] = 0.0
        work, held = works(structure.model, facets, even, odd, parts)
        # Of each parity, the last three are the force of the other pin and the two motions.
        rest = np.concatenate([len(even) - 3 + np.arange(3), len(even) + len(odd) - 3 + np.arange(3)])
        rest, own = rest[[0, 3, 1, 2, 4, 5]], np.setdiff1d(np.arange(len(work)), rest)
        grown = end.grown(parts) * functions.widening
        answers = _Answers(work, held, own, rest, functions.rigid, grown)
        compliance, loaded, relief = answers.at()
        short, bent = _STIFFER[structure.mesh.order]
        size = facets.element_size
        lacking = short * (functions.waves * size) ** 2 + bent * size / functions.radius
        turning = np.concatenate(about)[rest].T
        return cls(end, functions, compliance, loaded, relief, turning, lacking, answers)

    def with_joint(self, state: ContactState) -> "YieldingBore":
        """The same of a rod in parts that are as open as in a state."""
        compliance, loaded, relief = self.answers.at(state)
        relief += self.relief - self.answers.relief
        return replace(self, compliance=compliance, loaded=loaded, relief=relief)

    @property
    def with_pin(self) -> Floats:
        """Compliance (n, n) of the bore and its pin together."""
        return self.compliance if self.pin is None else self.compliance + self.pin.compliance

    def on(self, grid: FilmGrid) -> ElasticBore:
        """The bore for a film on a grid."""
        ends = np.concatenate(self.functions.at(grid.angle[:, None], grid.ends[None]))
        return ElasticBore(self.functions.means(grid), np.moveaxis(ends, 0, -1), self.with_pin)

    def carried(self, instants: Instants) -> Floats:
        """What the film must carry (n_instants, 2 or 4): `load` of `fea.film.cycle.JournalLoads`."""
        force, rest = self.end.force(instants), [self.end.other.force(instants), instants.motions]
        moments = [] if self.functions.mirrored else [-self.turning @ np.concatenate(rest)]
        return np.concatenate([force, *moments]).T

    def caused(self, instants: Instants) -> Floats:
        """Weights (n_instants, n) of the displacement by all but the film: g of `ElasticBore`."""
        pin = 0.0 if self.pin is None else self.pin.carried(self.end.force(instants))
        return self.caused_from_afar(instants) + self.relief + pin

    def caused_from_afar(self, instants: Instants) -> Floats:
        """The share of the other pin and of inertia in that."""
        afar = np.concatenate([self.end.other.force(instants), instants.motions])
        return np.asarray(afar.T @ self.loaded.T)

    def with_fits(self, fits: Fits) -> "YieldingBore":
        """The small end's bore with its relief and an elastic piston pin, as contact has them."""
        functions, relief = self.functions, self.relief.copy()
        if fits.relief is not None:
            length, depth = fits.relief
            z = functions.width / 4 * (_PLACES + 1)
            widened = depth * np.maximum(0.0, 1 - (functions.width / 2 - z) / length) ** 2
            even, _ = functions.at(np.zeros_like(z), z)
            area = 4 * math.pi * functions.radius * functions.width / 4 * _WEIGHTS
            plain = np.flatnonzero((functions.terms[:, 0] == 0) & (functions.terms[:, 1] % 2 == 0))
            relief[plain] += even[plain] @ (area * widened)
        pin = None if fits.piston_pin is None else YieldingPin.of(functions, fits.piston_pin)
        return replace(self, pin=pin, relief=relief)


@dataclass(frozen=True)
class YieldingPin:
    """The inward displacement of an elastic pin, whose supports press with half a cosine on its far side."""

    compliance: Floats  #: (n, n), mm³/N, as of `YieldingBore`
    #: (n,) weights of the displacement by half a cosine of 1 N on the supports, along each function's wave
    supported: Floats
    orders: Ints  #: (n,) harmonic of each function, negative of the sines

    @classmethod
    def of(cls, functions: BoreFunctions, pin: Pin) -> "YieldingPin":
        """Add up the harmonics of a pin."""
        n, pin = functions.terms[:, 0], replace(pin, touching=functions.width / 2)
        orders = np.concatenate([n, -n[n > 0]])
        found = cls(np.zeros((len(orders),) * 2), np.zeros(len(orders)), orders)
        for mirrored in (True,) if functions.mirrored else (True, False):
            found._add(functions, pin, mirrored=mirrored)
        found.compliance[functions.rigid] = found.supported[functions.rigid] = 0.0
        return found

    def _add(self, functions: BoreFunctions, pin: Pin, *, mirrored: bool) -> None:
        """Add the answers to pressures of the functions that are even about z = 0, or of the odd ones."""
        n, orders = functions.terms[:, 0], self.orders
        every = np.concatenate([functions.terms[:, 1], functions.terms[n > 0, 1]]) % 2 == 1 - mirrored
        stations, answers = harmonics(pin, max(int(n.max()), ORDERS[-1]), mirrored=mirrored)
        along = np.zeros(len(stations))  # ∫ R dz of the stations' quadratic functions
        for start in range(0, len(stations) - 2, 2):
            along[start : start + 3] += pin.radius * (stations[start + 2] - stations[start]) / 6 * _SIMPSON
        even, _ = functions.at(np.zeros_like(stations), stations)
        near, far = pin.carried or (0.0, math.inf)
        peak = 1 / (math.pi * pin.radius * (far - near))
        for answer in answers:
            work = math.pi * (1 + (answer.order == 0)) * even * along
            for sign in (1, -1):
                own = np.flatnonzero(every & (orders == sign * answer.order))
                rows = work[np.flatnonzero(every[: len(n)] & (n == answer.order))]
                self.compliance[np.ix_(own, own)] = 2 * rows @ answer.compliance @ rows.T
                if mirrored and answer.order in ORDERS:
                    share = peak * HALF_COSINE[ORDERS.index(answer.order)] * (-1) ** answer.order
                    self.supported[own] = 2 * share * rows @ answer.carried

    def carried(self, force: Floats) -> Floats:
        """Weights (n_instants, n) under forces (2, n_instants) of the pin on the rod, N."""
        turned = np.multiply.outer(np.arctan2(force[1], force[0]), np.abs(self.orders))
        waves = np.where(self.orders >= 0, np.cos(turned), np.sin(turned))
        return np.asarray(np.hypot(*force)[:, None] * waves * self.supported)


def unit_forces(functions: BoreFunctions, facets: BoreFacets, n_nodes: int) -> tuple[Floats, Floats]:
    """Nodal forces (n, n_nodes, 3) on the cell of pressures of 1 MPa·mm times each even and odd function.

    Where holes interrupt the bore, those are taken whose integrals with the functions are the unit matrix:
    by them a film has the forces of its pressure on what is left, and a displacement is fitted there.
    """
    z, count = facets.corners[..., 2] @ facets.shape_values.T, len(functions.terms)
    values = np.concatenate(functions.at(facets.angle, z))
    flat = values.reshape(len(values), -1)
    gram = facets.images * (flat * facets.areas.ravel()) @ flat.T
    if facets.cut_y:  # the products of even and odd functions, which the images cancel
        gram[:count, count:] = gram[count:, :count] = 0.0
    duals = (np.linalg.inv(gram) @ flat).reshape(values.shape)
    forces = np.stack([radial_forces(facets, n_nodes, each) for each in duals])
    return forces[:count], forces[count:]


def works(
    model: Model, facets: BoreFacets, even: Floats, odd: Floats, parts: Assembled | None = None
) -> tuple[Floats, HeldParts | None]:
    """Work (n, n) in the body of forces of both parities, (n_own, n_nodes, 3); even ones are not fewer.

    Of a rod in parts, that is the work in each part by itself; and how these hold together.
    """
    forces = {Parity.SYMMETRIC: np.concatenate([even, odd])}
    if facets.cut_y:
        forces = {Parity.SYMMETRIC: even, Parity.ANTISYMMETRIC: odd}
    if parts is None:
        work, held = [model.work(*each) for each in forces.items()], None
    else:
        u = model.displaced(forces)
        work = [np.tensordot(forces[p], u[p], axes=2) for p in forces]
        held = HeldParts.under(parts, forces, u)
    return facets.images * np.asarray(block_diag(*work)), held
