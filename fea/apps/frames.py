"""Results as tables of pandas, whose columns are named as in `summary.json`, with their units."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fea.analysis.summary_figures import Summary
from fea.output.json_file import as_dict
from fea.study.changes import TABLES
from fea.study.study import Study
from fea.study.tables import entries_of

if TYPE_CHECKING:
    import pandas as pd

Row = Mapping[str, Any]


def case_rows(summary: Summary) -> dict[str, dict[str, Any]]:
    """Return the figures of each load case that a cell has room for; a place is three of them."""
    rows = {}
    for name, result in summary.results.items():
        figures = as_dict(result) | as_dict(summary.loads[name])
        place = dict(zip(("x_mm", "y_mm", "z_mm"), figures.pop("at_mm"), strict=True))
        rows[name] = place | {
            key: value for key, value in figures.items() if not isinstance(value, dict | list)
        }
    return rows


def differing(studies: Sequence[Study | None]) -> list[dict[str, Any]]:
    """Return name and keys, ``rod.length_mm``, by which studies differ, of each; none for None."""
    every = [{} if study is None else _keys(study) for study in studies]
    names = dict.fromkeys(name for keys in every for name in keys)
    known = [keys for keys, study in zip(every, studies, strict=True) if study is not None]
    varied = [name for name in names if any(keys.get(name) != known[0].get(name) for keys in known)]
    return [{name: keys.get(name) for name in varied} for keys in every]


def _keys(study: Study) -> dict[str, Any]:
    tables = {name: getattr(study, name) for name in TABLES.keys() - {"rod", "output"}}
    entries = {name: entries_of(tables[name]) for name in TABLES if tables.get(name) is not None}
    entries = {"rod": study.rod.as_dict()} | entries
    entries |= {f"material.{part}": entries_of(table) for part, table in study.part_material.items()}
    leaves = {f"{name}.{key}": value for name, keys in entries.items() for key, value in keys.items()}
    return {"name": study.name} | leaves


def frame(rows: Mapping[Any, Row], index: str) -> "pd.DataFrame":
    """Return rows by their names as a frame. Raises `ImportError`: pandas is not installed."""
    try:
        import pandas as pd  # noqa: PLC0415 - the rest does without it
    except ModuleNotFoundError as error:
        raise ImportError("to_frame needs pandas, not installed here: pip install pandas") from error
    return pd.DataFrame(list(rows.values()), index=pd.Index(list(rows), name=index))
