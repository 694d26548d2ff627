"""What terminal and report say of a run, in lines; and how they write its figures."""

import math
from collections.abc import Collection, Iterable
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from fea.analysis.figures import LoadFigures, SharpEdgeFigures, Summary
from fea.judge.safety_factor import printed
from fea.output.text import error_bar
from fea.output.units import in_heading, in_rows

SIDES = {"in_plane": "in the plane of motion", "sideways": "sideways"}


def plain_table(
    columns: Iterable[str],
    rows: Iterable[Iterable[str]],
    *,
    left: Collection[str] = (),
    no_wrap: bool = False,
    gap: int = 1,
    **options: Any,
) -> Table:
    """Return a table without vertical rules, figures to the right but for the columns on the left."""
    table, titles = Table(box=SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, **options), list(columns)
    for title in titles:
        table.add_column(in_heading(title), justify="left" if title in left else "right", no_wrap=no_wrap)
    for row in in_rows(titles, rows):
        table.add_row(*row)
    return table


UNKNOWN = "–"
# Wider or narrower than their columns.
_MANY_NEWTONS, _FAR_TOO_MANY = 999e3, 99_999e3


def number(value: float | None, form: str) -> str:
    """Return a number in a format, without a negative zero."""
    return UNKNOWN if value is None else format(value + 0.0, form)


def bar(percent: float | None) -> str:
    """Return an error bar."""
    return UNKNOWN if percent is None else error_bar(percent)


def place(coordinates: Iterable[float]) -> str:
    """Return coordinates in mm, to a tenth."""
    return ", ".join(number(coordinate, ".1f") for coordinate in coordinates)


def kilo(newtons: float | None, largest: float = _MANY_NEWTONS) -> str:
    """Return a force in kN with its sign: to three digits of the `largest` beside it, N, and a tenth at most.

    Large ones are whole, huge ones short.
    """
    if newtons is None:
        return UNKNOWN
    digits = max(1, 5 - math.floor(math.log10(largest))) if largest > 1 else 5
    form = f"+z.{digits}f" if abs(newtons) < _MANY_NEWTONS else "+.0f"
    return format(newtons / 1000, form if abs(newtons) < _FAR_TOO_MANY else "+.1e")


def largest_force(loads: Iterable[LoadFigures]) -> float:
    """Return the largest axial force at either end, N, to whose digits a table's forces are written."""
    return max(
        (abs(force) for load in loads for force in (load.pin_axial_N, load.crank_axial_N)), default=0.0
    )


def factor(value: float | None) -> str:
    """Return a safety factor: two places, or two digits where it is so small that those would be zeros."""
    return printed(value)


def film_lines(summary: Summary) -> list[str]:
    """Return a line per bearing whose oil film was computed."""
    return [
        f"Oil film, {end.replace('_', ' ')}: {film.verdict}, min. {film.h_min_um:.2f} µm "
        f"± {bar(film.h_min_error_percent)} % at {film.h_min_deg:.0f}°"
        f"{'' if film.lambda_min is None else f' ({film.lambda_min:.1f} × roughness)'}, max. "
        f"{film.p_max_MPa:.0f} MPa ± {bar(film.p_max_error_percent)} % at {film.p_max_deg:.0f}°; friction "
        f"{film.power_W:.0f} W ± {bar(film.power_error_percent)} %, oil {film.flow_l_min:.2g} l/min "
        f"± {bar(film.flow_error_percent)} %"
        f"{'' if film.temperature_C is None else f' at {film.temperature_C:.0f} °C'}."
        f"{'' if film.asperity_percent < 1 else f' Asperities carry up to {film.asperity_percent:.0f} %.'}"
        f"{'' if film.lining_factor is None else f' Lining: factor {factor(film.lining_factor)}.'}"
        for end, film in (summary.film or {}).items()
    ]


def hours_text(hours: float | None) -> str:
    """Return hours with three digits, or that they are unlimited."""
    return "unlimited" if hours is None else f"{number(hours, '.3g')} h"


# A fillet radius, mm, that any tool leaves.
_SMALL = 0.1


def sharp_edge_lines(summary: Summary) -> list[str]:
    """Return a line for each sharp edge that matters, in its worst load case, and which figure decides."""
    worst: dict[str, tuple[str, SharpEdgeFigures]] = {}
    for case, result in summary.results.items():
        for edge in result.sharp_edges or ():
            if edge.name not in worst or edge.safety_factor < worst[edge.name][1].safety_factor:
                worst[edge.name] = case, edge
    lines = [_edge_line(*worst[name]) for name in sorted(worst, key=lambda name: (len(name), name))]
    cycle = " (the fatigue factors of the cycle leave these edges out)" if summary.envelope else ""
    decision = (
        "Which to use: against yielding under static load, the factor of the first line, the least of the "
        "peaks away from sharp edges and the structural stresses at them (extrapolated from 0.4 and 1.0 "
        "thicknesses beside the edge, IIW), where the elastic stress is infinite; against fatigue, give the "
        f"edges the fillets above and run again{cycle}."
    )
    return [*lines, decision] if lines else []


def _edge_line(case: str, edge: SharpEdgeFigures) -> str:
    one, other = edge.between
    stress = f"{edge.structural_von_mises_MPa:.0f} MPa ± {bar(edge.error_percent)} %"
    return (
        f"Sharp edge {edge.name} at ({place(edge.at_mm)}) mm, between {one} and {other} "
        f"({edge.opening_deg:.0f}° open, {edge.length_mm:.0f} mm long): structural stress {stress} in "
        f"{case}, safety factor {factor(edge.safety_factor)}; {fillet(edge)}."
    )


def fillet(edge: SharpEdgeFigures) -> str:
    """Say which fillet the edge needs."""
    asked = f"a factor of {edge.required_safety_factor:g}"
    if edge.safety_factor < edge.required_safety_factor:
        return f"no fillet gives {asked}, the section itself is too weak"
    if edge.largest_fillet_mm is None:
        return "the fillet it needs could not be determined: short flanks, a narrow notch or large elements"
    if edge.fillet_radius_mm is None:
        return f"the peak has {asked} only with a fillet of more than {edge.largest_fillet_mm:.1f} mm"
    if edge.fillet_radius_mm < _SMALL:
        return f"even with a fillet of {_SMALL:g} mm the peak there would have {asked}"
    least = f"a fillet of {edge.fillet_radius_mm:.2g} mm is the least with which the peak there has {asked}"
    return f"{least} against yielding (no recommendation: fatigue needs more)"
