"""The table of what the gap between piston and head must leave."""

from collections.abc import Iterator

from fea.analysis.summary_figures import Summary
from fea.output.tables import AnswerTable, TableColumn

_CAPTION = (
    "What the gap between piston and head must leave at {}, beside a margin; "
    "builders are used to leave about 1 mm with steel rods and 1.5 mm with aluminium rods"
)
_PARTS = (
    TableColumn("stretch of the rod between its pins, with ovality and joint", "mm", "rod_stretch_mm", ".3f"),
    TableColumn("radial clearances of both pins", "mm", "clearances_mm", ".3f"),
    TableColumn("bending of the piston pin", "mm", "pin_bending_mm", ".3f"),
    TableColumn("main bearing and crank (assumed)", "mm", "crank_mm", ".3f"),
    TableColumn("sum of the cold engine", "mm", "cold_mm", ".2f"),
    TableColumn("growth of the warm piston (assumed)", "mm", "piston_growth_mm", ".3f"),
    TableColumn("growth of the warm rod (assumed)", "mm", "rod_growth_mm", ".3f"),
    TableColumn(
        "growth of a block of aluminium, which carries the head away (assumed)",
        "mm",
        lambda row: -row.aluminium_block_growth_mm,
        ".3f",
    ),
    TableColumn("the same of cast iron", "mm", lambda row: -row.iron_block_growth_mm, ".3f"),
    TableColumn("sum of the warm engine, aluminium block", "mm", "hot_aluminium_block_mm", ".2f"),
    TableColumn("sum of the warm engine, iron block", "mm", "hot_iron_block_mm", ".2f"),
)


def head_clearance_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the parts of the gap with their signs and their sums, where they are known."""
    if summary.head_clearance is not None:
        centre = "top dead centre, were the gas not to push there"
        centre = "the dead centre of gas exchange" if summary.cycle_degrees > 360 else centre
        yield AnswerTable.of_quantities(_CAPTION.format(centre), _PARTS, summary.head_clearance)
