"""One rod at all its speeds: one mesh, one factorisation, and the figures of the table."""

from fea.analysis.many_speeds import SpeedSweep
from fea.analysis.modes import modes_report
from fea.analysis.pipeline import RefinedRod, refined_rod
from fea.analysis.result import run_result
from fea.analysis.summary_figures import Summary
from fea.analysis.survival import factors
from fea.apps.limits.explore import explore, limited_speeds
from fea.apps.limits.figures import largest_values
from fea.apps.sweep.sweep_file import SweepOutputs
from fea.machine.clock import Clock
from fea.output.json_file import JsonObject
from fea.study.study import Study


def evaluate(study: Study, outputs: SweepOutputs) -> dict[float | None, JsonObject]:
    """Return the figures of a rod by speed, rpm (None: given forces). Errors as `fea.apps.result.analyse`."""
    speeds = study.speeds()
    adapted = refined_rod(study, speeds, Clock())
    shared: JsonObject = {}
    rpm = [speed for speed in speeds if speed is not None]
    if study.analysis.cycle and len(rpm) != 1:
        # Lowest speed from which each factor of the cycle is below 1, if it is within the speeds.
        critical = SpeedSweep(adapted.rod, rpm).critical
        shared = {f"critical_{name}_rpm": speed for name, speed in critical.items() if speed is not None}
    if outputs.limits:
        shared |= _limits(adapted)
    if outputs.frequencies:
        modes = modes_report(study, outputs.frequencies, adapted.rod.mesh)
        shared |= {f"frequency_{number}_Hz": float(hertz) for number, hertz in enumerate(modes.elastic, 1)}
        shared |= {} if modes.trusted else {"trusted": False}
    return {
        speed: figures(run_result(study, adapted, adapted.at(speed)).summary) | shared for speed in speeds
    }


def figures(summary: Summary) -> JsonObject:
    """Return the figures of a run that a table has room for."""
    # First yield stays a column of its own where it is followed by flow, which `factor` and `mode` have.
    of_run = summary.results, summary.buckling, summary.envelope, summary.assembly
    all_factors = factors(*of_run, overload=summary.overload, defect=summary.defect)
    table: JsonObject = {
        "mass_kg": summary.rod.mass_kg,
        "center_of_gravity_mm": summary.rod.center_of_gravity_mm[0],
        "inertia_kg_m2": summary.rod.inertia_kg_m2,
        "factor": float(summary.survival.safety_factor),
        "assured_factor": summary.survival.assured_safety_factor,
        "mode": summary.survival.mode,
        "case": summary.survival.case,
        "answer": summary.survival.answer,
        "fatigue_at_most": summary.survival.fatigue_at_most,
    }
    for mode in dict.fromkeys(factor.mode for factor in all_factors):
        least = min((each for each in all_factors if each.mode == mode), key=lambda each: each.low)
        key = mode.replace(" ", "_")
        table |= {f"{key}_factor": float(least), f"{key}_error_percent": least.percent}
    for name, case in summary.results.items():
        table[f"{name}_factor"] = case.min_safety_factor
        table[f"{name}_error_percent"] = case.error_percent
        table[f"{name}_von_mises_MPa"] = case.max_von_mises_MPa
    if summary.envelope is not None:
        table["cycle_factor"] = summary.envelope.min_safety_factor
        table["crossland_factor"] = summary.envelope.min_crossland_safety_factor
    if summary.life is not None:
        low, high = summary.life.band_hours
        table |= {"life_hours": summary.life.hours, "life_low_hours": low, "life_high_hours": high}
        table["life_endless"] = summary.life.endless
    table |= {"trusted": summary.trusted, "elements": summary.model.elements}
    return {name: value for name, value in table.items() if value is not None}


def _limits(adapted: RefinedRod) -> JsonObject:
    limits = explore(adapted, limited_speeds(adapted.rod.study)[-1], mapped=False)
    speed, pressure, _ = largest_values(limits)
    table: JsonObject = {}
    if speed is not None:
        bar = 0.0 if speed.bar is None else speed.bar
        table = {"limit_rpm": speed.value, "limit_rpm_error_percent": 100 * bar / speed.value}
        table["limit_mode"] = speed.mode
    if pressure is not None and pressure.rpm >= limits.at_rpm:
        table |= {"limit_peak_pressure_bar": pressure.value, "limit_pressure_mode": pressure.mode}
    return table
