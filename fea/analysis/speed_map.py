"""Safety factors of the cycle against engine speed, and the speeds at which they fall below 1."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrays import Floats

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
    "column_safety_factor",
    "buckling_factor",
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
        places against yielding and fatigue. Of buckling the least of every case.
    critical
        Lowest speed, rpm, from which each of `MODES` fails; None where it does not within the map.
    """

    columns: dict[str, Floats]
    critical: Mapping[str, float | None]


def rounded(rpm: float) -> str:
    """A critical speed in the three digits that stresses of a few per cent can vouch for."""
    return f"{float(f'{rpm:.3g}'):.0f}"


def first_below(factor: Floats) -> int | None:
    """Number of the first factor below 1; None where there is none."""
    below = np.flatnonzero(factor < 1)
    return int(below[0]) if below.size else None


def speed_map(summaries: Sequence[Mapping[str, Any]]) -> SpeedMap | None:
    """Gather the envelopes of the summaries of several speeds; None where no cycle was worked out."""
    critical = next(
        (item["critical_speeds_rpm"] for item in summaries if "critical_speeds_rpm" in item), None
    )
    if critical is None:
        return None
    values = np.array(sorted(map(_row, summaries)), dtype=np.float64)
    return SpeedMap(dict(zip(COLUMNS, values.T, strict=True)), critical)


def _row(summary: Mapping[str, Any]) -> list[float]:
    envelope = summary["envelope"]
    fatigue = envelope["fatigue"] or {}
    buckling = summary["buckling"]
    planes = [plane["safety_factor"] for plane in buckling["column"]["planes"].values()]
    modes = [mode["factor"] for found in buckling.get("modes", {}).values() for mode in found]
    found = {
        "rpm": summary["rpm"],
        "yield_safety_factor": envelope["min_safety_factor"],
        "yield_crank_deg": envelope["crank_deg"],
        **_place("yield", envelope["at_mm"]),
        **_place("fatigue", fatigue.get("at_mm", [np.nan] * 3)),
        **fatigue,
        "crossland_safety_factor": envelope["min_crossland_safety_factor"],
        "column_safety_factor": min((factor for factor in planes if factor is not None), default=None),
        "buckling_factor": min(modes, default=None),
    }
    return [np.nan if found.get(name) is None else float(found[name]) for name in COLUMNS]


def _place(mode: str, at: Sequence[float]) -> dict[str, float]:
    return {f"{mode}_{axis}_mm": value for axis, value in zip("xyz", at, strict=True)}
