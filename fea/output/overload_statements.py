"""Permanent set, bending of the shank and a single overload, in sentences."""

from collections.abc import Iterator, Mapping

from fea.analysis.overload_figures import BendingFigures, OverloadFigures, SetFigures
from fea.analysis.summary_figures import Summary
from fea.analysis.survival import SET_WORDS
from fea.base.units import KN
from fea.output.units import factor, number, quantity

_PLANES = {"in_plane": "in the plane of motion", "sideways": "sideways"}
_KINDS = {"knock": "Knock of {}", "liquid": "Liquid compressed to {}", "force": "Overload"}


def permanent_set(left: Mapping[str, float], judged: SetFigures | None) -> str:
    """Return what is left without load, and what of it exceeds its limit."""
    longer = left["length"]
    parts = [
        f"{quantity(abs(longer), '.2g', 'µm')} {'longer' if longer > 0 else 'shorter'} between the bores"
    ]
    parts += [
        f"{what} by {quantity(left[name], '.2g', 'µm')}"
        for name, what in _DEPARTS.items()
        if left[name] >= _LEAST
    ]
    if left["twist_deg"] >= _LEAST_TWIST:
        parts.append(f"twisted by {number(left['twist_deg'], '.2g')}°")
    return f"{', '.join(parts)}{_limits(judged)}"


# What of a set is worth a word, µm and degrees, and in which words.
_LEAST, _LEAST_TWIST = 0.1, 1e-3
_DEPARTS = {
    "bow": "the shank bowed",
    "bend": "the bores' axes out of parallel over 100 mm",
    "big_end": "the big end's bore out of round",
    "small_end": "the small end's",
}


def _limits(judged: SetFigures | None) -> str:
    if judged is None:
        return ""
    if not judged.exceeded:
        return ", within the limits"
    beyond = (f"{SET_WORDS[name]} ({_limit(name, judged.limits[name])})" for name in judged.exceeded)
    return f"; beyond the limit: {', '.join(beyond)}"


def _limit(name: str, value: float) -> str:
    return f"{number(value, '.3g')}°" if name == "twist_deg" else quantity(value, ".3g", "µm")


def bends(found: BendingFigures, what: str) -> str:
    """Return when the shank bends under loads, in words."""
    return (
        f"With a bow of {quantity(found.bow_mm, '.2g', 'mm')} and a strength of "
        f"{quantity(found.strength_MPa, '.0f', 'MPa')}, the shank bends {_PLANES[found.plane]} at "
        f"{quantity(found.limit_N / KN, '.1f', 'kN')}, {number(found.limit_N / found.force_N, '.2f')} times "
        f"{what}; its first fibre yields at {quantity(found.first_yield_N / KN, '.1f', 'kN')}."
    )


def overload(summary: Summary) -> Iterator[str]:
    """Yield what a single overload leaves."""
    if (found := summary.overload) is None:
        return
    pressure = "" if found.pressure_bar is None else quantity(found.pressure_bar, ".0f", "bar")
    force = quantity(found.bending.force_N / KN, ".1f", "kN")
    bent = quantity(found.bending.limit_N / KN, ".1f", "kN")
    yield f"{_KINDS[found.kind].format(pressure)}, {force} on the rod: {_leaves(found, bent)}."


def _leaves(found: OverloadFigures, bent: str) -> str:
    """Return what it does in words; `bent`: the force at which the shank bends."""
    carries = f"the shank bends at {bent}, factor {factor(found.safety_factor)}"
    if found.state == "collapses":
        return "the rod collapses elsewhere than in its shank"
    if found.state == "bends":
        plane = _PLANES[found.bending.plane]
        ends = (
            "nothing ends that before its bow is a tenth of its length"
            if found.set_um is None
            else permanent_set(found.set_um, found.set_judged)
        )
        return f"it bends {plane}, as it carries {bent}; {ends}"
    if found.state == "elastic" or found.set_um is None:
        return f"it stays elastic; {carries}"
    elements = "1 element" if found.elements == 1 else f"{found.elements} elements"
    strain = number(100 * found.max_plastic_strain, ".2g")
    return (
        f"it flows in {elements} by up to {strain} % ({found.where}) and stays "
        f"{permanent_set(found.set_um, found.set_judged)}; {carries}"
    )


def overload_in_full(summary: Summary) -> Iterator[str]:
    """Yield what a single overload leaves, with the loads on the bores."""
    yield from overload(summary)
    if (found := summary.overload) is None:
        return
    yield bends(found.bending, "the overload")
    big, small = (quantity(found.specific_load_MPa[end], ".0f", "MPa") for end in ("big_end", "small_end"))
    yield (
        f"Under the overload the bores bear {big} (big end) and {small} (small end) over diameter and width. "
        "Bolts and joint, which it relieves, crank, pins and oil films are not checked for it."
    )
