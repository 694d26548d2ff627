"""Buckling on the terminal."""

from collections.abc import Mapping
from typing import Any

_SIDES = {"in_plane": "in the plane of motion", "sideways": "sideways"}
_FORMULAS = {"euler_N": "Euler", "johnson_N": "Johnson", "rankine_N": "Rankine"}


def buckling_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return a line on the column formulas and one on the modes, as far as a summary has them."""
    found = summary.get("buckling", {})
    return [*_column(found.get("column")), *_modes(found.get("modes"))]


def _column(column: Mapping[str, Any] | None) -> list[str]:
    """The plane that buckles first."""
    if column is None or column["case"] is None:
        return []
    planes, force = column["planes"], column["force_N"]
    side = min(planes, key=lambda name: float(planes[name]["safety_factor"]))
    factors = ", ".join(f"{name} {planes[side][key] / force:.2f}" for key, name in _FORMULAS.items())
    return [f"Buckling under {force / 1000:.1f} kN ({column['case']}), {_SIDES[side]}: factors {factors}."]


def _modes(modes: Mapping[str, Any] | None) -> list[str]:
    """The lowest factor of each case."""
    if modes is not None and not modes:
        return ["No case presses the rod: it does not buckle."]
    cases = [
        f"{case} {found[0]['factor']:.2f} ({found[0]['moves']})"
        for case, found in (modes or {}).items()
        if found
    ]
    return [f"Buckling of the elastic solid, factors on its load: {', '.join(cases)}."] if cases else []
