"""What yielding leads to, in sentences."""

from collections.abc import Iterator

from fea.analysis.summary_figures import Summary
from fea.output.overload_statements import bends, permanent_set
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
