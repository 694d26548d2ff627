"""What a rod keeps beyond yield: flow, permanent set, bending and a single overload, in sentences."""

from collections.abc import Iterator, Mapping

from fea.analysis.overload_figures import BendingFigures, SetFigures
from fea.analysis.summary_figures import Summary
from fea.analysis.survival import SET_WORDS
from fea.base.units import KN, UM
from fea.output.units import factor, number, quantity

# What flow that does not end does.
_FOLLOWS = {
    "cyclic": "to and fro in every turn",
    "undecided": "without settling",
    "ratchets": "further in every turn",
    "collapses": "until no equilibrium is left",
}


def flow(summary: Summary) -> Iterator[str]:
    """Yield what yielding leads to."""
    if (found := summary.plastic) is None:
        return
    elements = "1 element" if found.elements == 1 else f"{found.elements} elements"
    turns = "once" if found.turns == 1 else f"in {found.turns} turns"
    lasts = _FOLLOWS.get(found.state)
    yield (
        f"Flows {'' if lasts else f'{turns} '}in {elements} by up to "
        f"{number(100 * found.max_plastic_strain, '.2g')} % ({found.where}), "
        f"{lasts or f'elastic from turn {found.turns + 1} on'}."
    )
    if (cyclic := found.cyclic) is not None:
        after, law = "", ", by assumed constants" if cyclic.assumed else ""
        if cyclic.turns is not None:
            minutes = (
                "" if cyclic.minutes is None else f" ({number(cyclic.minutes, '.1g')} min at this speed)"
            )
            after = f": it cracks after about {number(cyclic.turns, '.1g')} turns{minutes}{law}"
        yield f"Strain there varies by {number(100 * cyclic.strain_range, '.2g')} % in every turn{after}."
    if (tired := found.fatigue) is not None:
        before, after = (quantity(mean, ".0f", "MPa") for mean in (tired.elastic_mean_MPa, tired.mean_MPa))
        yield (
            f"Fatigue after shakedown: factor {factor(tired.safety_factor)} (elastic "
            f"{factor(tired.elastic_safety_factor)}), {tired.where}, mean {before} before and {after} "
            "after (no peening where it flowed)."
        )


def flow_in_full(summary: Summary) -> Iterator[str]:
    """Yield what yielding leads to, with what is left of it."""
    yield from flow(summary)
    if (found := summary.plastic) is None or found.state == "collapses":
        return
    left = quantity(found.residual_MPa, "+.0f", "MPa")
    yield (
        f"Without load a stress of {left} is left there, and the rod is "
        f"{permanent_set(found.set_um, found.set_judged)}. It flows "
        f"under {', '.join(found.cases)}, at a strength of {quantity(found.strength_MPa, '.0f', 'MPa')}."
    )
    if found.bending is not None:
        yield bends(found.bending, f"that of {found.bending.case}")
    if found.strain_per_turn:
        yield f"In every turn {number(100 * found.strain_per_turn, '.2g')} % of plastic strain add up there."


_PLANES = {"in_plane": "in the plane of motion", "sideways": "sideways"}
_KINDS = {"knock": "Knock of {}", "liquid": "Liquid compressed to {}", "force": "Overload"}


# What of a set is worth a word, and in which.
_LEAST_UM, _LEAST_DEG = 0.1, 1e-3
_DEPARTS = {
    "bow": "the shank bowed",
    "bend": "the bores' axes out of parallel over 100 mm",
    "big_end": "the big end's bore out of round",
    "small_end": "the small end's",
}


def permanent_set(left: Mapping[str, float], judged: SetFigures | None) -> str:
    """Return what is left without load, and what of it exceeds its limit."""
    sign = "longer" if left["length"] > 0 else "shorter"
    length = f"{_um(abs(left['length']))} {sign}" if abs(left["length"]) >= _LEAST_UM else "as long as it was"
    parts = [f"{length} between the bores"]
    counted = {name: what for name, what in _DEPARTS.items() if left[name] >= _LEAST_UM}
    parts += [f"{what} by {_um(left[name])}" for name, what in counted.items()]
    parts += [f"twisted by {number(left['twist_deg'], '.2g')}°"] if left["twist_deg"] >= _LEAST_DEG else []
    if judged is None:
        return ", ".join(parts)
    beyond = [f"{SET_WORDS[name]} ({set_limit(name, judged.limits[name])})" for name in judged.exceeded]
    end = f"; beyond the limit: {', '.join(beyond)}" if beyond else ", within the limits"
    return ", ".join(parts) + end


def _um(value: float) -> str:
    if value >= 1e3:
        return quantity(value * UM, ".2f", "mm")
    return quantity(value, ".2g" if value < 100 else ".0f", "µm")


def set_limit(name: str, value: float) -> str:
    """Return the limit of a permanent set, µm or degrees."""
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
    force, limit = (
        quantity(each / KN, ".1f", "kN") for each in (found.bending.force_N, found.bending.limit_N)
    )
    left = "" if found.set_um is None else permanent_set(found.set_um, found.set_judged)
    elements = "1 element" if found.elements == 1 else f"{found.elements} elements"
    carries = f"the shank bends at {limit}, factor {factor(found.safety_factor)}"
    flows = f"{elements} by up to {number(100 * found.max_plastic_strain, '.2g')} % ({found.where})"
    does = {
        "elastic": f"it stays elastic; {carries}",
        "flows": f"it flows in {flows} and stays {left}; {carries}",
        "bends": f"it bends {_PLANES[found.bending.plane]}, as it carries {limit}; "
        f"{left or 'nothing ends that before its bow is a tenth of its length'}",
        "collapses": f"it gives way plastically ({found.where})",
    }
    yield f"{_KINDS[found.kind].format(pressure)}, {force} on the rod: {does[found.state]}."


def overload_in_full(summary: Summary) -> Iterator[str]:
    """Yield what a single overload leaves, and how the shank bends under it."""
    yield from overload(summary)
    if summary.overload is not None:
        yield bends(summary.overload.bending, "the overload")
