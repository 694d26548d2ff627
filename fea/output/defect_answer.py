"""Defects in the answer: sentences, and the table of the regions."""

from collections.abc import Iterator
from math import acos, degrees

from fea.analysis.defect_figures import FlawLifeFigures
from fea.analysis.summary_figures import Summary
from fea.judge.defect import LARGEST, LONG, Position
from fea.output.life_statements import roughly
from fea.output.tables import AnswerTable, TableColumn
from fea.output.units import coordinates, number, place, quantity, unit

# √area, µm, of a long flaw of 0.1 mm depth: below it, defects are worth a line without being asked for.
_MATTERS = LONG * 100.0


def given_flaw(summary: Summary) -> Iterator[str]:
    """Yield whether a given flaw grows over the cycle, and over a duty, and how fast."""
    if summary.defect is None or (flaw := summary.defect.flaw) is None:
        return
    size = f"{number(flaw.depth_mm, 'g', 'mm')} × {quantity(flaw.length_mm, 'g', 'mm')}"
    size += "" if flaw.position == Position.SURFACE else f" {flaw.position}"
    yield f"Flaw of {size}, {flaw.where}, {place(flaw.at_mm)}: {_growth(flaw, f'by {flaw.criterion}')}."
    if (duty := flaw.duty) is not None:
        yield f"Over the duty the flaw {_growth(duty, f'at {duty.rpm:g} rpm')}."


def _growth(found: FlawLifeFigures, by: str) -> str:
    """Say whether a flaw grows, `by` what, and how fast; growth is known to one digit."""
    grows = "grows" if found.factor < 1 else "does not grow" if found.factor.low >= 1 else "may grow"
    text = f"{grows}, factor {found.factor.text} {by}"
    if found.hours is not None:
        surfaces = found.hours_to_surface
        first = "" if surfaces is None else f"{roughly(surfaces)} to the surface, "
        text += f"; about {first}{roughly(found.hours)} to {found.ends}"
    elif found.factor.low < 1:
        text += "; how fast is not worked out, as it lies along the surface"
    if (depth := found.depth_after_service_mm) is not None:
        text += f"; grown to {quantity(depth, '.2g', 'mm')} by the next service"
    return text


def defect_sizes(summary: Summary) -> Iterator[str]:
    """Yield the size that a given flaw counts with, and the largest that does not grow, where it is small."""
    if (found := summary.defect) is None:
        return
    if (flaw := found.flaw) is not None:
        amplitude, ratio = quantity(flaw.amplitude_MPa, ".0f", "MPa"), number(flaw.stress_ratio, ".2f")
        size, share = quantity(flaw.area_root_um, ".0f", "µm"), number(flaw.counted_percent, ".0f")
        turned = number(degrees(acos(min(abs(flaw.normal[0]), 1.0))), ".0f")
        yield (
            f"The flaw counts with {share} % of its area, √area = {size}, under an amplitude of {amplitude}, "
            f"R = {ratio}. That stress acts at {turned}° to the rod's axis: a lap along it hardly counts."
        )
    if found.smallest_um and found.smallest_um < _MATTERS:
        worst, low = found.regions[0], min(each.smallest_um_low for each in found.regions)
        size, ends = _size(worst.smallest_um), f"{_size(low)} … {_size(worst.smallest_um_high)}"
        yield (
            f"Defects: the largest that does not grow has √area = {size} ({ends}) {unit('µm')}, as a long "
            f"flaw of {_size(worst.smallest_um, 1 / LONG)} {unit('µm')} depth, {worst.region}, "
            f"{place(worst.at_mm)} ({found.hardness_HV:.0f} HV)."
        )


_REGIONS = (
    TableColumn("√area", "µm", lambda row: _size(row.smallest_um)),
    TableColumn("from", "µm", lambda row: _size(row.smallest_um_low)),
    TableColumn("to", "µm", lambda row: _size(row.smallest_um_high)),
    TableColumn("depth, long", "µm", lambda row: _size(row.smallest_um, 1 / LONG)),
    TableColumn("at x, y, z", "mm", "at_mm", coordinates),
    TableColumn("amplitude", "MPa", "amplitude_MPa", ".0f"),
    TableColumn("R", "", "stress_ratio", ".2f"),
)


def _size(size: float, share: float = 1.0) -> str:
    return f"{'> ' if size >= LARGEST else ''}{number(float(f'{share * size:.2g}'), 'g', 'µm')}"


def defect_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the largest defects that do not grow, by region."""
    if summary.defect is not None and summary.defect.regions:
        caption = (
            "Largest defects that do not grow over the cycle: Murakami's √area, across the largest principal "
            "stress (0: fails without one; residual stress and fretting are left out)"
        )
        rows = [(row.region, row) for row in summary.defect.regions]
        yield AnswerTable.of(caption, "region", _REGIONS, rows)
