"""From the cases of an assembled rod to its figures, and the loads at which it begins to come apart."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
from scipy.optimize import brentq

from fea.analysis.assembling import AssemblySetup
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.figures import OvalityFigures, figures
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.summary_figures import (
    AssemblyFigures,
    BoltCaseFigures,
    BoltsFigures,
    FaceCaseFigures,
    FitFigures,
    JointCaseFigures,
    JointCycleFigures,
    JointFigures,
    OnsetFigures,
)
from fea.base.note import Note, omission, remark, warning
from fea.base.units import DEG, KN, UM
from fea.contact.assembly_state import FITS, AssemblyState
from fea.judge.bolt import BoltResult
from fea.judge.bolt_choice import BOLTS
from fea.judge.case_result import CaseResult
from fea.pins.assembly import AssemblyPins
from fea.solid.bore import bore_shape
from fea.solid.errors import ContactError
from fea.study.material_table import REFERENCE_TEMPERATURE
from geometry.surfaces import Surface
from loads.instants import ASSEMBLY, Instants

States = Mapping[str, AssemblyState]  #: by load case, `ASSEMBLY` among them
# Unknowns of the contact problem above which a dozen further states cost more than the rest of a run.
MOST_UNKNOWNS = 1500


# Least and largest multiple that are tried, relative error of the multiple, and most steps to it.
LEAST, LARGEST, WITHIN, _MOST = 1 / 1024, 8.0, 0.02, 12


def onset(left: Callable[[float], float]) -> float | None:
    """Find where what is left of something first falls to zero; 0 where nothing is left without load.

    `left`: by the multiple, at least continuous before it falls to zero.

    Returns None beyond `LARGEST`.
    """
    if left(0.0) <= 0:
        return 0.0
    high = 1.0
    while left(high) > 0:
        if high >= LARGEST:
            return None
        high *= 2
    low = high / 2
    while left(low) <= 0:
        if low <= LEAST:
            return low
        low, high = low / 2, low
    return float(brentq(left, low, high, xtol=WITHIN * low / 4, maxiter=_MOST, disp=False))


# What is left beyond the onset, relative to what there is without load: its sign is what matters.
_LOST = -0.1
# Share of the clamping force below which rod and cap have come apart.
_APART = 1e-3


class Onsets:
    """Follows the worst load cases as all loads grow, until parts separate; None where none do."""

    def __init__(self, pins: AssemblyPins, cases: Mapping[str, Instants], states: States) -> None:
        self._pins, self._cases, self._assembled = pins, cases, states[ASSEMBLY]
        self._states = {(name, 1.0): state for name, state in states.items() if name != ASSEMBLY}

    def opens(self) -> OnsetFigures | None:
        """When the joint opens at the edge of the bore, in the case that pulls it apart most."""
        return self._of(self._separating, lambda state: state.joint.edge_pressure or 0.0)

    def separates(self) -> OnsetFigures | None:
        """When rod and cap come apart, in the same case."""
        clamped = self._assembled.joint.force
        return self._of(self._separating, lambda state: state.joint.force - _APART * clamped)

    def lifts_off(self, seat: Surface) -> OnsetFigures | None:
        """When a part begins to lift off its seat, in the case that relieves the seat most."""
        return self._of(
            lambda state: (-state.faces[seat].min_pressure, state.faces[seat].open_share),
            lambda state: 0.0 if state.faces[seat].open_share > 0 else state.faces[seat].min_pressure,
        )

    def _separating(self, state: AssemblyState) -> tuple[float]:
        return (state.separating(self._assembled),)

    def _of(
        self,
        severity: Callable[[AssemblyState], tuple[float, ...]],
        measure: Callable[[AssemblyState], float],
    ) -> OnsetFigures | None:
        if self._pins.contact.problem.unfolding.size > MOST_UNKNOWNS:
            return None
        loaded = [key for key in self._states if key[1] == 1]
        case, _ = max(loaded, key=lambda key: severity(self._states[key]))
        lost = _LOST * measure(self._assembled)

        def left(factor: float) -> float:
            if (case, factor) not in self._states and factor:
                self._states[case, factor] = self._pins.state_under(self._cases[case], factor)
            value = measure(self._states[case, factor] if factor else self._assembled)
            return value if value > 0 else lost

        try:
            factor = onset(left)
        except ContactError:
            return None
        return OnsetFigures(case=case, load_factor=factor, largest_factor=LARGEST)


def onset_notes(found: AssemblyFigures | None) -> tuple[Note, ...]:
    """Say which onsets were not found, and why."""
    if found is None:
        return ()
    sought = {"opens": found.joint.opens, "comes apart": found.joint.separates}
    what = [f"the joint {verb}" for verb, onset in sought.items() if onset is None]
    what += [f"the seat of the {name} opens" for name, fit in found.fits.items() if fit.lifts_off is None]
    if not what:
        return ()
    why = f"found only for contact problems of at most {MOST_UNKNOWNS} unknowns whose states settle"
    return (omission(f"load at which {', '.join(what)}", why),)


def touch_notes(found: AssemblyFigures | None) -> Iterator[Note]:
    """Say where a seat's edge lifts, which the model does not have, and where bolts bear on their holes."""
    if found is None:
        return
    bolts = found.bolts
    if bolts.seat_lift_ratio > 1:
        yield warning(
            f"a seat lifts at one edge: its moment is {bolts.seat_lift_ratio:.2f} times what its core "
            "carries; the model holds the whole seat, which overestimates bending",
            BOLTS,
        )
    if round(bolts.shear_N) > 0:
        yield remark(f"they bear on their holes, by up to {bolts.shear_N / KN:.2g} kN", BOLTS)


