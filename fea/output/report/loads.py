"""The loads on the bores as a drawing needs them: arcs of pressure, and forces over the cycle."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fea.analysis.figures import BoreFigures
from fea.analysis.result import BORES, Arrays, Run
from fea.study.pin_models import pin_model
from geometry.arrays import Floats
from loads.bearing import Arc, BorePressure


def pressure_kind(name: str) -> dict[str, Any]:
    """Return what a pin does to its bore, from the pressure's name in the study."""
    load = pin_model(name).parse(name)
    if not isinstance(load, BorePressure):
        return {"kind": name}
    return {"kind": "arc", "tension": _arc(load.tension), "compression": _arc(load.compression)}


def _arc(arc: Arc) -> dict[str, Any]:
    return {"shape": arc.shape.value, "deg": round(float(np.degrees(arc.angle)), 6)}


def bore_loads(contact: Mapping[str, BoreFigures] | None) -> list[list[float]] | None:
    """Return place, °, arc, °, and largest pressure, MPa, of the contact on the big and the small end."""
    if contact is None:
        return None
    found = (contact.get(surface.value) for surface in BORES)
    return [[one.at_deg, one.arc_deg, one.max_pressure_MPa] if one else [0.0, 0.0, 0.0] for one in found]


def cycle_loads(run: Run) -> dict[str, Any]:
    """Return forces [x, y] on the rod at the big and the small end at every degree, N, and contact if any."""
    if run.forces is None:
        return {}
    columns = {name: np.asarray(values, float) for name, values in run.forces.items()}
    found: dict[str, Any] = {
        "forces": [
            [_whole(-columns["crank_axial_N"]), _whole(columns["crank_transverse_N"])],
            [_whole(columns["pin_axial_N"]), _whole(columns["pin_transverse_N"])],
        ]
    }
    if run.contact is not None:
        found["touch"] = [_touch(run.contact, end) for end in ("big_end", "small_end")]
    return found


def _touch(columns: Arrays, end: str) -> list[list[float]]:
    return [
        [round(float(value), 2) for value in np.nan_to_num(np.asarray(columns[f"{end}_{name}"], float))]
        for name in ("at_deg", "arc_deg", "pressure_MPa")
    ]


def _whole(values: Floats) -> list[int]:
    return [int(value) for value in np.rint(values)]
