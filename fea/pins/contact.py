"""Pins in contact with the bores over their clearance: pressure follows from where they come to lie.

The pressures of an instant are the solution of a small contact problem; everything that follows from them is
linear. The unit loads of a cycle are therefore patterns of pressure: the eigenvectors of the compliance,
smooth ones first, of unit work. The smooth ones reach far into the rod, and what all others do together is
bounded by their work.
"""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fea.base.checks import LIMITS
from fea.base.choices import CONTACT, SolverName
from fea.contact.active_set import FrictionlessState
from fea.contact.assembly_state import PinContact
from fea.contact.bolts import BoltPull
from fea.contact.friction_system import ContactState
from fea.contact.interfaces import MatingFaces, Multipliers, PinInBore, radial
from fea.contact.problem import ContactProblem
from fea.film.functions import FilmPressure
from fea.pins.fits import Fits
from fea.pins.model import (
    SMOOTH,
    Contacts,
    JointBounds,
    PinModel,
    PinModelContext,
    Response,
    UnitLoads,
    Weights,
    inertial_fields,
)
from fea.solid.inertia import EVEN_MOTIONS, ODD_MOTIONS, resultants
from fea.solid.parity import Parity, ParityPair
from fea.study.pin_models import contact_excluded_because
from geometry.arrays import Floats, Ints, Mask
from geometry.errors import require
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

_MOTIONS = (*EVEN_MOTIONS, *ODD_MOTIONS)
# Of the largest pressure of an instant: what rounding leaves where nothing touches.
NOTHING = 1e-9


# A solution: of pins alone, or of parts with friction too.
State = FrictionlessState | ContactState


