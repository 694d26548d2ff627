"""Buckling on the terminal."""

from fea.analysis.figures import BucklingFigures, ColumnFigures

_SIDES = {"in_plane": "in the plane of motion", "sideways": "sideways"}


def buckling_lines(found: BucklingFigures) -> list[str]:
    """Return a line on the column formulas and one on the buckling modes, as far as there are any."""
    return [*_column(found.column), *_modes(found)]


def _column(column: ColumnFigures) -> list[str]:
    """The plane that buckles first."""
    factors = {name: plane.safety_factor for name, plane in column.planes.items()}
    known = {name: factor for name, factor in factors.items() if factor is not None}
    if column.case is None or not known:
        return []
    side = min(known, key=lambda name: known[name])
    plane, force = column.planes[side], column.force_N
    loads = {"Euler": plane.euler_N, "Johnson": plane.johnson_N, "Rankine": plane.rankine_N}
    said = ", ".join(f"{name} {load / force:.2f}" for name, load in loads.items())
    return [f"Buckling safety factors under {force / 1000:.1f} kN ({column.case}), {_SIDES[side]}: {said}."]


def _modes(found: BucklingFigures) -> list[str]:
    """The lowest factor of each case."""
    if found.modes is None:
        return []
    if not found.modes:
        return ["No load case compresses the rod, so it cannot buckle."]
    cases = [
        f"{case} {modes[0].factor:.2f} ({modes[0].moves})" for case, modes in found.modes.items() if modes
    ]
    return [f"Buckling modes of the solid, load factors: {', '.join(cases)}."] if cases else []
