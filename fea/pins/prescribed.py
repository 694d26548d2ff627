"""Pin models that prescribe the load on each bore by the force of its pin alone."""

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fea.base.choices import Support
from fea.pins.model import PinModel, Response, Structure, UnitLoads, Weights, inertial_fields, odd_part, total
from fea.rod.meshed_rod import Bores
from fea.solid.bore import BoreFacets, BoreLoad, bore_facets
from fea.solid.inertia import Inertia, Tilt
from fea.solid.parity import Parity, Split
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class LoadedBore:
    """A bore that its pin loads."""

    surface: Surface
    facets: BoreFacets  #: on the meshed cell
    outwards: int  #: sign of the force along x that pulls this end outwards
    radius: float  #: mm
    width: float  #: mm, in the mean
    taper: float = 0.0  #: the width at the angle φ from +x is width + taper cos φ, mm

    def force(self, instants: Instants) -> Floats:
        """Force (2, n) of its pin on the rod, N."""
        return instants.pin if self.surface is Surface.SMALL_END_BORE else instants.crank


class PrescribedPins(PinModel):
    """Pins whose load on a bore follows from their force alone.

    `support`: with a clamped big end, the crank force is a reaction and not applied.
    """

    def __init__(
        self, mesh: TetMesh, bores: Bores, inertia: Inertia, support: Support, pressure: str = ""
    ) -> None:
        self.n_nodes, self.pressure, self.inertia = len(mesh.points), pressure, inertia
        small = bore_facets(mesh, Surface.SMALL_END_BORE, bores.rod_length)
        measures = (bores.small_radius, bores.small_width, bores.small_taper)
        self.bores = [LoadedBore(Surface.SMALL_END_BORE, small, 1, *measures)]
        if support is not Support.CLAMPED:
            big = bore_facets(mesh, Surface.BIG_END_BORE, 0.0)
            self.bores.append(LoadedBore(Surface.BIG_END_BORE, big, -1, bores.big_radius, bores.big_width))
        held = support is Support.CLAMPED or Surface.SYMMETRY_Z in mesh.facets  # neither lets it tilt
        self.tilt = None if held else Tilt.of(mesh.points, inertia)
        self._rod_length = bores.rod_length

    @classmethod
    def of(cls, structure: Structure) -> Self:
        """Prepare the model for a rod."""
        with structure.clock("loads"):
            rod = structure
            return cls(rod.mesh, rod.bores, rod.inertia, rod.support, rod.pressure)

    @abstractmethod
    def load(self, bore: LoadedBore, force: tuple[float, float]) -> BoreLoad:
        """Load a bore with a force (x, y) on the whole rod, N."""

    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Response]:  # noqa: ARG002
        """Return what acts on the rod at instants: see `PinModel.respond`."""
        return [self.response(instant, {}) for instant in instants]

    def response(self, instant: Instants, given: Mapping[Surface, BoreLoad]) -> Response:
        """Return what acts at one instant; `given`: loads of bores that take the place of the model's."""
        loads = dict(given)
        for bore in self.bores:
            if bore.surface not in loads:
                x, y = bore.force(instant)
                loads[bore.surface] = self.load(bore, (float(x), float(y)))
        parts = [load.forces for load in loads.values()]
        if instant.motions.any():
            parts.append(self.inertia.forces(instant))
        forces, tilt, largest = total(parts), None, float(instant.largest_force)
        # A mesh that can tilt is not cut at z = 0 and hence not at y = 0: the forces have one part only.
        if self.tilt is not None:
            force, *moments = self.tilt.out_of_plane(forces.symmetric)
            length = self._rod_length
            tilt = float(max(abs(force) * length, *map(abs, moments)) / (largest * length))
            forces = Split(self.tilt.balanced(forces.symmetric), None)
        return Response(
            forces=forces,
            traction={surface: load.traction for surface, load in loads.items()},
            scale=max((load.scale for load in loads.values()), key=lambda scale: abs(scale - 1)),
            largest=largest,
            tilt=tilt,
        )


class LinearPins(PrescribedPins):
    """Pins whose load on a bore is linear in the components of the force: the sum of those along x and y."""

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:  # noqa: ARG002
        """Return forces along x and y on each bore, and inertia: they span every instant."""
        return UnitForces(self)


@dataclass(frozen=True)
class StoredFields:
    """Unit loads of one parity on the cell."""

    nodal: Sequence[Floats]  #: (n_nodes, 3) each, N
    pressed: Mapping[Surface, Floats]  #: per bore (n_nodes, 3, n_units), MPa

    @classmethod
    def of(
        cls,
        count: int,
        loads: Iterable[tuple[Surface, Floats, Floats]],
        inertial: Sequence[Floats],
        tilt: Tilt | None,
    ) -> "StoredFields":
        """Store `count` loads of bores, with forces and traction (n_nodes, 3) each, then inertia fields."""
        nodal, pressed = list[Floats](), dict[Surface, Floats]()
        for number, (surface, forces, traction) in enumerate(loads):
            every = pressed.setdefault(surface, np.zeros((count + len(inertial), *forces.shape)))
            every[number] = traction
            nodal.append(forces)
        nodal += inertial
        if tilt is not None:  # balanced in every load separately, and so in their sum
            nodal = [tilt.balanced(load) for load in nodal]
        return cls(nodal, {surface: np.moveaxis(values, 0, -1) for surface, values in pressed.items()})

    @property
    def count(self) -> int:
        """Number of unit loads."""
        return len(self.nodal)

    def forces(self, units: slice) -> Sequence[Floats]:
        """Nodal forces (n_nodes, 3) of some of them."""
        return self.nodal[units]

    def sums(self, units: slice) -> None:
        """Nothing: no forces are condensed where pressures are prescribed."""

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each bore."""
        return {surface: values[..., units] for surface, values in self.pressed.items()}


# Of the nodal forces of a load that is linear in its force: what rounding leaves.
_LINEAR = 1e-9
_Load = tuple[Surface, Floats, Floats]  # forces and traction (n_nodes, 3) on a bore


class UnitForces(UnitLoads):
    """Unit forces along x and y on each bore, and inertia."""

    def __init__(self, pins: LinearPins) -> None:
        self._pins = pins

    def fields(self) -> tuple[StoredFields, StoredFields]:
        """Return the even and the odd unit loads."""
        pins, (even_inertia, odd_inertia) = self._pins, inertial_fields(self._pins.inertia)
        even, odd = list[_Load](), list[_Load]()
        for bore in pins.bores:
            along, across, both = (pins.load(bore, force) for force in ((1.0, 0.0), (0.0, 1.0), (-1.0, 2.0)))
            x, y, mixed = (np.stack([load.forces.part(p) for p in Parity]) for load in (along, across, both))
            if np.abs(mixed + x - 2 * y).max() > _LINEAR * np.abs(x).max():
                rule = "is not linear in the components of the force: give it a span of its own"
                raise TypeError(f"{type(pins).__name__}.load {rule}")
            even.append((bore.surface, along.forces.symmetric, along.traction.symmetric))
            odd.append((bore.surface, odd_part(across.forces), odd_part(across.traction)))
        first = StoredFields.of(len(even), even, even_inertia, pins.tilt)
        return first, StoredFields.of(len(odd), odd, odd_inertia, pins.tilt)

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        forces, motions = [bore.force(instants) for bore in self._pins.bores], instants.motions
        return Weights(
            np.concatenate([*(force[:1] for force in forces), motions[:2]]),
            np.concatenate([*(force[1:] for force in forces), motions[2:]]),
        )
