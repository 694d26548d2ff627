"""Pins of which the big end's floats on an oil film: its pressure over the crank cycle loads the bore.

A prescribed pressure loads the small end, and also the big end of a rod at rest, as far as the film's smooth
functions represent it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from fea.base.note import assumption
from fea.pins.lubrication import TOPIC, Films
from fea.pins.model import PinModel, Response, Structure, UnitLoads, Weights
from fea.pins.prescribed import StoredFields
from fea.pins.pressure import Harmonics, PressedBore, PressedPins
from fea.solid.bore import radial_loads
from fea.solid.parity import Split
from fea.study.pin_models import PRESCRIBED
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.gas import CYCLE
from loads.instants import Instants


class FilmPins(PinModel):
    """A crank pin in its oil film, and a piston pin that presses with half a cosine."""

    notes = (
        assumption(
            f"{PRESCRIBED} presses on the small end, and on the big end of a rod at rest (gas)", TOPIC
        ),
    )

    def __init__(self, structure: Structure) -> None:
        self.films, self._crank_cycle = Films(structure), structure.crank_cycle
        self._prescribed = PressedPins.of(replace(structure, pressure=PRESCRIBED))

    @classmethod
    def of(cls, structure: Structure) -> Self:
        """Prepare the model for a rod."""
        return cls(structure)

    @cached_property
    def _units(self) -> "FilmUnits":
        return FilmUnits(self._prescribed, self.films, self._crank_cycle)

    @cached_property
    def _fields(self) -> tuple[StoredFields, StoredFields]:
        return self._units.fields()

    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Response]:
        """Return what acts on the rod at instants: see `PinModel.respond`."""
        weights = self._units.weights(instants, cycle)
        return [
            self._response(instant, even, odd)
            for instant, even, odd in zip(instants, weights.even.T, weights.odd.T, strict=True)
        ]

    def _response(self, instant: Instants, even: Floats, odd: Floats) -> Response:
        parts = []
        for fields, weights in zip(self._fields, (even, odd), strict=True):
            forces = np.tensordot(weights, np.stack(fields.nodal), axes=1)
            parts.append((forces, {surface: each @ weights for surface, each in fields.pressed.items()}))
        cut = self._prescribed.bores[0].facets.cut_y
        (forces, traction), (odd_forces, odd_traction) = parts
        return Response(
            forces=Split(forces, odd_forces) if cut else Split(forces + odd_forces, None),
            traction={
                surface: Split(traction[surface], odd_traction[surface])
                if cut
                else Split(traction[surface] + odd_traction[surface], None)
                for surface in traction
            },
            largest=float(instant.largest_force),
        )

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:  # noqa: ARG002
        """Return the film's functions, harmonics of the pressure on the small end, and inertia."""
        return self._units


class FilmUnits(Harmonics):
    """Harmonics on the small end, smooth functions on the big end, and inertia."""

    def __init__(self, pins: PressedPins, films: Films, crank_cycle: Callable[[float], CrankCycle]) -> None:
        super().__init__(pins)
        self._films, self._crank_cycle = films, crank_cycle
        *self.bores, big = self.bores
        self._facets, self._functions = films.facets, films.bore.functions
        # Of the functions that are constant over the width, the harmonics.
        n, m = self._functions.terms.T
        self._plain = np.flatnonzero(m == 0)
        self._at_rest = PressedBore(big.bore, big.arcs, n[self._plain])
        self._number = len(n)

    def _count(self, parity: int) -> int:
        of_film = self._functions.count - self._number if parity else self._number
        return super()._count(parity) + of_film

    def _harmonics(self, parity: int) -> Iterator[tuple[Surface, Floats, Floats]]:
        yield from super()._harmonics(parity)
        facets, z = self._facets, self._facets.corners[..., 2]
        there = self._functions.at(facets.angle, z @ facets.shape_values.T)[parity]
        nodal = self._functions.at(facets.node_angle, z)[parity]
        for load in radial_loads(facets, self._pins.n_nodes, there, nodal):
            yield Surface.BIG_END_BORE, *load

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        (small,) = self.bores
        pressed = small.weights(small.bore.force(instants))
        even, odd = np.split(self._of_film(instants, cycle), [self._number])
        return Weights(
            np.concatenate([pressed.even, even, instants.motions[:2]]),
            np.concatenate([pressed.odd, odd, instants.motions[2:]]),
        )

    def _of_film(self, instants: Instants, cycle: CrankCycle | None) -> Floats:
        """Weights (n_functions, n_instants) of the pressure on the big end, whose resultant is the force."""
        speeds = np.atleast_1d(instants.speed)
        weights = np.zeros((self._functions.count, len(speeds)))
        for speed in np.unique(speeds[np.isfinite(speeds)]):
            here = speeds == speed
            fine, _ = self._films.at(cycle or self._crank_cycle(float(speed)))
            weights[:, here] = _between(fine.weights, instants.crank_angle[here])
        rest = ~np.isfinite(speeds)
        if rest.any():
            still = self._at_rest.weights(instants.crank[:, rest])
            scales = self._functions.scales[self._plain]
            weights[np.ix_(self._plain, rest)] = still.even / scales[:, None]
            odd = self._number + np.flatnonzero(
                self._functions.terms[self._functions.terms[:, 0] > 0, 1] == 0
            )
            weights[np.ix_(odd, rest)] = still.odd / scales[1:, None]
        moved = self._functions.translations
        missing = instants.crank.reshape(2, -1) - self._resultants @ weights
        weights[moved] += np.linalg.solve(self._resultants[:, moved], missing)
        return weights

    @cached_property
    def _resultants(self) -> Floats:
        """Force (2, n_functions) on the whole rod's mesh of each function, N."""
        facets = self._facets
        both = self._functions.at(facets.angle, facets.corners[..., 2] @ facets.shape_values.T)
        return np.concatenate(facets.resultants(*both), axis=1)


def _between(weights: Floats, angles: Floats) -> Floats:
    """Weights (n_functions, n) at crank angles from those (n_steps, n_functions) at steps of a cycle."""
    places = angles / CYCLE * len(weights)
    first = np.floor(places).astype(int)
    share = places - first
    one, other = (weights[number % len(weights)].T for number in (first, first + 1))
    return np.asarray(one + share * (other - one))
