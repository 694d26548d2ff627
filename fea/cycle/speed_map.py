"""Safety factors of the cycle against engine speed, and the speeds at which they fall below 1."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

COLUMNS = (
    "rpm",
    "yield_safety_factor",
    "yield_crank_deg",
    "yield_x_mm",
    "yield_y_mm",
    "yield_z_mm",
    "fatigue_safety_factor",
    "fatigue_x_mm",
    "fatigue_y_mm",
    "fatigue_z_mm",
    "mean_MPa",
    "amplitude_MPa",
    "stress_ratio",
    "crossland_safety_factor",
)
MODES = {
    "yield": "yield_safety_factor",
    "fatigue": "fatigue_safety_factor",
    "crossland": "crossland_safety_factor",
}


@dataclass(frozen=True)
class SpeedMap:
    """The worst of the cycle at several speeds.

    Attributes
    ----------
    columns
        (n_speeds,) by the names of `COLUMNS`, speeds increasing; NaN where fatigue is not judged. Crossland's
        factor is the least of the whole rod at speeds that were run in full, at others that of the worst
        places against yielding and fatigue.
    exact
        Critical speeds that are known better than by interpolation.
    """

    columns: dict[str, Floats]
    exact: Mapping[str, float | None] | None = None

    @property
    def critical(self) -> Mapping[str, float | None]:
        """Speed, rpm, at which each failure mode begins; None where it does not within the map."""
        if self.exact is not None:
            return self.exact
        return {
            mode: critical_speed(self.columns["rpm"], self.columns[column]) for mode, column in MODES.items()
        }


def critical_speed(rpm: Floats, factor: Floats) -> float | None:
    """Lowest speed from which a safety factor is below 1, linear between speeds.

    Parameters
    ----------
    rpm
        (n,) increasing.
    factor
        (n,); NaN where it is not known.

    Returns
    -------
    float or None
        The lowest speed of all where the factor is below 1 already there.
    """
    first = first_below(factor)
    if first is None:
        return None
    if first == 0 or np.isnan(factor[first - 1]):
        return float(rpm[first])
    share = (factor[first - 1] - 1) / (factor[first - 1] - factor[first])
    return float(rpm[first - 1] + share * (rpm[first] - rpm[first - 1]))


def first_below(factor: Floats) -> int | None:
    """Number of the first factor below 1; None where there is none."""
    below = np.flatnonzero(factor < 1)
    return int(below[0]) if below.size else None


def speed_map(summaries: Sequence[Mapping[str, Any]]) -> SpeedMap | None:
    """Gather the envelopes of the summaries of several speeds; None where no cycle was worked out."""
    rows = [_row(item) for item in summaries if "envelope" in item and item["rpm"] is not None]
    if not rows:
        return None
    values = np.array(sorted(rows), dtype=np.float64)
    exact = next((item["critical_speeds_rpm"] for item in summaries if "critical_speeds_rpm" in item), None)
    return SpeedMap(dict(zip(COLUMNS, values.T, strict=True)), exact)


def _row(summary: Mapping[str, Any]) -> list[float]:
    envelope = summary["envelope"]
    fatigue = envelope["fatigue"] or {}
    multiaxial = envelope.get("min_crossland_safety_factor")
    found = {
        "rpm": summary["rpm"],
        "yield_safety_factor": envelope["min_safety_factor"],
        "yield_crank_deg": envelope["crank_deg"],
        **_place("yield", envelope["at_mm"]),
        **_place("fatigue", fatigue.get("at_mm", [np.nan] * 3)),
        **fatigue,
        "crossland_safety_factor": multiaxial,
    }
    return [np.nan if found.get(name) is None else float(found[name]) for name in COLUMNS]


def _place(mode: str, at: Sequence[float]) -> dict[str, float]:
    return {f"{mode}_{axis}_mm": value for axis, value in zip("xyz", at, strict=True)}
