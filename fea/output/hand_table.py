"""The hand calculation as a table: by formulas of textbooks, beside the finite elements."""

from collections.abc import Callable, Iterator

from fea.analysis.summary_figures import HandFigures, Summary
from fea.output.tables import AnswerTable, TableColumn
from fea.output.units import factor, quantity


def _of(name: str) -> Callable[[HandFigures], str]:
    def text(row: HandFigures) -> str:
        value = getattr(row, name)
        return quantity(value, ".1f", row.unit) if row.unit else factor(value)

    return text


_HAND = (
    TableColumn("formula", "", "formula", words=True),
    TableColumn("by hand", "", _of("value")),
    TableColumn("finite elements", "", _of("result")),
    TableColumn("ratio", "", "ratio", ".2f"),
)


def hand_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield what was worked out by hand, if anything was."""
    rows = [(each.title, each) for each in (summary.hand or {}).values()]
    if rows:
        yield AnswerTable.of(
            "By hand and by finite elements; the ratio is the latter over the former", "figure", _HAND, rows
        )
