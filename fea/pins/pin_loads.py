"""What the pins do to the bores in a load case, where it is prescribed."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from fea.rod.meshed_rod import Bores
from fea.solid.bonded_bore import BondedBore
from fea.solid.bore import BoreFacets, BoreLoad, bore_load
from geometry.surfaces import Surface
from loads.bearing import Bonded, BorePressure, PinLoad


class PinLoads(Protocol):
    """Loads the bores with the forces of their pins."""

    def __call__(self, surface: Surface, force: tuple[float, float], axial: float) -> BoreLoad:
        """Load a bore.

        Parameters
        ----------
        surface
            The bore.
        force
            (x, y) on the whole rod, N.
        axial
            Axial force at this end, N: above zero it pulls the end outwards.
        """


def pin_loads(load: PinLoad, bores: Bores, facets: Mapping[Surface, BoreFacets], n_nodes: int) -> PinLoads:
    """Return what loads the meshed bores.

    Parameters
    ----------
    load
        How a pin loads its bore.
    bores
        Dimensions of the bores.
    facets
        Of each bore.
    n_nodes
        Of the mesh.
    """
    if isinstance(load, Bonded):
        return _BondedPins(load, bores, facets, n_nodes)
    return _PressingPins(load, bores, facets, n_nodes)


class _PressingPins:
    """Pins that press on one side of their bores."""

    def __init__(
        self, pressure: BorePressure, bores: Bores, facets: Mapping[Surface, BoreFacets], n_nodes: int
    ) -> None:
        self._pressure, self._bores, self._facets, self._n_nodes = pressure, bores, facets, n_nodes

    def __call__(self, surface: Surface, force: tuple[float, float], axial: float) -> BoreLoad:
        arc, (radius, width, taper) = self._pressure.arc(axial), _measures(self._bores, surface)
        taper *= float(np.cos(np.arctan2(force[1], force[0])))  # along the force
        peak = arc.peak(float(np.hypot(*force)), radius, width, taper)
        pressed = self._facets[surface]
        return bore_load(pressed, self._n_nodes, force, lambda psi: peak * arc.unbounded(psi), arc.angle / 2)


class _BondedPins:
    """Pins that are bonded to their bores."""

    def __init__(
        self, bonded: Bonded, bores: Bores, facets: Mapping[Surface, BoreFacets], n_nodes: int
    ) -> None:
        self._bonded, self._bores = bonded, bores
        self._bonds = {surface: BondedBore.of(bore, n_nodes) for surface, bore in facets.items()}

    def __call__(self, surface: Surface, force: tuple[float, float], axial: float) -> BoreLoad:  # noqa: ARG002
        radius, width, _ = _measures(self._bores, surface)
        return self._bonds[surface].load(force, self._bonded.area(radius, width))


def _measures(bores: Bores, surface: Surface) -> tuple[float, float, float]:
    """Radius, mean width and taper of a bore, mm."""
    if surface is Surface.SMALL_END_BORE:
        return bores.small_radius, bores.small_width, bores.small_taper
    return bores.big_radius, bores.big_width, 0.0
