"""The bolts of a cap over the load cases, judged by VDI 2230."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from fea.analysis.assembling import Assembling
from fea.analysis.assembly_figures import BoltCaseFigures, BoltsFigures
from fea.analysis.figure_types import vector
from fea.assess.bolt_result import BoltResult
from fea.cycle.assembly_history import bolt_forces
from fea.cycle.superposition import CycleResult
from fea.rod.assembly_state import AssemblyState
from fea.units import DEG
from loads.cases import ASSEMBLY

# Share of the clamping force below which the load on the joint is too small for a ratio.
_LITTLE = 0.01


def bolts_figures(
    assembling: Assembling, states: Mapping[str, AssemblyState], cycle: CycleResult | None = None
) -> BoltsFigures:
    """Judge the bolts.

    Parameters
    ----------
    assembling
        The bolts of the study.
    states
        By load case; `ASSEMBLY` is one of them.
    cycle
        The whole crank cycle, if it was worked out: its amplitude counts then.
    """
    chosen, bolt = assembling.bolt, assembling.bolt.bolt
    cases, forces = list(states), bolt_forces(list(states.values()))
    over_time = forces if cycle is None else bolt_forces(cycle.states)
    judged = partial(BoltResult.of, bolt, turned=assembling.table.bolt_stretch_mm is None)
    hardest = max(map(judged, np.concatenate([forces, over_time], axis=1)), key=lambda one: one.largest_force)
    tired = max(map(judged, over_time), key=lambda one: one.amplitude)
    at = hardest.largest_at
    case = cases[at] if at < len(cases) else None
    angle = _angle(cycle, at - len(cases)) if case is None else None
    fatigue = tired.fatigue_safety
    return BoltsFigures(
        thread=bolt.thread.name,
        preload_N=bolt.preload,
        proof_load_N=bolt.proof_load,
        vdi_load_factor=chosen.load_factor,
        max_force_N=hardest.largest_force,
        max_case=case,
        max_crank_deg=angle,
        min_force_N=float(min(forces.min(), over_time.min())),
        amplitude_N=tired.force_amplitude,
        tightening_use=hardest.tightening_use,
        proof_use=hardest.proof_use,
        yield_safety_factor=hardest.working_safety,
        alternating_stress_MPa=tired.amplitude,
        endurance_MPa=tired.endurance,
        fatigue_safety_factor=fatigue if np.isfinite(fatigue) else None,
        seat_pressure_MPa=hardest.seat_pressure,
        by_case={case: _by_bolt(state, states[ASSEMBLY]) for case, state in states.items()},
    )


def _angle(cycle: CycleResult | None, at: int) -> float | None:
    return None if cycle is None else float(cycle.angles[at]) / DEG


def _by_bolt(state: AssemblyState, assembled: AssemblyState) -> tuple[BoltCaseFigures, ...]:
    """Return each bolt's force, and Φ: its change over its share in the load on the joint."""
    count = sum(bolt.count for bolt in state.bolts)
    share = state.separating(assembled) / count
    enough = abs(share) * count > _LITTLE * assembled.bolt_force
    return tuple(
        BoltCaseFigures(
            at_mm=vector(bolt.at),
            force_N=bolt.force,
            change_N=bolt.force - before.force,
            load_factor=(bolt.force - before.force) / share if enough else None,
        )
        for bolt, before in zip(state.bolts, assembled.bolts, strict=True)
    )