# Share of the clamping force below which the load on the joint is too small for a ratio.
_LITTLE = 0.01


def bolts_figures(
    assembling: AssemblySetup, states: States, cycle: CycleResult | None = None
) -> BoltsFigures:
    """Judge the bolts by their forces in the load cases, `ASSEMBLY` among them, and over the cycle."""
    chosen, bolt, table = assembling.bolt, assembling.bolt.bolt, assembling.table
    cases = list(states)
    in_time = list(states.values()) if cycle is None else cycle.states
    every = [*states.values(), *in_time]
    bends = [one for state in every for one in state.bolts]
    judged = partial(judged_bolts, assembling)
    all_judged = judged(every)
    hardest = max(all_judged, key=lambda one: one.largest_force)
    over_time = judged(in_time)
    tired = max(over_time, key=lambda one: one.amplitude)
    bent = min(over_time, key=lambda one: one.bending_fatigue_safety)
    at = hardest.largest_at
    case = cases[at] if at < len(cases) else None
    return figures(
        BoltsFigures,
        hardest,
        thread=bolt.thread.name,
        preload_N=chosen.preload,
        tightened=str(chosen.tightening) if table.bolt_torque_Nm or table.bolt_stretch_mm else None,
        proof_load_N=bolt.proof_load,
        vdi_load_factor=chosen.load_factor,
        max_force_N=hardest.largest_force,
        max_case=case,
        max_crank_deg=None if cycle is None or case else float(cycle.angles[at - len(cases)]) / DEG,
        min_force_N=min(one.least_force for one in all_judged),
        amplitude_N=tired.force_amplitude,
        yield_safety_factor=hardest.working_safety,
        alternating_stress_MPa=tired.amplitude,
        endurance_MPa=tired.endurance,
        fatigue_safety_factor=_where_finite(tired.fatigue_safety),
        max_bending_MPa=max(one.bending for one in bends),
        bending_yield_safety_factor=min(one.bending_safety for one in all_judged),
        bending_alternating_stress_MPa=bent.bending_amplitude,
        bending_fatigue_safety_factor=_where_finite(bent.bending_fatigue_safety),
        seat_lift_ratio=max((bolt.lift(one.force, one.ends) for one in bends if one.force > 0), default=0.0),
        hole_play_mm=bolt.play,
        shear_N=max(one.shear for one in bends),
        shear_MPa=max(one.shear_stress for one in all_judged),
        by_case={case: _by_bolt(state, states[ASSEMBLY]) for case, state in states.items()},
    )


def judged_bolts(assembling: AssemblySetup, states: Sequence[AssemblyState]) -> list[BoltResult]:
    """Judge each bolt over a sequence of states."""
    over_time = zip(*(state.bolts for state in states), strict=True)
    return [
        BoltResult.of(
            assembling.bolt,
            np.array([one.force for one in course]),
            np.array([one.fibre for one in course]),
            np.array([one.thread_bending for one in course]),
            max(one.shear for one in course),
        )
        for course in over_time
    ]


