"""What a run says of bolts, joint and fits, in lines."""

from collections.abc import Iterator

from fea.analysis.figures import AssemblyFigures, BoltsFigures, OnsetFigures
from fea.base.units import KN
from fea.output.terminal.run_lines import factor, number
from loads.cases import ASSEMBLY

MICRO_SLIP = (
    "Micro-slip: where friction is at its limit and the faces shift by micrometres. The parts stay in place "
    "as long as the slip safety, friction's limit over the shear force of the whole joint, is above 1."
)


def assembly_lines(found: AssemblyFigures) -> Iterator[str]:
    """Yield how the bolts stand, and when the joint opens and the fits lift off."""
    yield _bolts(found.bolts)
    yield from _joint(found)
    for name, fit in found.fits.items():
        if fit.lifts_off is not None:
            verb = "lift" if name.endswith("s") else "lifts"
            yield f"{name.capitalize()}: {verb} off the seat {_when(fit.lifts_off)}."
    for bore, cases in found.ovality.items():
        assembled = cases[ASSEMBLY].ovality_mm
        worst = max(cases, key=lambda case: cases[case].ovality_mm)
        most = cases[worst].ovality_mm
        warm = f", {1e3 * assembled:.0f} µm when warm" if 1e3 * assembled >= 1 else ""
        yield f"Ovality, {bore.replace('_', ' ')}: {1e3 * most:.0f} µm ({worst}), round as made{warm}."
    yield MICRO_SLIP


def _bolts(bolts: BoltsFigures) -> str:
    where = bolts.max_case or f"{number(bolts.max_crank_deg, '.0f')}°"
    force = f"at most {bolts.max_force_N / KN:.1f} kN ({where})"
    hardest = max((one for case in bolts.by_case.values() for one in case), key=lambda one: one.force_N)
    carried = "" if hardest.load_factor is None else f", load factor Φ {hardest.load_factor:.2g}"
    fatigue = bolts.bending_fatigue_safety_factor
    against = "" if fatigue is None else f", {factor(fatigue)} against fatigue with bending"
    return (
        f"Bolts, {bolts.thread}: {force}{carried} (VDI 2230: {bolts.vdi_load_factor:.2g}), amplitude "
        f"{bolts.amplitude_N / KN:.2g} kN, bending {bolts.max_bending_MPa:.0f} MPa; safety factor "
        f"{factor(bolts.yield_safety_factor)} against yielding"
        f"{against}."
    )


def _joint(found: AssemblyFigures) -> Iterator[str]:
    joint = found.joint
    said = []
    if joint.opens is not None:
        said.append(f"opens at the bore {_when(joint.opens)}")
    if joint.separates is not None:
        said.append(f"comes apart {_when(joint.separates)}")
    if said:
        yield f"Joint: {'; '.join(said)}."
    if joint.cycle is not None:
        own = joint.cycle
        yield (
            f"Joint over the cycle: clamped by at least {own.min_clamp_force_N / KN:.1f} kN "
            f"({own.min_clamp_crank_deg:.0f}°), gap at most {own.max_opening_um:.0f} µm "
            f"({own.max_opening_crank_deg:.0f}°), open at the bore in {own.open_percent:.0f} % of it."
        )


def _when(onset: OnsetFigures) -> str:
    if onset.load_factor is None:
        return f"beyond {onset.largest_factor:g} times the load of {onset.case}"
    if onset.load_factor == 0:
        return "without any load"
    return f"at {onset.load_factor:.2g} times the load of {onset.case}"
