"""The fields that a report shows, with the bands of their legends: those of the pictures."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fea.output.pictures.bands import Bands
from fea.output.pictures.shown import VON_MISES, Field, available, field_of
from fea.output.report.reported import Array

_MIDDLE = Field("principal_2", "middle principal stress, MPa", " MPa", signed=True)
# In the order in which a load case offers them.
CASE_FIELDS = (
    VON_MISES, "principal_1", "principal_2", "principal_3", "displacement", "safety_factor",
    "contact_pressure",
)  # fmt: skip
# Of an instant of the cycle: what follows from its stress and displacement.
INSTANT_FIELDS = CASE_FIELDS[:-1]


def field_named(name: str) -> Field:
    """Return a field by the name of its array."""
    return _MIDDLE if name == _MIDDLE.name else field_of(name)


def case_fields(data: Mapping[str, Array], peak: float) -> list[dict[str, Any]]:
    """Return the fields of a load case; the legend of the von Mises stress ends at the `peak` that counts."""
    names = [name for name in CASE_FIELDS if name in data]
    return [_described(name, data, {VON_MISES: peak}) for name in names]


def envelope_fields(data: Mapping[str, Array], peak: float) -> list[dict[str, Any]]:
    """Return the fields of the whole cycle."""
    return [_described(name, data, {VON_MISES: peak}) for name in available(list(data))]


def instant_fields(peak: float, extremes: Mapping[str, Array], displaced: float) -> list[dict[str, Any]]:
    """Return the fields of every instant: one legend for the whole cycle.

    Parameters
    ----------
    peak
        Largest von Mises stress that counts, MPa.
    extremes
        The arrays of the envelope.
    displaced
        Largest displacement of the cycle, mm.
    """
    low, high = float(extremes["principal_3"].min()), float(extremes["principal_1"].max())
    ends = {
        VON_MISES: np.array([0.0, peak]),
        **dict.fromkeys(("principal_1", "principal_2", "principal_3"), np.array([low, high])),
        "displacement": np.array([0.0, displaced]),
        "safety_factor": extremes["safety_factor"],
    }
    return [_described(name, ends, {VON_MISES: peak}) for name in INSTANT_FIELDS]


def _described(name: str, data: Mapping[str, Array], known: Mapping[str, float]) -> dict[str, Any]:
    field = field_named(name)
    values = np.asarray(field.values(data), float)
    finite = values[np.isfinite(values)]
    worst = known.get(name, float(finite.min() if field.low else finite.max()) if finite.size else 0.0)
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
        "limits": [float(f"{limit:.6g}") for limit in bands.limits],
        "colours": ["#" + bytes(colour).hex() for colour in bands.colours],
        "above": bool(finite.size and finite.max() > bands.limits[-1] * (1 + 1e-9)),
    }
