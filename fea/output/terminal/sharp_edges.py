"""What a run says of sharp re-entrant edges: their structural stress, and the fillets that they need."""

from fea.analysis.figures import SharpEdgeFigures, Summary
from fea.output.terminal.figures import bar, factor, number, place

# A fillet radius, mm, that any tool leaves.
_SMALL = 0.1
UNBOUNDED = "the elastic stress right at the sharp edges below is infinite and not part of this factor"


def sharp_cells(edge: SharpEdgeFigures) -> list[str]:
    """Return the row of the worst sharp edge of a load case."""
    return [
        f"  edge {edge.name}",
        *[""] * 4,
        number(edge.structural_von_mises_MPa, ".1f"),
        bar(edge.error_percent),
        place(edge.at_mm),
        factor(edge.safety_factor),
        "",
    ]


def sharp_edge_lines(summary: Summary) -> list[str]:
    """Return a line for each sharp edge that matters, in its worst load case, and which figure decides."""
    worst: dict[str, tuple[str, SharpEdgeFigures]] = {}
    for case, result in summary.results.items():
        for edge in result.sharp_edges or ():
            if edge.name not in worst or edge.safety_factor < worst[edge.name][1].safety_factor:
                worst[edge.name] = case, edge
    lines = [_line(*worst[name]) for name in sorted(worst, key=lambda name: (len(name), name))]
    return [*lines, _decision(summary)] if lines else []


def _line(case: str, edge: SharpEdgeFigures) -> str:
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
        return "which fillet it needs cannot be said: short flanks, a narrow notch or large elements"
    if edge.fillet_radius_mm is None:
        return f"the peak has {asked} only with a fillet of more than {edge.largest_fillet_mm:.1f} mm"
    if edge.fillet_radius_mm < _SMALL:
        return f"even with a fillet of {_SMALL:g} mm the peak there would have {asked}"
    return f"with a fillet of {edge.fillet_radius_mm:.2g} mm the peak there would have {asked}"


def _decision(summary: Summary) -> str:
    """Say which of the figures to decide by."""
    cycle = " (the fatigue factors of the cycle leave these edges out)" if summary.envelope else ""
    return (
        "Which to use: against yielding under static load, the factor of the first line, the least of the "
        "peaks away from sharp edges and the structural stresses at them (extrapolated from 0.4 and 1.0 "
        "thicknesses beside the edge, IIW); against fatigue, give the edges the fillets above and run "
        f"again{cycle}."
    )
