"""The answer on fretting: statements and tables."""

from collections.abc import Iterator

from fea.analysis.fretting import AS_GIVEN
from fea.analysis.fretting_figures import BoltSeatFigures, FrettingFigures, FrettingPlaceFigures
from fea.analysis.summary_figures import Summary
from fea.output.tables import AnswerTable, TableColumn
from fea.output.units import coordinates, factor, number, place, quantity

FRETTING = "fretting"  #: name of its section and of its picture
RANKED = (
    "Places are ranked by σ τδ: tensile stress along the surface, shear and range of slip. No limit of it is "
    "known: it says where fretting is most likely to begin a crack, and which design is worse, not whether "
    "one begins. Slip of about 5 to 50 µm is the most harmful; more wears cracks away (assumed)."
)


def fretting(summary: Summary) -> Iterator[str]:
    """Yield the place that is most likely to crack by fretting, and bolt heads that slide."""
    if (found := summary.fretting) is None:
        return
    if found.places:
        worst, of = found.places[0], "a ranking"
        if found.proven_ruiz_2 is not None:
            of = f"{number(worst.ruiz_2 / found.proven_ruiz_2, '.2f')} of what has served"
        at = f"{worst.pair.removeprefix('seat of the ')} at {place(worst.at_mm)}"
        yield f"Fretting: {at}, σ τδ {number(worst.ruiz_2, '.3g')} MPa²·mm ({of})."
    else:
        pair, most = max(found.pairs.items(), key=lambda item: item[1].most_energy_mJ)
        yield f"Fretting: nothing rubs under tension; most energy at {place(most.most_energy_at_mm)}, {pair}."
    for name, seat in (found.bolt_seats or {}).items():
        if seat.reserve < 1:
            yield f"Bolt {name}: {_held(seat)}."


def _against(found: FrettingFigures) -> str:
    """Say what the ranking is worth, and what friction and crush do to the worst pair."""
    severity, proven = found.places[0].ruiz_2, found.proven_ruiz_2
    limit = "a ranking: no limit is known"
    if proven is not None:
        of = f"{number(severity / proven, '.2f')} times the {number(proven, '.3g')} MPa²·mm that have served"
        limit = f"σ τδ {number(severity, '.3g')}, {of}"
    pair, changes = found.places[0].pair, dict(found.changes or {})
    now = changes.pop(AS_GIVEN, {}).get(pair)
    if now is None or not now.ruiz_1 or not changes:
        return limit
    rises = {words: 100 * (of[pair].ruiz_1 / now.ruiz_1 - 1) for words, of in changes.items()}
    more = ", ".join(f"{rise:+.0f} % with {words}" for words, rise in rises.items())
    return f"{limit}; largest τδ {more.replace('-', '−')}"


def _under(name: str, seat: BoltSeatFigures) -> str:
    """Say what rubs under heads or nuts."""
    slip = quantity(seat.slip_um, ".1f", "µm")
    tension = "stress singular on this mesh"
    if seat.ruiz_2 is not None:
        tension = f"σ τδ {number(seat.ruiz_2, '.3g')} MPa²·mm" if seat.ruiz_2 else "no tension along it"
    under = f"{quantity(seat.pressure_MPa, '.0f', 'MPa')} at {place(seat.at_mm)}"
    work = quantity(seat.ruiz_1, ".2g", "N/mm")
    return f"Under bolt {name}, estimated: slip {slip} under {under}, τδ {work}, {tension}; {_held(seat)}."


def _held(seat: BoltSeatFigures) -> str:
    bears = f"friction {seat.friction:g} bears {number(seat.reserve, '.3g')} times the shear on them"
    slides = quantity(seat.slides_um, ".1f", "µm")
    return f"they slide by up to {slides}, as {bears}" if seat.reserve < 1 else f"{bears}: they do not slide"


def _worst(worst: FrettingPlaceFigures) -> str:
    slip, pressure, tension = (
        quantity(value, form, unit)
        for value, form, unit in (
            (worst.slip_um, ".1f", "µm"),
            (worst.pressure_MPa, ".0f", "MPa"),
            (worst.tension_MPa, ".0f", "MPa"),
        )
    )
    below = "" if worst.factor is None else f"; Crossland below it {factor(worst.factor)}"
    at = f"{worst.pair}, {place(worst.at_mm)}, {number(worst.crank_deg, '.0f')}°"
    return f"{at}: slip {slip} under {pressure}, tension {tension}{below}"


