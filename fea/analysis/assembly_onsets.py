"""When a joint opens and a fit lifts off: the multiple of the load case that comes nearest to it."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

from fea.analysis.assembly_figures import AssemblyFigures, OnsetFigures
from fea.analysis.prepare import PreparedRod
from fea.rod.assembly_state import AssemblyState
from fea.rod.omission import Omission
from fea.solid.errors import ContactError
from geometry.surfaces import Surface
from loads.cases import ASSEMBLY, LoadCase

if TYPE_CHECKING:
    from fea.contact.load_limits import LoadLimits

# Unknowns of the contact problem above which a dozen further states cost more than the rest of a run.
MOST_UNKNOWNS = 1500


class Onsets:
    """Follows the worst load cases until something comes apart.

    Parameters
    ----------
    rod
        Of separate parts.
    cases, states
        By name.
    """

    def __init__(
        self, rod: PreparedRod, cases: Mapping[str, LoadCase], states: Mapping[str, AssemblyState]
    ) -> None:
        self._rod, self._cases = rod, cases
        self._states = {name: state for name, state in states.items() if name != ASSEMBLY}
        self._assembled = states[ASSEMBLY]
        self._limits: dict[str, LoadLimits] = {}

    @cached_property
    def _possible(self) -> bool:
        return self._rod.contact.problem.fold.size <= MOST_UNKNOWNS

    def opens(self) -> OnsetFigures | None:
        """When the joint opens at the edge of the bore."""
        return self._of(self._separating, lambda limits: limits.opens())

    def separates(self) -> OnsetFigures | None:
        """When rod and cap come apart."""
        return self._of(self._separating, lambda limits: limits.separates())

    def lifts_off(self, seat: Surface) -> OnsetFigures | None:
        """When a part begins to lift off its seat, in the case that relieves the seat most."""
        faces = {name: state.faces[seat] for name, state in self._states.items()}
        worst = min(faces, key=lambda name: (faces[name].least, -faces[name].open_share))
        return self._of(worst, lambda limits: limits.lifts_off(seat))

    @cached_property
    def _separating(self) -> str:
        return max(self._states, key=lambda name: self._states[name].separating(self._assembled))

    def _of(self, case: str, begins: Callable[["LoadLimits"], float | None]) -> OnsetFigures | None:
        if not self._possible:
            return None
        from fea.contact.load_limits import LoadLimits  # noqa: PLC0415 - rods of one piece do without
        from fea.contact.onset import LARGEST  # noqa: PLC0415

        if case not in self._limits:
            self._limits[case] = LoadLimits(self._rod.held_together, self._cases[case], self._states[case])
        try:
            factor = begins(self._limits[case])
        except ContactError:
            return None
        return OnsetFigures(case=case, load_factor=factor, largest_factor=LARGEST)


def onsets_left_out(found: AssemblyFigures | None) -> tuple[Omission, ...]:
    """Say which onsets were not found, and why."""
    if found is None:
        return ()
    sought = {"opens": found.joint.opens, "comes apart": found.joint.separates}
    what = [f"the joint {verb}" for verb, onset in sought.items() if onset is None]
    what += [f"the seat of the {name} opens" for name, fit in found.fits.items() if fit.lifts_off is None]
    if not what:
        return ()
    why = f"it takes a contact problem of at most {MOST_UNKNOWNS} unknowns, and states that settle"
    return (Omission(f"load at which {', '.join(what)}", why),)
