"""The hot spots: places to fly to, with what is shown there."""

from typing import Any

from fea.analysis.cycle_figures import SpotFigures
from fea.output.report.reported import Reported
from fea.output.terminal.figures import factor, number, place


def hot_spots(run: Reported) -> list[dict[str, Any]]:
    """Return the worst place of every load case, its sharp edges, and the worst places of the cycle."""
    found = []
    for name, case in run.summary.results.items():
        if name not in run.cases:
            continue
        text = f"{number(case.max_von_mises_MPa, '.0f')} MPa, safety factor {factor(case.min_safety_factor)}"
        found.append(_spot(name.capitalize(), text, case.at_mm, name, "von_mises"))
        for edge in case.sharp_edges or ():
            stress = f"structural stress {number(edge.structural_von_mises_MPa, '.0f')} MPa"
            found.append(
                _spot(f"{name.capitalize()}, sharp edge {edge.name}", stress, edge.at_mm, name, "von_mises")
            )
    return found + _of_cycle(run)


def _of_cycle(run: Reported) -> list[dict[str, Any]]:
    if run.cycle is None or run.envelope is None:
        return []
    result = "envelope" if run.motion is None else "cycle"
    spots = [
        _spot(f"Cycle, place {chr(ord('A') + k)}", _said(spot), spot.at_mm, result, "von_mises")
        | {"angle": spot.crank_deg}
        for k, spot in enumerate(run.cycle.spots)
    ]
    weakest = run.cycle.fatigue
    if weakest is not None:
        text = f"fatigue factor {factor(weakest.fatigue_safety_factor)}"
        spots.append(_spot("Weakest in fatigue", text, weakest.at_mm, "envelope", "fatigue_safety_factor"))
    return spots


def _said(spot: SpotFigures) -> str:
    return f"up to {number(spot.max_von_mises_MPa, '.0f')} MPa at {number(spot.crank_deg, '.0f')}°"


def _spot(title: str, text: str, at: tuple[float, float, float], result: str, field: str) -> dict[str, Any]:
    where = f"x, y, z = {place(at)} mm"
    return {"title": title, "text": text, "place": where, "at": list(at), "result": result, "field": field}
