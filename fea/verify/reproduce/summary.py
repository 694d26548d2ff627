"""Counts of a table, and its most important rows."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from fea.verify.reproduce.row import Row, Status
from fea.verify.reproduce.table import Table


@dataclass(frozen=True)
class Summary:
    """Counts over some tables.

    Attributes
    ----------
    compared, agrees, explained, named, unexplained
        Number of printed figures: all, and by `Status`.
    wrong
        Number of printed figures that differ from the correct ones by more than one unit of their last digit.
    """

    compared: int
    agrees: int
    explained: int
    named: int
    unexplained: int
    wrong: int


def summarise(tables: Iterable[Table]) -> Summary:
    """Count the printed figures of some tables."""
    rows = [row for table in tables for row in table.rows if row.status is not Status.NOT_PRINTED]
    counts = Counter(row.status for row in rows)
    return Summary(
        compared=len(rows),
        agrees=counts[Status.AGREES],
        explained=counts[Status.EXPLAINED],
        named=counts[Status.NAMED],
        unexplained=counts[Status.UNEXPLAINED],
        wrong=sum(row.is_wrong for row in rows),
    )


def verdict(tables: Iterable[Table]) -> str:
    """Return the counts as a sentence."""
    counts = summarise(tables)
    return (
        f"{counts.compared} printed figures were compared: {counts.agrees} agree with the printed formula, "
        f"{counts.explained} are explained by an error in the cell, {counts.named} are known to be wrong "
        f"without a traceable cause, {counts.unexplained} are unexplained; {counts.wrong} differ from the "
        "correct figures."
    )


def worst(table: Table) -> Row | None:
    """Row with the largest error relative to the scale of its quantity; None if no row differs."""
    rows = worst_of_each_quantity(table)
    return max(rows, key=lambda row: _relative(row, table), default=None)


def worst_of_each_quantity(table: Table) -> list[Row]:
    """For each quantity (and speed), the row with the largest error, if any."""
    found: dict[tuple[str, str], Row] = {}
    for row in table.rows:
        key = row.quantity, row.at.partition(", ")[0] if "rpm" in row.at else ""
        if row.is_wrong and (key not in found or row.error > found[key].error):
            found[key] = row
    return list(found.values())


def _relative(row: Row, table: Table) -> float:
    scale = max(abs(other.corrected) for other in table.rows if other.quantity == row.quantity)
    return row.error / scale if scale > 0 else row.error


def misprinted(tables: Iterable[Table]) -> list[Row]:
    """Rows in which a single printed figure is wrong, rather than the formula."""
    bad = (Status.EXPLAINED, Status.NAMED, Status.UNEXPLAINED)
    return [row for table in tables for row in table.rows if row.status in bad]