def _where_finite(factor: float) -> float | None:
    return factor if np.isfinite(factor) else None


def _by_bolt(state: AssemblyState, assembled: AssemblyState) -> tuple[BoltCaseFigures, ...]:
    """Return each bolt's force, and Φ: its change over its share in the load on the joint."""
    count = sum(bolt.count for bolt in state.bolts)
    share = state.separating(assembled) / count
    enough = abs(share) * count > _LITTLE * assembled.bolt_force
    return tuple(
        figures(
            BoltCaseFigures,
            bolt,
            change_N=bolt.force - before.force,
            load_factor=(bolt.force - before.force) / share if enough else None,
        )
        for bolt, before in zip(state.bolts, assembled.bolts, strict=True)
    )


def assembly_figures(
    rod: PreparedRod, cases: Mapping[str, CaseResult], cycle: CycleResult | None = None
) -> AssemblyFigures | None:
    """Return the figures of bolts, joint and fits by load case, `ASSEMBLY` among them; None for one piece."""
    specification, pins = rod.structure.assembly, rod.assembly_contact
    if rod.assembling is None or specification is None or pins is None:
        return None
    table = rod.assembling.table
    states = {name: case.assembly for name, case in cases.items() if case.assembly is not None}
    ends = {Surface.SMALL_END_BORE: rod.mesh.bores.rod_length, Surface.BIG_END_BORE: 0.0}
    onsets = Onsets(pins, {name: case.load for name, case in cases.items()}, states)
    return AssemblyFigures(
        parts=tuple(rod.mesh.parts),
        temperature_C=REFERENCE_TEMPERATURE if table.temperature_C is None else table.temperature_C,
        bolts=bolts_figures(rod.assembling, states, cycle),
        joint=_joint(specification.friction, states, onsets, cycle),
        fits={
            name: FitFigures(
                interference_mm=2 * specification.interference.get(seat, 0.0),
                lifts_off=onsets.lifts_off(seat),
                by_case={case: figures(FaceCaseFigures, state.faces[seat]) for case, state in states.items()},
            )
            for seat, name in FITS.items()
            if seat in states[ASSEMBLY].faces
        },
        ovality={
            surface.value: {name: ovality_figures(case, surface, x) for name, case in cases.items()}
            for surface, x in ends.items()
        },
    )


def _joint(friction: float, states: States, onsets: Onsets, cycle: CycleResult | None) -> JointFigures:
    assembled = states[ASSEMBLY]
    by_case = {
        name: figures(
            JointCaseFigures,
            state.joint,
            clamp_force_N=state.joint.force,
            separating_N=state.separating(assembled),
        )
        for name, state in states.items()
    }
    return JointFigures(
        friction=friction,
        opens=onsets.opens(),
        separates=onsets.separates(),
        by_case=by_case,
        cycle=None if cycle is None else _joint_cycle(cycle),
    )


def _joint_cycle(cycle: CycleResult) -> JointCycleFigures:
    joint, angle = [state.joint for state in cycle.states], cycle.angles / DEG
    clamp, opening = np.array([state.force for state in joint]), np.array([state.opening for state in joint])
    least, widest = int(clamp.argmin()), int(opening.argmax())
    reserves = [state.slip_reserve for state in joint if state.slip_reserve is not None]
    return JointCycleFigures(
        min_clamp_force_N=float(clamp[least]),
        min_clamp_crank_deg=float(angle[least]),
        max_opening_um=float(opening[widest]) / UM,
        max_opening_crank_deg=float(angle[widest]),
        open_percent=100 * float(np.mean([state.edge_pressure == 0 for state in joint])),
        min_slip_reserve=min(reserves, default=None),
    )


def ovality_figures(case: CaseResult, surface: Surface, x: float) -> OvalityFigures:
    """Return the change of shape of a bore whose centre is at x, mm."""
    shape = bore_shape(case.mesh, surface, x, case.distortion)
    (widest, wide), (narrowest, narrow) = shape.widest, shape.narrowest
    return OvalityFigures(
        ovality_mm=shape.ovality,
        widest_mm=widest,
        widest_deg=wide / DEG,
        narrowest_mm=narrowest,
        narrowest_deg=narrow / DEG,
    )
