"""Pins that float on oil films: their pressures over the crank cycle load the bores.

A prescribed pressure loads the bores of a rod at rest, as far as the smooth functions of a film represent it,
and a small end into which its pin is pressed.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from fea.base.note import assumption
from fea.contact.friction_system import Load
from fea.film.cycle import between
from fea.film.functions import FilmPressure
from fea.pins.assembly import AssemblyContact, AssemblyPins
from fea.pins.lubrication import TOPIC, Films
from fea.pins.model import PinModel, PinModelContext, Response, UnitLoads, Weights
from fea.pins.prescribed import Harmonics, PressedBore, PressedPins
from fea.pins.yielding import End
from fea.study.pin_models import PRESCRIBED
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants


class FilmPins(PinModel):
    """A crank pin and a piston pin in their oil films, or a piston pin that is pressed into its bore."""

    def __init__(self, structure: PinModelContext) -> None:
        super().__init__(structure)
        self.films = {end: Films(structure, end) for end in End if not end.pressed_in(structure)}
        fixed = "" if End.SMALL in self.films else "on the small end, whose pin is pressed in, and "
        text = f"{PRESCRIBED} presses {fixed}on the bores of a rod at rest (gas)"
        self.notes = (assumption(text, TOPIC),)
        self._prescribed = PressedPins.of(replace(structure, pressure=PRESCRIBED))

    @cached_property
    def _units(self) -> "_FilmUnits":
        return _FilmUnits(self._prescribed, self.films, self.structure.crank_cycle)

    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Response]:
        """Return what acts on the rod at instants: see `PinModel.respond`."""
        films = self._units.films
        weights = {surface: film.weights(instants, cycle) for surface, film in films.items()}
        return [
            self._prescribed.response(
                instant, {surface: film.pressed(weights[surface][:, k])[0] for surface, film in films.items()}
            )
            for k, instant in enumerate(instants)
        ]

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:  # noqa: ARG002
        """Return the films' functions, harmonics of other pressures, and inertia."""
        return self._units


class _FilmUnits(Harmonics):
    """Smooth functions on bores with films, harmonics on others, and inertia."""

    def __init__(
        self, pins: PressedPins, films: Mapping[End, Films], crank_cycle: Callable[[float], CrankCycle]
    ) -> None:
        super().__init__(pins)
        at_rest = {pressed.bore.surface: pressed for pressed in self.bores}
        self.films = {
            end.bore: _FilmLoad(own, crank_cycle, pins.n_nodes, at_rest.pop(end.bore))
            for end, own in films.items()
        }
        self.bores = list(at_rest.values())

    def _count(self, parity: int) -> int:
        return super()._count(parity) + sum(film.counts[parity] for film in self.films.values())

    def _harmonics(self, parity: int) -> Iterator[tuple[Surface, Floats, Floats]]:
        yield from super()._harmonics(parity)
        for surface, film in self.films.items():
            for load in film.loads(parity):
                yield surface, *load

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        pressed = [bore.weights(bore.bore.force(instants)) for bore in self.bores]
        films = self.films.values()
        floats = [np.split(film.weights(instants, cycle), film.counts[:1]) for film in films]
        even, odd = zip(*pressed, *floats, (instants.motions[:2], instants.motions[2:]), strict=True)
        return Weights(np.concatenate(even), np.concatenate(odd))


class _FilmLoad(FilmPressure):
    """What a film presses on its bore at instants; `at_rest`: on a rod at rest, else nothing."""

    def __init__(
        self,
        films: Films,
        crank_cycle: Callable[[float], CrankCycle],
        n_nodes: int,
        at_rest: PressedBore | None = None,
    ) -> None:
        super().__init__(films.facets, films.functions, n_nodes)
        self._films, self._crank_cycle = films, crank_cycle
        # Of the functions that are constant over the width, the harmonics.
        n, m = self.functions.terms.T
        self._plain = np.flatnonzero(m == 0), len(n) + np.flatnonzero(m[n > 0] == 0)
        self._at_rest = at_rest and PressedBore(at_rest.bore, at_rest.arcs, n[m == 0])

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Floats:
        """Weights (n_functions, n_instants) of the pressure, whose resultant is the force of the pin.

        `cycle`: that the instants belong to; by default that of their speed and the study's gas. Of a
        multiple of what acts at an instant, it is the multiple of that instant's.
        """
        end, speeds = self._films.end, np.atleast_1d(instants.speed)
        acting = end.force(instants).reshape(2, -1)
        weights = np.zeros((self.functions.count, len(speeds)))
        for speed in np.unique(speeds[np.isfinite(speeds)]):
            here = speeds == speed
            own, angles = cycle or self._crank_cycle(float(speed)), instants.crank_angle[here]
            fine, *_ = self._films.at(own)
            forces = end.force(own.at(angles))
            factors = (acting[:, here] * forces).sum(axis=0) / (forces**2).sum(axis=0)
            weights[:, here] = (
                factors * between(fine.weights, angles / own.engine.cycle * len(fine.weights)).T
            )
        rest = ~np.isfinite(speeds)
        if self._at_rest is not None and rest.any():
            still, scales = self._at_rest.weights(acting[:, rest]), self.functions.scales
            of_plain = scales[self._plain[0]][:, None]
            for plain, own_weights, scale in zip(self._plain, still, (of_plain, of_plain[1:]), strict=True):
                weights[np.ix_(plain, rest)] = own_weights / scale
        moved = self.functions.translations
        missing = acting - self.resultants @ weights
        weights[moved] += np.linalg.solve(self.resultants[:, moved], missing)
        return weights


class FilmPartsPins(AssemblyPins):
    """Pins of a rod in parts, whose film loads the big end while its joint is closed, as under contact.

    Where that opens, the film would follow it, which a pressure that is given cannot; there, and at rest, the
    crank pin presses by contact.
    """

    def __init__(self, structure: PinModelContext) -> None:
        super().__init__(structure)
        text = "where the joint opens, and on a rod at rest (gas), the crank pin presses by contact"
        self.notes, self._touched = (*self.notes, assumption(text, TOPIC)), _Touched(self)
        self._own = Films(structure, End.BIG, self._touched)
        self.films = {End.BIG: self._own}

    @cached_property
    def _film(self) -> _FilmLoad:
        return _FilmLoad(self._own, self.structure.crank_cycle, len(self.structure.mesh.points))

    def _problem(self) -> AssemblyContact:
        return AssemblyContact(self.structure, self.fits, self._film)

    def loads(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Load]:
        """What acts between the parts: see `AssemblyPins.loads`."""
        moving = np.flatnonzero(np.isfinite(instants.speed))
        states = self._touched.states(instants[moving], cycle)
        closed = moving[[not self._own.opened(state) for state in states]]
        weights = np.zeros((self._own.functions.count, len(instants)))
        if closed.size:
            weights[:, closed] = self._film.weights(instants[closed], cycle)
        return self.assembly.loads(instants, weights)


class _Touched(AssemblyPins):
    """The same parts under contact with both pins."""

    def __init__(self, pins: FilmPartsPins) -> None:
        super().__init__(pins.structure)
        self._pins = pins

    @property
    def assembly(self) -> AssemblyContact:
        return self._pins.assembly