class BoreContact:
    """The contact problem of a meshed rod and its pins, whose compliance is computed once.

    `faces`, `bolts`: where separate parts of the rod touch, and what holds them together
    (`fea.pins.assembly`); `film`: what may press on the big end in place of its pin.

    Attributes: `unit_loads`: nodal forces (n_nodes, 3) of what acts beside the unknowns, unit motions and
    functions of the film; `of_parity`: which of them each parity has.
    """

    def __init__(
        self,
        structure: PinModelContext,
        fits: Fits,
        *,
        faces: Sequence[MatingFaces] = (),
        bolts: Sequence[BoltPull] = (),
        film: FilmPressure | None = None,
    ) -> None:
        model, bores, inertia = structure.model, structure.bores, structure.inertia
        mesh = model.mesh
        cut_y, cut_z = Surface.SYMMETRY_Y in mesh.facets, Surface.SYMMETRY_Z in mesh.facets
        self._inertia = inertia
        pins = []
        small, big = Surface.SMALL_END_BORE, Surface.BIG_END_BORE
        for surface, x, clearance, pin in (
            (small, bores.rod_length, fits.small_clearance, fits.piston_pin),
            (big, 0.0, fits.big_clearance, fits.crank_pin),
        ):
            multipliers = Multipliers.of(mesh, surface, radial(x))
            z = multipliers.places[..., 2]
            middle = 0.0 if cut_z else float(z.min() + z.max()) / 2
            bore = PinInBore(multipliers, (x, middle), clearance, pin, cut_y, cut_z)
            if surface is small:
                bore = replace(bore, relief=fits.relief, as_drawn=fits.drawn_relief)
            pins.append(bore)
        unit = [inertia.forces(motion) for motion in _MOTIONS]
        self.film, self.unit_loads = film, [field for own in inertial_fields(inertia) for field in own]
        self.of_parity = [np.arange(2), np.arange(2, 4)]
        for number, fields in enumerate(film.forces if film is not None else ()):
            self.of_parity[number] = np.append(self.of_parity[number], len(unit) + np.arange(len(fields)))
            odd = cut_y and number == 1
            unit += [ParityPair(0 * field, field) if odd else ParityPair(field, None) for field in fields]
            self.unit_loads += list(fields)
        parities = tuple(Parity) if cut_y else (Parity.SYMMETRIC,)
        loads = {parity: np.stack([one.part(parity).ravel() for one in unit], axis=1) for parity in parities}
        # Moments about x and y of the unit loads, on a rod that may tilt.
        tilting = (resultants(mesh.points, forces.symmetric)[3:5] for forces in unit)
        self._tilting = None if cut_z else np.stack(list(tilting), axis=1)
        self.problem = ContactProblem(model, mesh, pins, loads, both_sides=True, faces=faces, bolts=bolts)

    def pressing(self, counts: Mask) -> Floats:
        """Largest pressure (n_cell,) on nodes that count (n_nodes,) of a unit of each unknown, MPa."""
        problem = self.problem
        pressing = np.where(np.append(counts, True)[problem.nodes], 1.0, 0.0)
        for number, bolt in enumerate(problem.bolts, len(problem.bores) + len(problem.faces)):
            units = [float(np.abs(unit).max()) for unit in bolt.seated.values()]
            pressing[problem.own(number)] = max(units, default=0.0)
        return np.asarray(pressing)

    def tilted(self, weights: Floats) -> Floats | None:
        """Moments (2, …) that the pins must have on a rod that may tilt, under unit loads."""
        return None if self._tilting is None else -self._tilting @ weights

    def acting(self, instants: Instants) -> tuple[Floats, Floats]:
        """Gaps (n, n_instants) and resultants (m, n_instants) of the contact problems of instants."""
        forces, motions = (instants.pin, instants.crank), instants.motions
        return self.problem.gap(forces, motions), self.problem.sums(forces, self.tilted(motions))

    def response(self, instant: Instants, state: State) -> Response:
        """Return what a solution and the inertia of its instant do to the rod."""
        inertial = self._inertia.forces(instant) if instant.motions.any() else None
        forces, traction = {}, {}
        for parity, values in self.problem.unfolding.parts(state.values).items():
            nodal = (self.problem.forces @ values).reshape(-1, 3)
            forces[parity] = nodal if inertial is None else nodal + inertial.part(parity)
            fields = self.problem.traction(values[:, None])
            traction[parity] = {surface: field[..., 0] for surface, field in fields.items()}
        return Response(
            forces=ParityPair(forces[Parity.SYMMETRIC], forces.get(Parity.ANTISYMMETRIC)),
            traction=_by_surface(traction),
            pressure=self.pressure(state.values),
            largest=float(instant.largest_force),
            touch=self.touch(state.values),
            checks={"contact_gap": state.residual, "contact_balance": state.imbalance},
        )

    def touches(self, values: Floats, pins: slice | Ints) -> tuple[Mapping[Surface, PinContact], ...]:
        """Contact at each instant from the unknowns (n, n_instants), of which `pins` are the pins'."""
        values = np.where(values < NOTHING * values[pins].max(axis=0), 0.0, values)
        return tuple(self.touch(instant) for instant in values.T)

    def touch(self, values: Floats) -> dict[Surface, PinContact]:
        """Contact of each pin with its bore under the values (n,) of the unknowns."""
        return {surface: PinContact.of(values[mine], *around) for surface, mine, around in self._around}

    @cached_property
    def _around(self) -> list[tuple[Surface, Ints, tuple[Floats, Floats, float]]]:
        """Of each bore its unknowns, their angles, rad, z, mm, and distance in angle, rad."""
        around, problem = [], self.problem
        for number, bore in enumerate(problem.bores):
            cells = np.arange(*problem.starts[[number, number + 1]])
            mine = problem.unfolding.with_images(cells)
            x, y, z = problem.mesh.points[problem.nodes[cells]].T
            angle, off = np.arctan2(y, x - bore.center[0]), ~problem.unfolding.on_y[cells]
            if len(mine) > len(cells):
                angle, z = np.append(angle, np.arctan2(-y, x - bore.center[0])[off]), np.append(z, z[off])
            apart = float(np.median(np.diff(np.unique(np.round(angle, 6)))))
            around.append((bore.multipliers.surface, mine, (angle, z, apart)))
        return around

    def pressure(self, values: Floats) -> dict[Surface, ParityPair]:
        """Pressure (n_nodes,) on each surface of unknowns (n,), MPa; 0 beside the surface."""
        parts = self.problem.unfolding.parts(values)
        return _by_surface({parity: self.problem.pressure(part) for parity, part in parts.items()})


