"""The bolts of a cap over the load cases, judged by VDI 2230."""

from collections.abc import Mapping

from fea.analysis.assembling import Assembling
from fea.analysis.assembly_figures import BoltCaseFigures, BoltsFigures
from fea.analysis.figure_types import vector
from fea.assess.bolt_strength import alternating_stress, endurance, working_stress
from fea.rod.assembly_state import AssemblyState
from loads.cases import ASSEMBLY

# Share of the clamping force below which the load on the joint is too small for a ratio.
_LITTLE = 0.01


def bolts_figures(assembling: Assembling, states: Mapping[str, AssemblyState]) -> BoltsFigures:
    """Judge the bolts.

    Parameters
    ----------
    assembling
        The bolts of the study.
    states
        By load case; `ASSEMBLY` is one of them.
    """
    chosen, bolt = assembling.bolt, assembling.bolt.bolt
    forces = {case: [one.force for one in state.bolts] for case, state in states.items()}
    hardest = max(forces, key=lambda case: max(forces[case]))
    histories = list(zip(*forces.values(), strict=True))
    largest, least = max(((max(own), min(own)) for own in histories), key=lambda ends: ends[0] - ends[1])
    worst = max(forces[hardest])
    stress = working_stress(bolt, worst, torsion=assembling.table.bolt_stretch_mm is None)
    alternating = alternating_stress(bolt.thread.stress_area, largest, least)
    limit = endurance(bolt, (largest + least) / 2)
    return BoltsFigures(
        thread=bolt.thread.name,
        preload_N=bolt.preload,
        proof_load_N=bolt.proof_load,
        vdi_load_factor=chosen.load_factor,
        max_force_N=worst,
        max_case=hardest,
        min_force_N=min(min(own) for own in histories),
        mean_N=(largest + least) / 2,
        amplitude_N=(largest - least) / 2,
        working_stress_MPa=stress,
        yield_safety_factor=bolt.yield_strength / stress,
        alternating_stress_MPa=alternating,
        endurance_MPa=limit,
        fatigue_safety_factor=limit / alternating if alternating > 0 else None,
        by_case={case: _by_bolt(state, states[ASSEMBLY]) for case, state in states.items()},
    )


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
