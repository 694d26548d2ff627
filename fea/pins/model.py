"""What a pin model is: its response, and unit loads of a cycle (registry: `fea.study.pin_models`)."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from fea.base.checks import LIMITS
from fea.base.choices import Support
from fea.base.material import Material
from fea.base.note import Note
from fea.contact.assembly_state import AssemblySpecification, AssemblyState, PinContact
from fea.machine.clock import Clock
from fea.rod.meshed_rod import Bores
from fea.solid.inertia import EVEN_MOTIONS, ODD_MOTIONS, Inertia
from fea.solid.parity import ParityPair
from fea.solvers.static import Model
from fea.study.film_table import FilmTable
from fea.study.option_tables import ContactTable
from fea.study.pin_models import pin_model
from geometry.arrays import Floats, Ints, Mask
from geometry.dimensions import Dimensions
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants, joined
from mesh.tetmesh import TetMesh

if TYPE_CHECKING:
    from fea.pins.lubrication import Films
    from fea.pins.yielding import End


@dataclass(frozen=True, kw_only=True)
class PinModelContext:
    """The rod that the pins load, and what the study says of them."""

    model: Model  #: the stiffness of the cell
    bores: Bores
    drawn: Dimensions | None  #: that the rod has been drawn from
    materials: tuple[Material, ...]  #: one per part
    inertia: Inertia  #: of the same mesh
    pressure: str  #: what the study asks for
    support: Support
    contact: ContactTable
    film: FilmTable
    pin_stiffness: Mapping[str, tuple[float, float]]  #: E, MPa, and ν of pins whose material is given
    #: Largest forces of the piston pin, N, away from the crank and towards it, over the load cases of the
    #: study's speeds
    largest_pin_forces: Callable[[], tuple[float, float]]
    #: The crank cycle at a speed, rad/s; raises `InvalidValue` without an engine
    crank_cycle: Callable[[float], CrankCycle]
    assembly: AssemblySpecification | None  #: None for a rod of one piece
    clock: Clock

    @property
    def mesh(self) -> TetMesh:
        """Mesh of the cell."""
        return self.model.mesh

    @property
    def soft(self) -> tuple[int, ...]:
        """Numbers of the parts in which second-order displacement elements alone would lock."""
        return soft_parts(self.materials, self.mesh)

    def pins(self, pressure: str = "") -> "PinModel":
        """Return the model of the pins, by default the study's. Raises `InvalidValue`: unknown, or no fit."""
        asked = replace(self, pressure=pressure or self.pressure)
        entry = pin_model(asked.pressure, in_parts=self.assembly is not None)
        model: PinModel = entry.load().of(asked)
        return model


def soft_parts(materials: Sequence[Material], mesh: TetMesh) -> tuple[int, ...]:
    """Return the numbers of the parts in which second-order displacement elements alone would lock."""
    limit = LIMITS["poissons_ratio_p2"] if mesh.order > 1 else np.inf
    return tuple(n for n, material in enumerate(materials) if material.poissons_ratio > limit)


@dataclass(frozen=True, kw_only=True)
class Response:
    """What acts on the rod at an instant: nodal forces that balance, and what the bores feel."""

    forces: ParityPair  #: on the cell, N
    traction: Mapping[Surface, ParityPair]  #: known traction on the surface, MPa
    largest: float  #: the largest force on a bore, or of all bolts together, N
    scale: float = 1.0  #: correction factor of a prescribed load that is farthest from 1
    #: Moment out of the plane of motion that the rod's inertia balances, over the largest bore force times
    #: the rod's length; None if mirror planes or a clamp exclude such a moment
    tilt: float | None = None
    touch: Mapping[Surface, PinContact] = field(
        default_factory=dict
    )  #: where pins in contact touch the bores
    shift: ParityPair | None = None  #: rigid displacement of separate parts on the cell, mm
    growth: ParityPair | None = None  #: free thermal expansion on the cell, mm, which causes no stress
    checks: Mapping[str, float] = field(default_factory=dict)  #: further ones of `fea.base.checks`
    assembly: AssemblyState | None = None  #: bolts and interfaces of a rod of separate parts
    #: (n_nodes,) contact pressure on each surface that something presses on, MPa; 0 beside the surface.
    #: Empty where the pins' pressure is prescribed.
    pressure: Mapping[Surface, ParityPair] = field(default_factory=dict)
    gap: ParityPair | None = None  #: (n_nodes,) between its parts, mm