def _by_surface(parts: Mapping[Parity, Mapping[Surface, Floats]]) -> dict[Surface, ParityPair]:
    odd = parts.get(Parity.ANTISYMMETRIC, {})
    return {surface: ParityPair(even, odd.get(surface)) for surface, even in parts[Parity.SYMMETRIC].items()}


def acting(instants: Instants) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Yield the forces (2,) at pin and crank and the weights (4,) of the motion of each instant."""
    return zip(instants.pin.T, instants.crank.T, instants.motions.T, strict=True)


class ContactPins(PinModel):
    """Rigid or elastic pins with clearance, as [contact] describes them."""

    def __init__(self, structure: PinModelContext) -> None:
        super().__init__(structure)
        rod = structure
        self.fits = Fits.of(rod.contact, rod.mesh, rod.bores, rod.pin_stiffness, rod.largest_pin_forces())
        self.singular_surfaces, self.notes = self.fits.singular, self.fits.notes

    @property
    def excluded_because(self) -> str:
        """Why the pins of this rod cannot be in contact: see `PinModel.excluded_because`."""
        rod = self.structure
        chosen = SolverName(rod.model.solver)
        why = contact_excluded_because(rod.support, chosen)
        if rod.soft and not why:
            nu = max(material.poissons_ratio for material in rod.materials)
            most = LIMITS["poissons_ratio_p2"]
            return f"supports displacement elements only, and ν = {nu:g} of a part exceeds {most}"
        return why

    @cached_property
    def contact(self) -> BoreContact:
        """The contact problem; computes its compliance when needed. `InvalidValue`: no such combination."""
        why = self.excluded_because
        require(not why, "analysis.pressure", CONTACT, why, "Choose another --pressure.")
        with self.structure.clock("contact"):
            return self._problem()

    def _problem(self) -> BoreContact:
        return BoreContact(self.structure, self.fits)

    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Response]:
        """Return what acts on the rod at instants: see `PinModel.respond`."""
        states = self.states(instants, cycle)
        return [self.contact.response(*each) for each in zip(instants, states, strict=True)]

    def states(self, instants: Instants, cycle: CrankCycle | None = None) -> Sequence[State]:  # noqa: ARG002
        """Solve instants one after another; parameters and errors as for `PinModel.respond`."""
        system = self.contact.problem.system
        gaps, forces = self.contact.acting(instants)
        return [system.solve(*each) for each in zip(gaps.T.copy(), forces.T.copy(), strict=True)]

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:  # noqa: ARG002
        """Return patterns of pressure, and inertia: they span any instant."""
        return PressurePatterns(self)


@dataclass(frozen=True)
class _ContactFields:
    """Unit loads of one parity on the cell."""

    contact: BoreContact
    patterns: Floats  #: (n_cell, n) unknowns of the contact problem on the cell in each unit load
    others: Floats  #: (k, n) how much of each `BoreContact.unit_loads` there is in each unit load

    @property
    def count(self) -> int:
        """Number of unit loads."""
        return int(self.patterns.shape[1])

    def forces(self, units: slice) -> list[Floats]:
        """Nodal forces (n_nodes, 3) of some of them."""
        pressed = (self.contact.problem.forces @ self.patterns[:, units]).T
        nodal = [column.reshape(-1, 3) for column in pressed]
        for field, weights in zip(self.contact.unit_loads, self.others[:, units], strict=True):
            for number in np.flatnonzero(weights):
                nodal[number] = nodal[number] + weights[number] * field
        return nodal

    def sums(self, units: slice) -> Floats:
        """Columns (n_cell + k, n) of which some of them are sums of the forces that are condensed."""
        return np.concatenate([self.patterns[:, units], self.others[:, units]])

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each surface."""
        traction = self.contact.problem.traction(self.patterns[:, units])
        if self.contact.film is not None:
            traction[Surface.BIG_END_BORE] += self.contact.film.traction(self.others[len(_MOTIONS) :, units])
        return traction

    def combined(self, columns: Floats) -> "_ContactFields":
        """Return sums of the unit loads, whose weights are columns (n, m)."""
        return replace(self, patterns=self.patterns @ columns, others=self.others @ columns)