def fretting_in_full(summary: Summary) -> Iterator[str]:
    """Yield the worst place, how each pair slips and where its largest tension is, and bolt seats."""
    if (found := summary.fretting) is None:
        return
    if found.places:
        yield f"Fretting, most likely: {_worst(found.places[0])} ({_against(found)})."
    else:
        yield from fretting(summary)
    for name, pair in found.pairs.items():
        slip, creep = (quantity(value, ".2g", "µm") for value in (pair.slip_um, pair.creep_um))
        share = f"{number(pair.slipping_percent, '.0f')} % of it slips, by up to {slip}"
        tension = "stress singular on this mesh"
        if pair.tension_at_mm is not None:
            largest = quantity(pair.tension_MPa, ".0f", "MPa")
            tension = f"largest tension {largest}, at {place(pair.tension_at_mm)}"
        mJ = f"{number(pair.energy_mJ, '.3g')} mJ a cycle"
        mJ += "" if pair.duty_W is None else f" ({number(pair.duty_W, '.2g')} W over the duty)"
        head = f"{name[0].upper()}{name[1:]}: {share} ({creep} left by the last cycle); {mJ}"
        yield f"{head}, most at {place(pair.most_energy_at_mm)}; {tension}."
    yield from (_under(name, seat) for name, seat in (found.bolt_seats or {}).items())


_WHERE = (
    TableColumn("at x, y, z", "mm", "at_mm", coordinates),
    TableColumn("crank angle", "°", "crank_deg", ".0f"),
    TableColumn("slip", "µm", "slip_um", ".3g"),
)
_PRESSURE = TableColumn("pressure", "MPa", "pressure_MPa", ".0f")
_TENSION = TableColumn("tension", "MPa", "tension_MPa", ".0f")
_RUIZ = (
    TableColumn("τδ", "N/mm", "ruiz_1", ".2g"),
    TableColumn("σ τδ", "MPa²·mm", "ruiz_2", ".3g"),
)
_PLACES = (
    TableColumn("part", "", "part", words=True),
    *_WHERE,
    _PRESSURE,
    TableColumn("shear", "MPa", "shear_MPa", ".1f"),
    _TENSION,
    TableColumn("energy", "mJ/mm²", "energy_mJ", ".2g"),
    *_RUIZ,
    TableColumn("Crossland", "", "factor", factor),
    TableColumn("over", "mm", "averaged_mm", ".1f"),
)
_BOLT_SEATS = (
    *_WHERE,
    TableColumn("of which slides", "µm", "slides_um", ".3g"),
    TableColumn("friction bears", "times", "reserve", ".3g"),
    _PRESSURE,
    _TENSION,
    *_RUIZ,
)
_CHANGES = (
    TableColumn("largest slip", "µm", "slip_um", ".3g"),
    TableColumn("energy", "mJ", "energy_mJ", ".3g"),
    TableColumn("largest τδ", "N/mm", "ruiz_1", ".2g"),
)


def fretting_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the worst places, bolt seats, and what friction and crush would change."""
    if (found := summary.fretting) is None:
        return
    caption = (
        "Places that rub, the worst first by σ τδ: range of slip, stresses of one instant, energy a cycle; "
        "Crossland's factor with the stress averaged over a half ball below the surface"
    )
    if found.places:
        yield AnswerTable.of(caption, "pair", _PLACES, ((each.pair, each) for each in found.places))
    if found.bolt_seats:
        caption = (
            "Under bolt heads and nuts, estimated with rigid heads and an even pressure: the worst place; "
            "friction bears so many times half the range of shear that would make heads slide"
        )
        under = ((f"bolt {name}", seat) for name, seat in found.bolt_seats.items())
        yield AnswerTable.of(caption, "under", _BOLT_SEATS, under)
    rows = [
        (f"{pair}, {words}", figures)
        for words, pairs in (found.changes or {}).items()
        for pair, figures in pairs.items()
    ]
    caption = "What friction and crush change, by the contact of the cycle alone"
    if rows:
        yield AnswerTable.of(
            caption, "pair", _CHANGES, sorted(rows, key=lambda row: row[0].partition(",")[0])
        )
