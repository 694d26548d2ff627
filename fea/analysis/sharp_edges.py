"""The sharp edges of a rod that matter, as figures."""

from collections.abc import Mapping
from string import ascii_uppercase

from fea.analysis.figure_types import vector
from fea.analysis.figures import SharpEdgeFigures
from fea.assess.case_result import CaseResult
from fea.assess.sharp_place import SharpPlace, worst_of_edges
from fea.units import DEG


def sharp_edge_figures(
    cases: Mapping[str, CaseResult], required: float | None
) -> dict[str, tuple[SharpEdgeFigures, ...]]:
    """Return the edges that matter in each load case, the worst first; one edge has one name in all cases.

    Parameters
    ----------
    cases
        By name.
    required
        The safety factor that is asked for; 1 by default.
    """
    kept = {name: case.sharp_mattering for name, case in cases.items()}
    names = {place.between: _letter(k) for k, place in enumerate(worst_of_edges(kept.values()))}
    least = 1.0 if required is None else required
    return {
        name: tuple(_figures(place, names[place.between], least) for place in places)
        for name, places in kept.items()
    }


def _letter(number: int) -> str:
    """Name the edges A, B, …, Z, A1, B1 and so on."""
    turn, place = divmod(number, len(ascii_uppercase))
    return ascii_uppercase[place] + (str(turn) if turn else "")


def _figures(place: SharpPlace, name: str, required: float) -> SharpEdgeFigures:
    notch = place.notch
    return SharpEdgeFigures(
        name=name,
        at_mm=vector(place.at),
        between=place.between,
        opening_deg=place.opening / DEG,
        length_mm=place.length,
        thickness_mm=place.thickness,
        structural_stress_MPa=place.stress,
        structural_von_mises_MPa=place.von_mises,
        error_percent=place.error_percent,
        safety_factor=place.safety_factor,
        notch_intensity=None if notch is None else notch.intensity,
        notch_exponent=place.exponent,
        required_safety_factor=required,
        fillet_radius_mm=place.fillet(required),
        largest_fillet_mm=None if notch is None else notch.longest,
    )
