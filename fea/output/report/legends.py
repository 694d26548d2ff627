"""The fields that a report shows, with the bands of their legends: those of the pictures."""

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from fea.analysis.result import Array
from fea.output.pictures.scale import Bands
from fea.output.pictures.shown import VON_MISES, Field, field_of
from fea.output.stored_run import Run
from fea.output.terminal.run_lines import factor, number, place
from fea.output.units import in_text

_MIDDLE = Field("principal_2", "middle principal stress, MPa", " MPa", signed=True)
# In the order in which a load case offers them.
CASE_FIELDS = (
    VON_MISES, "principal_1", "principal_2", "principal_3", "displacement", "safety_factor",
    "contact_pressure",
)  # fmt: skip
# Of an instant of the cycle: what follows from its stress and displacement.
INSTANT_FIELDS = CASE_FIELDS[:-1]


def fields_of(names: Iterable[str], data: Mapping[str, Array], peak: float) -> list[dict[str, Any]]:
    """Return those fields that a result has; the legend of the von Mises stress ends at the `peak`."""
    return [_described(name, data, {VON_MISES: peak}) for name in names if name in data]


case_fields = partial(fields_of, CASE_FIELDS)


def instant_fields(peak: float, extremes: Mapping[str, Array], displaced: float) -> list[dict[str, Any]]:
    """Return the fields of every instant: one legend for the whole cycle.

    It ends at the largest von Mises stress that counts, MPa, at the extremes in the arrays of the envelope,
    and at the largest displacement, mm.
    """
    low, high = float(extremes["principal_3"].min()), float(extremes["principal_1"].max())
    ends = {
        VON_MISES: np.array([0.0, peak]),
        **dict.fromkeys(("principal_1", "principal_2", "principal_3"), np.array([low, high])),
        "displacement": np.array([0.0, displaced]),
        "safety_factor": extremes["safety_factor"],
    }
    return fields_of(INSTANT_FIELDS, ends, peak)


def _described(name: str, data: Mapping[str, Array], known: Mapping[str, float]) -> dict[str, Any]:
    field = (_MIDDLE if name == _MIDDLE.name else field_of(name)).in_units()
    values = np.asarray(field.values(data), float)
    finite = values[np.isfinite(values)]
    largest = float(finite.min() if field.low else finite.max()) if finite.size else 0.0
    worst = field.scale * known[name] if name in known else largest
    if field.signed:
        bands = Bands.around_zero(float(finite.min()), float(finite.max()))
    else:
        bands = Bands.up_to(field.top(worst), low=field.low)
    label, _, unit = field.label.partition(", ")
    return {
        "name": name,
        "label": label,
        "unit": unit,
        "low": field.low and not field.signed,
        "factor": field.scale,
        "limits": [float(f"{limit / field.scale:.6g}") for limit in bands.limits],
        "labels": [f"{limit:.6g}" for limit in bands.limits],
        "colours": ["#" + bytes(colour).hex() for colour in bands.colours],
        "above": bool(finite.size and finite.max() > bands.limits[-1] * (1 + 1e-9)),
    }


def hot_spots(run: Run) -> list[dict[str, Any]]:
    """Return the worst place of every load case, its sharp edges, and the worst places of the cycle."""
    found = []
    for name, case in run.summary.results.items():
        if name not in run.fields:
            continue
        text = f"{number(case.max_von_mises_MPa, '.0f')} MPa, safety factor {factor(case.min_safety_factor)}"
        found.append(_spot(name.capitalize(), text, case.at_mm, name, "von_mises"))
        for edge in case.sharp_edges or ():
            stress = f"structural stress {number(edge.structural_von_mises_MPa, '.0f')} MPa"
            found.append(
                _spot(f"{name.capitalize()}, sharp edge {edge.name}", stress, edge.at_mm, name, "von_mises")
            )
    return found + _of_cycle(run)


def _of_cycle(run: Run) -> list[dict[str, Any]]:
    cycle = run.summary.cycle
    if cycle is None or run.envelope is None:
        return []
    result = "envelope" if run.motion is None else "cycle"
    spots = [
        _spot(f"Cycle, place {chr(ord('A') + k)}", text, spot.at_mm, result, "von_mises")
        | {"angle": spot.crank_deg}
        for k, spot in enumerate(cycle.spots)
        for text in [f"up to {spot.max_von_mises_MPa:.0f} MPa at {number(spot.crank_deg, '.0f')}°"]
    ]
    weakest = cycle.fatigue
    if weakest is not None:
        text = f"fatigue factor {factor(weakest.fatigue_safety_factor)}"
        spots.append(_spot("Weakest in fatigue", text, weakest.at_mm, "envelope", "fatigue_safety_factor"))
    return spots


def _spot(title: str, text: str, at: tuple[float, float, float], result: str, field: str) -> dict[str, Any]:
    where = in_text(f"x, y, z = {place(at)} mm")
    return {
        "title": title,
        "text": in_text(text),
        "place": where,
        "at": list(at),
        "result": result,
        "field": field,
    }