class Weights(NamedTuple):
    """How much of each unit load there is: (n_units, n_instants), of the unit loads of either parity."""

    even: Floats
    odd: Floats

    def at(self, instants: slice | Ints | Mask) -> "Weights":
        """Return those of some instants."""
        return Weights(self.even[:, instants], self.odd[:, instants])


class JointBounds(NamedTuple):
    """Unit loads of either parity bounded jointly: closely if they are orthogonal, of equal energy."""

    even: slice
    odd: slice


# Of patterns of unit loads, the smooth ones of either parity that are bounded each by itself.
SMOOTH = 10
NOT_JOINT = JointBounds(slice(0, 0), slice(0, 0))


class UnitLoadFields(Protocol):
    """Unit loads of one parity on the cell."""

    @property
    def count(self) -> int:
        """Number of unit loads."""

    def forces(self, units: slice) -> Sequence[Floats]:
        """Nodal forces (n_nodes, 3) of some of them, N."""

    def sums(self, units: slice) -> Floats | None:
        """Return columns (k, n) of which some of them are sums of condensed forces; None if they are none."""

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each bore, MPa."""


class Contacts(NamedTuple):
    """Contact at each instant."""

    #: Of the pins with the bores, where they are in contact
    touches: tuple[Mapping[Surface, PinContact], ...] = ()
    states: tuple[AssemblyState, ...] = ()  #: of bolts and interfaces; empty for a rod of one piece


class UnitLoads(ABC):
    """Loads whose sums, with weights, are everything that acts over crank cycles."""

    series_error: float = 0.0  #: largest error of the pressures that they can represent, over their peak
    jumps: bool = False  #: whether the pressure jumps at the ends of its arc
    joint: JointBounds = NOT_JOINT
    path_dependent: ClassVar[bool] = False  #: whether friction makes an instant depend on those before it

    @abstractmethod
    def fields(self) -> tuple[UnitLoadFields, UnitLoadFields]:
        """Return the even and the odd unit loads."""

    @abstractmethod
    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants; `cycle` as for `PinModel.respond`."""

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Contact at the instants of a cycle, whose weights are known."""
        return Contacts()


class PinModel(ABC):
    """How the pins load the rod."""

    #: Where the exact stress is infinite because pins press on sharp edges.
    singular_surfaces: tuple[Surface, ...] = ()
    notes: tuple[Note, ...] = ()  #: what a reader must know of the pins
    films: "Mapping[End, Films]" = MappingProxyType({})  #: oil films that load the bores
    resting: Instants = joined(())  #: load cases of a rod on which nothing acts but the model itself

    def __init__(self, structure: PinModelContext) -> None:
        self.structure = structure

    @property
    def excluded_because(self) -> str:
        """Why the model cannot be used for the rod, as a rule; empty where it can."""
        return ""

    @classmethod
    def of(cls, structure: PinModelContext) -> Self:
        """Prepare the model for a rod; what takes long waits. Raises `InvalidValue`: a pin does not fit."""
        return cls(structure)

    @abstractmethod
    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> Sequence[Response]:
        """Return what acts on the rod at instants.

        `cycle` is the one that they belong to, where friction makes them depend on what came before; by
        default each of them follows on the rod at rest. Raises `ContactError`: no state of contact carries
        the load; `InvalidValue`: the model cannot be combined with something else that was asked for.
        """

    def datum(self) -> Response | None:
        """The state in which the bores were made round; None if nothing acted then."""
        return None

    @abstractmethod
    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:
        """Return unit loads that span crank cycles and their peak cases; errors as of `respond`."""


def inertial_fields(inertia: Inertia) -> tuple[list[Floats], list[Floats]]:
    """Nodal forces (n_nodes, 3) of the even and of the odd unit accelerations."""
    even, odd = ([inertia.forces(motion) for motion in motions] for motions in (EVEN_MOTIONS, ODD_MOTIONS))
    return [split.symmetric for split in even], [odd_part(split) for split in odd]


def odd_part(split: ParityPair) -> Floats:
    """The antisymmetric part of a field, or all of it on a cell that is not cut at y = 0."""
    return split.symmetric if split.antisymmetric is None else split.antisymmetric


def total(parts: Sequence[ParityPair]) -> ParityPair:
    """Sum of fields."""
    odd = [part.antisymmetric for part in parts if part.antisymmetric is not None]
    return ParityPair(
        np.sum([part.symmetric for part in parts], axis=0), np.sum(odd, axis=0) if odd else None
    )
