"""The studies by name."""

from collections.abc import Callable, Sequence

from fea.verify.reproduce import columba, leon, molina
from fea.verify.reproduce.table import Table
from geometry.errors import require

SOURCES: dict[str, Callable[[], list[Table]]] = {
    leon.SOURCE: leon.tables,
    columba.SOURCE: columba.tables,
    molina.SOURCE: molina.tables,
}


def reproduce(source: str) -> list[Table]:
    """Compare every printed figure of a study, or of all of them.

    Raises
    ------
    InvalidValue
        There is no such study.
    """
    require(
        source == "all" or source in SOURCES, "SOURCE", source, f"must be one of {', '.join(SOURCES)}, all"
    )
    chosen: Sequence[str] = list(SOURCES) if source == "all" else [source]
    return [table for name in chosen for table in SOURCES[name]()]
