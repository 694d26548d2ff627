"""Nodal forces of a load case on the meshed cell."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fea.base.choices import Support
from fea.contact.assembly_state import AssemblyState
from fea.contact.touch import Touch
from fea.pins.pin_loads import pin_loads
from fea.rod.meshed_rod import Bores
from fea.solid.bore import bore_facets
from fea.solid.inertia import Inertia
from fea.solid.parity import Split
from fea.solid.tilt import Tilt
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.bearing import PinLoad
from loads.instants import Instants
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class CaseForces:
    """Nodal forces of a case and how well they balance.

    Attributes
    ----------
    forces
        On the cell, N.
    traction
        On each pressed bore, MPa.
    scale
        The correction factor of the two bore pressures that is farther from 1.
    largest
        The largest bore force, N.
    tilt
        Moment out of the plane of motion that the rod's inertia balances, over the largest bore force times
        the rod's length; None if mirror planes or a clamp exclude such a moment.
    touch
        Contact of the pins with the bores; empty where their pressure is prescribed.
    shift
        Rigid displacement of separate parts, on the cell, mm; None for a rod of one piece.
    growth
        Free thermal expansion of such a rod, on the cell, mm, which causes no stress; None without it.
    checks
        Further values to be held against the limits of `fea.base.checks`, by name.
    assembly
        Bolts and interfaces of a rod of separate parts.
    pressure, gap
        (n_nodes,) contact pressure, MPa, and gap between separate parts, mm; None for a rod of one piece.
    """

    forces: Split
    traction: dict[Surface, Split]
    scale: float
    largest: float
    tilt: float | None = None
    touch: Mapping[Surface, Touch] = field(default_factory=dict)
    shift: Split | None = None
    growth: Split | None = None
    checks: Mapping[str, float] = field(default_factory=dict)
    assembly: AssemblyState | None = None
    pressure: Split | None = None
    gap: Split | None = None


class NodalForces:
    """Turns load cases into nodal forces; the geometry of the bores is worked out once.

    Parameters
    ----------
    mesh
        The meshed cell.
    bores
        Dimensions of the bores.
    inertia
        Inertia of the same mesh.
    pressure
        How the pins load the bores.
    support
        With a clamped big end, the crank force is a reaction and not applied.
    """

    def __init__(
        self, mesh: TetMesh, bores: Bores, inertia: Inertia, pressure: PinLoad, support: Support
    ) -> None:
        self._bores, self._inertia, self._support = bores, inertia, support
        facets = {Surface.SMALL_END_BORE: bore_facets(mesh, Surface.SMALL_END_BORE, bores.rod_length)}
        if support is not Support.CLAMPED:
            facets[Surface.BIG_END_BORE] = bore_facets(mesh, Surface.BIG_END_BORE, 0.0)
        self._pins = pin_loads(pressure, bores, facets, len(mesh.points))
        self._tilt = Tilt.where_free(mesh, inertia, held=support is Support.CLAMPED)

    def __call__(self, case: Instants) -> CaseForces:
        """Nodal forces of everything that acts in `case`."""
        pin, crank = ((float(x), float(y)) for x, y in (case.pin, case.crank))
        loads = {Surface.SMALL_END_BORE: self._pins(Surface.SMALL_END_BORE, pin, float(case.pin_axial))}
        if self._support is not Support.CLAMPED:
            loads[Surface.BIG_END_BORE] = self._pins(Surface.BIG_END_BORE, crank, float(case.crank_axial))
        parts = [load.forces for load in loads.values()]
        if case.motions.any():
            parts.append(self._inertia.forces(case))
        forces, tilt = self._upright(_total(parts), float(case.largest_force))
        return CaseForces(
            forces,
            {surface: load.traction for surface, load in loads.items()},
            max((load.scale for load in loads.values()), key=lambda scale: abs(scale - 1)),
            float(case.largest_force),
            tilt,
        )

    def _upright(self, forces: Split, largest: float) -> tuple[Split, float | None]:
        """Forces without their out-of-plane part, and the relative moment that was removed.

        A mesh that can tilt is not cut at z = 0 and hence not at y = 0: the forces have one part only.
        """
        if self._tilt is None:
            return forces, None
        force, *moments = self._tilt.out_of_plane(forces.symmetric)
        length = self._bores.rod_length
        tilt = max(abs(force) * length, *map(abs, moments)) / (largest * length)
        return Split(self._tilt.balanced(forces.symmetric), None), float(tilt)


def _total(parts: Sequence[Split]) -> Split:
    odd = [part.antisymmetric for part in parts if part.antisymmetric is not None]
    return Split(np.sum([part.symmetric for part in parts], axis=0), np.sum(odd, axis=0) if odd else None)


def imbalance(points: Floats, forces: Split, images: int) -> tuple[float, float]:
    """Resultant force (N) and moment about z (N·mm) of nodal forces on the whole rod, both zero in balance.

    Parameters
    ----------
    points
        Nodes of the cell, (n_nodes, 3).
    forces
        On the cell.
    images
        Number of cells that make the whole rod.
    """
    x_part = forces.symmetric
    y_part = forces.symmetric if forces.antisymmetric is None else forces.antisymmetric
    moment = points[:, 0] @ y_part[:, 1] - points[:, 1] @ y_part[:, 0]
    resultant = np.hypot(x_part[:, 0].sum(), y_part[:, 1].sum())
    return float(images * resultant), float(images * abs(moment))
