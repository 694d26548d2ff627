"""[[gauge]]: strain gauges on the surface of the rod."""

from dataclasses import MISSING, dataclass
from typing import Any

from fea.study.tables import Positive, StudyTable, key, read_table
from geometry.errors import require


@dataclass(frozen=True)
class GaugeTable(
    StudyTable, table="gauge", intro="A strain gauge on the surface, [[gauge]] for each", optional=True
):
    """A strain gauge."""

    at_mm: tuple[float, ...] = key("[70.0, 0.0, 8.0]", "put on the nearest free surface", default=MISSING)
    direction: tuple[float, ...] = key("[1, 0, 0]", "of its grid, along the surface", default=MISSING)
    length_mm: Positive = key("3.0", "of its grid, over which strain is averaged", default=MISSING)
    name: str | None = key('"shank"')
    measured: tuple[float, ...] | None = key(
        "[820, -310]", "strains, µm/m, one for each load case in its order"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, three in (("at_mm", self.at_mm), ("direction", self.direction)):
            rule = "must have three components, x, y and z; those of a direction are not all 0"
            require(len(three) == 3 and (any(three) or name == "at_mm"), f"gauge.{name}", list(three), rule)


def read_gauges(raw: Any) -> tuple[GaugeTable, ...]:
    """Read the gauges of a study, tables of keys or `GaugeTable`.

    Raises `InvalidValue`: no list of tables, a wrong key, a broken rule, or two gauges of one name.
    """
    rule = "must be a list of tables"
    require(isinstance(raw, list | tuple), "gauge", str(raw), rule, "Write [[gauge]] above each.")
    gauges = tuple(
        each if isinstance(each, GaugeTable) else read_table(GaugeTable, "gauge", each) for each in raw
    )
    names = [gauge.name for gauge in gauges if gauge.name is not None]
    for name in names:
        rule = "is the name of two gauges"
        require(names.count(name) == 1, "gauge.name", name, rule, "Give each its own.")
    return gauges