class ContactUnits(UnitLoads):
    """Patterns of the unknowns of the contact problem, and inertia.

    Attributes: `kept`: how many of the unit loads, the last ones, are no patterns of unit work: inertia, the
    film's functions, and the state in which separate parts were put together.
    """

    def __init__(self, pins: ContactPins, of_assembly: int = 0) -> None:
        self.pins, self.contact = pins, pins.contact
        self.kept = [len(numbers) + of_assembly for numbers in self.contact.of_parity]

    def pin_forces(self, parity: Parity, values: Floats) -> Floats:
        """Resultants (m, k) of the pins in states (n_cell, k) of one parity."""
        unfolding = self.contact.problem.unfolding
        parts = {one: values if one is parity else np.zeros_like(values) for one in unfolding.parities()}
        return np.asarray(self.contact.problem.rigid.T @ unfolding.unfolded(parts))

    @abstractmethod
    def patterns(self, parity: Parity) -> Floats:
        """Unknowns (n_cell, n) on the cell in each unit load; `BoreContact.unit_loads` are the last."""

    def fields(self) -> tuple[_ContactFields, _ContactFields]:
        """Return the even and the odd unit loads."""
        fields, every = [], np.eye(len(self.contact.unit_loads))
        for parity, numbers in zip(Parity, self.contact.of_parity, strict=True):
            patterns = self.patterns(parity)
            others = np.pad(every[:, numbers], [(0, 0), (patterns.shape[1] - len(numbers), 0)])
            fields.append(_ContactFields(self.contact, patterns, others))
        return fields[0], fields[1]


class PressurePatterns(ContactUnits):
    """The unit loads of a rod of one piece."""

    def __init__(self, pins: ContactPins) -> None:
        super().__init__(pins)
        problem = self.contact.problem
        self._n_cell = len(problem.unfolding.on_y)
        none = np.zeros((self._n_cell, 0))
        self._patterns, self._weighing = ({Parity.ANTISYMMETRIC: none} for _ in range(2))
        for parity, compliance in problem.cell_compliance.items():
            some = np.flatnonzero(problem.unfolding.has(parity))
            self._patterns[parity], self._weighing[parity] = np.zeros((2, self._n_cell, len(some)))
            patterns = of_unit_work(compliance[np.ix_(some, some)])
            self._patterns[parity][some], self._weighing[parity][some] = patterns
        self.joint = JointBounds(*(slice(SMOOTH, self._patterns[parity].shape[1]) for parity in Parity))

    def patterns(self, parity: Parity) -> Floats:
        """Unknowns on the cell in each unit load: see `ContactUnits`."""
        return np.pad(self._patterns[parity], [(0, 0), (0, 2)])

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        states = self.pins.states(instants, cycle)
        values = np.stack([state.values for state in states], axis=1)  # pressures (n, n_instants)
        parts, none = self.contact.problem.unfolding.parts(values), np.zeros((self._n_cell, len(instants)))
        even, odd = (self._weighing[parity].T @ parts.get(parity, none) for parity in Parity)
        motions = instants.motions
        return Weights(np.concatenate([even, motions[:2]]), np.concatenate([odd, motions[2:]]))

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Contact of the pins with the bores at each instant."""
        parts = {}
        for parity, part in zip(Parity, weights, strict=True):
            patterns = self._patterns[parity]
            parts[parity] = patterns @ part[: patterns.shape[1]]
        pressure = self.contact.problem.unfolding.unfolded(parts)
        return Contacts(self.contact.touches(pressure, slice(None)))


def of_unit_work(compliance: Floats) -> tuple[Floats, Floats]:
    """Eigenvectors (n, n) of a compliance of unit work, softest first, and what weighs values by them."""
    work, vectors = np.linalg.eigh(compliance)
    scale = np.sqrt(work[::-1])
    return vectors[:, ::-1] / scale, vectors[:, ::-1] * scale
