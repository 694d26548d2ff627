"""The whole crank cycle of a rod at any speed, from one set of unit solutions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.analysis.cycle.basis import SmallBasis
from fea.analysis.cycle.criteria import critical_places, make_exact
from fea.analysis.cycle.envelope import Envelope, envelope, replaced, with_cases, worst_multiaxial
from fea.analysis.cycle.rows import SpannedRod
from fea.analysis.cycle.support import EVERY, relative_gradients
from fea.analysis.cycle.unit_solutions import PlaceHistory, UnitSolutions, distinct, spots
from fea.base.checks import LIMITS, Check
from fea.base.note import SINGULAR, Note, warning
from fea.base.units import DEG, UM
from fea.contact.assembly_state import FITS, AssemblyState, PinContact, bolt_forces
from fea.judge.case_result import CaseResult
from fea.judge.fatigue import fatigue_notes
from fea.pins.model import Weights
from fea.pins.prescribed import TOLERANCE
from fea.rod.places import SurfaceRegions
from fea.solid.stress import von_mises
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants, joined

# Limit of the check ``superposition`` if the pressure jumps, where the series does not converge: the error
# that counts as mesh-converged.
AT_JUMPS = 0.05
# Stress per part (n_nodes, 6, n) of n instants of a cycle, solved without unit loads.
Direct = Callable[[Instants, CrankCycle], Sequence[Floats]]
Solved = Sequence[Sequence[Floats]]  # von Mises stress (n_nodes,) of each part at each of some instants
_ALL_SOLVED = warning(
    "the smallest safety factors of the cycle could not be certified from a small basis: every instant is "
    "superposed exactly, as by --cycle-accuracy exact"
)
_AWAY = warning(
    "the safety factors of the cycle also leave out places where the exact stress is infinite", SINGULAR
)


@dataclass(frozen=True)
class CycleResult:
    """A cycle at one speed."""

    angles: Floats  #: (n_instants,) crank angles of the histories, rad: every degree
    envelope: Envelope  #: on the whole rod
    #: The worst places: that against fatigue where it governs, then by yielding
    spots: tuple[PlaceHistory, ...]
    weakest: PlaceHistory | None  #: the worst place against fatigue, or None if no fatigue strength is known
    #: Largest difference between superposed and directly solved von Mises stress over the peak cases,
    #: relative to the largest stress of each part in any of them
    superposition: float
    #: The same at the worst instants of a cycle that friction makes differ from the peak cases; None for a
    #: rod of one piece
    of_parts: float | None
    series_error: float  #: largest error of the series of the bore pressure, relative to its peak
    unit_solutions: int  #: number of unit solutions
    jumps: bool  #: whether the bore pressure jumps at the ends of its arc
    counts: Mask  #: (n_nodes,) nodes that count: those that are not near a stress singularity
    regions: SurfaceRegions  #: of the surface of the whole rod
    weights: Weights  #: of the unit loads at every degree
    known_notes: tuple[Note, ...] = ()  #: notes about the material for the user
    #: The worst place by Crossland's criterion, or None if no endurance limit is known
    multiaxial: PlaceHistory | None = None
    #: Contact of the pins with the bores at every degree; empty where their pressure is prescribed
    touches: tuple[Mapping[Surface, PinContact], ...] = ()
    #: Bolts and interfaces at every degree; empty for a rod of one piece
    states: tuple[AssemblyState, ...] = ()

    def checks(self) -> dict[str, Check]:
        """Compare the superposition with the directly solved cases and instants."""
        limit = AT_JUMPS if self.jumps else LIMITS["superposition"]
        checks = {"superposition": Check(self.superposition, limit)}
        if self.of_parts is not None:
            checks["superposition_of_parts"] = Check(self.of_parts, LIMITS["superposition_of_parts"])
        return checks

    def contact_columns(self) -> dict[str, Floats]:
        """Return, over the crank angle, contact on each bore, bolts, joint and fits."""
        columns = {"crank_deg": self.angles / DEG}
        for surface in self.touches[0]:
            end, touches = surface.value.removesuffix("_bore"), [instant[surface] for instant in self.touches]
            columns[f"{end}_pressure_MPa"] = np.array([touch.max_pressure for touch in touches])
            columns[f"{end}_at_deg"] = np.array([touch.at for touch in touches]) / DEG
            columns[f"{end}_z_mm"] = np.array([touch.at_z for touch in touches])
            columns[f"{end}_arc_deg"] = np.array([touch.arc for touch in touches]) / DEG
        if not self.states:  # a rod of one piece
            return columns
        joint = [state.joint for state in self.states]
        columns |= {f"bolt_{number}_N": force for number, force in enumerate(bolt_forces(self.states), 1)}
        for number, bolt in enumerate(zip(*(state.bolts for state in self.states), strict=True), 1):
            columns[f"bolt_{number}_bending_MPa"] = np.array([state.bending for state in bolt])
        columns["joint_clamp_N"] = np.array([state.force for state in joint])
        columns["joint_shear_N"] = np.array([state.shear for state in joint])
        columns["joint_open_percent"] = np.array([100 * state.open_share for state in joint])
        columns["joint_opening_um"] = np.array([state.opening / UM for state in joint])
        for seat, name in FITS.items():
            if seat in self.states[0].faces:
                fit = [state.faces[seat] for state in self.states]
                columns[f"{name}_mean_MPa"] = np.array([state.mean_pressure for state in fit])
                columns[f"{name}_least_MPa"] = np.array([state.min_pressure for state in fit])
                columns[f"{name}_lifted_percent"] = np.array([100 * state.open_share for state in fit])
        return columns

    def notes(self) -> tuple[Note, ...]:
        """Return the notes about the cycle for the user."""
        notes = self.known_notes if self.counts.all() else (*self.known_notes, _AWAY)
        if self.jumps:
            why = "jumps at the ends of its arc"
        elif self.series_error > 2 * TOLERANCE:
            why = "acts on a narrow arc"
        else:
            return notes
        apart = f"{100 * self.superposition:.2g} % of the largest stress of the peak cases"
        text = f"the bore pressure {why}, so that the superposed stress may err there by up to {apart}"
        return (*notes, warning(text))


@dataclass(frozen=True)
class CycleAnalysis(SpannedRod):
    """Superposes the unit solutions of a rod, and judges its cycles."""

    direct: Direct  #: stress per part (n_nodes, 6, n) of n instants of a cycle, solved without unit loads

    def at(self, cycle: CrankCycle, cases: Sequence[CaseResult]) -> CycleResult:
        """Compute the cycle at one speed; its envelope includes the solved peak `cases`."""
        degrees = cycle.degrees.crank_angle
        peaks = [case for case in cases if case.load.in_cycle]
        of_peaks = joined([case.load for case in peaks])
        instants = cycle.at(np.concatenate([degrees, of_peaks.crank_angle]))
        whole = self.mesh.mirrored
        counts, count = self.counts[whole.source], len(degrees)
        full, solved = self.basis.full(instants, cycle), [case.part_von_mises for case in peaks]
        at_peaks = full.at(slice(count, None))
        if self.loads.path_dependent and peaks:  # they were solved without what came before
            at_peaks = self.basis.full(of_peaks)
        # An error of a small basis is stated relative to the largest stress of all instants.
        small = self.basis if isinstance(self.basis, SmallBasis) else None
        top = _largest(solved) if small is None else [small.largest(cycle)] * len(self.units.parts)
        apart = self._differences(at_peaks, solved, top)
        while small is not None and small.corrected(cycle, at_peaks, apart * top[0]):
            apart = self._differences(at_peaks, solved, top)
        judged = self.supported_by(full.at(np.r_[0:count:EVERY, count : len(instants)]))
        extremes, multiaxial = judged.extremes_of(self.units, full, instants, count, counts)
        certain = True
        if small is not None:
            nodes, certain = judged.made_exact(small, cycle, instants, extremes, counts)
            exact, multiaxial = judged.extremes_of(self.units.of(nodes), full, instants, count, counts)
            extremes = replaced(extremes, exact, np.isin(whole.source, nodes))
        extremes = with_cases(extremes, cases)
        points, length = whole.mesh.points, self.mesh.bores.rod_length
        usage = np.where(counts, -extremes.usage, 0)
        weakest = _least(extremes.fatigue_factor, counts)
        tired = weakest if _fatigue_governs(extremes, weakest, usage) else []
        worst = [node for node in distinct(points, usage, length, tired) if counts[node]]
        of_degrees = self.basis.projected(full.at(slice(count)))
        part = {node: extremes.fatigue_part if node in tired else extremes.part for node in worst}
        places = [(node, int(part[node][node])) for node in worst]
        places += [(node, int(extremes.fatigue_part[node])) for node in weakest]
        histories = spots(places, self.units, of_degrees, whole)
        contacts = self.basis.contacts(cycle)
        return CycleResult(
            angles=degrees,
            envelope=extremes,
            spots=histories[: len(worst)],
            weakest=histories[-1] if weakest else None,
            superposition=float(apart.max(initial=self.basis.error)),
            of_parts=self._remembered(full, cycle, histories, solved),
            series_error=self.loads.series_error,
            unit_solutions=self.units.count,
            jumps=self.loads.jumps,
            counts=counts,
            regions=judged.regions.at(whole.source),
            weights=of_degrees,
            known_notes=(
                *fatigue_notes(self.materials, self.fatigue, cycle.engine.strokes),
                *([] if certain else [_ALL_SOLVED]),
            ),
            multiaxial=multiaxial,
            touches=contacts.touches,
            states=contacts.states,
        )

    def supported(self, cycle: CrankCycle) -> "CycleAnalysis":
        """Return it with the support of the surface by the gradients of stress over a cycle."""
        cases = cycle.peaks.cases
        angles = np.append(cycle.degrees.crank_angle[::EVERY], cases.crank_angle[cases.in_cycle])
        return self.supported_by(self.basis.full(cycle.at(angles), cycle))

    def supported_by(self, full: Weights) -> "CycleAnalysis":
        """Return the same over instants with these weights of all unit loads."""
        if not any(material.support for material in self.materials):
            return self
        gradient = relative_gradients(self, self.basis.projected(full))
        return replace(self, regions=replace(self.regions, gradient=gradient))

    def extremes_of(
        self, units: UnitSolutions, full: Weights, instants: Instants, degrees: int, counts: Mask
    ) -> tuple[Envelope, PlaceHistory | None]:
        """Envelope of the nodes of unit solutions, and the worst place by Crossland.

        The first instants are so many `degrees`, at which histories are taken.
        """
        whole, angles, weights = self.mesh.mirrored, instants.crank_angle, self.basis.projected(full)
        regions = self.regions.at(whole.source)
        found = envelope(
            units, weights, angles, whole, materials=self.materials, criterion=self.fatigue, regions=regions
        )
        multiaxial, factors = worst_multiaxial(
            found, units, weights.at(slice(degrees)), whole, self.materials, counts=counts, regions=regions
        )
        surface = np.stack([regions.factors(material) for material in self.materials])
        limits = np.array([[material.endurance_limit or np.nan] for material in self.materials])
        of_part = (surface * limits)[found.fatigue_part, np.arange(len(found.fatigue_part))]
        endurance = None if (surface == 1).all() else of_part
        return replace(found, crossland_factor=factors, endurance=endurance), multiaxial

    def made_exact(
        self, basis: SmallBasis, cycle: CrankCycle, instants: Instants, found: Envelope, counts: Mask
    ) -> tuple[Ints, bool]:
        """Grow a small basis; the nodes whose extremes are exact, and False if that took all instants."""
        whole = self.mesh.mirrored
        places = critical_places(found, whole, counts, basis.error * basis.largest(cycle))
        certain = make_exact(self, basis, basis.full(instants, cycle), places)
        if not certain:
            basis.exact_at(basis.full(instants, cycle))
        return np.unique(np.concatenate(list(places.values()))), certain

    def _differences(self, full: Weights, solved: Solved, largest: Sequence[float]) -> Floats:
        """Largest errors (n_instants,) of superposed von Mises stress, relative to `largest` of each part.

        Not relative to that of an instant: a cap that is hardly stressed then has the error of the pressure
        beside it all the same. `full`: weights of the full unit loads.
        """
        weights, worst = self.basis.projected(full), np.zeros(len(solved))
        for number in range(len(self.units.parts)):
            tensors = self.units.tensor(number, weights, self.mesh.mirrored)
            for k, stress in enumerate(solved):
                apart = np.nanmax(np.abs(von_mises(tensors[..., k]) - stress[number]))
                worst[k] = max(worst[k], apart / largest[number])
        return worst

    def _remembered(
        self, full: Weights, cycle: CrankCycle, histories: Sequence[PlaceHistory], peaks: Solved
    ) -> float | None:
        """Error at the instants at which places are worst, if friction makes these depend on the cycle.

        It is relative to the largest stress of each part, of the peak cases too.
        """
        if not self.loads.path_dependent:
            return None
        which = np.unique([np.abs(spot.signed).argmax() for spot in histories])
        stresses = self.direct(cycle.degrees[which], cycle)
        solved = [[von_mises(stress[..., k]) for stress in stresses] for k in range(len(which))]
        return float(self._differences(full.at(which), solved, _largest([*solved, *peaks])).max())


def _largest(solved: Solved) -> list[float]:
    """Largest von Mises stress of each part, MPa, at any of the instants."""
    return [float(np.nanmax(of_part)) for of_part in zip(*solved, strict=True)]


def _fatigue_governs(found: Envelope, weakest: Sequence[int], usage: Floats) -> bool:
    """Whether the factor at the `weakest` node is below all against yielding; `usage` is −1 over these."""
    factor = found.fatigue_factor
    return factor is not None and any(factor[node] < -1 / usage.min() for node in weakest)


def _least(factor: Floats | None, counts: Mask) -> list[int]:
    """Node of the smallest factor among those that count; none if no strength is known."""
    if factor is None:
        return []
    judged = np.where(counts, factor, np.nan)
    return [] if np.isnan(judged).all() else [int(np.nanargmin(judged))]
