"""The page of a sweep: one HTML file that fetches nothing."""

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fea.output.report.coding import embedded_json, policy
from fea.output.sweep_report.drawings import Swept, main_effects, matrix, parallel, pareto
from fea.output.text import write_text

_OUTPUT = files("fea") / "output"


def write_sweep_report(path: Path, swept: Swept) -> None:
    """Write the report of a sweep; raises `StorageError` if the system refuses."""
    write_text(path, sweep_page(swept))


def sweep_page(swept: Swept) -> str:
    """Return the report of a sweep as HTML."""
    style = _text("report", "report.css") + _text("sweep_report", "sweep.css")
    script = _text("sweep_report", "sweep.js")
    return (
        _environment()
        .get_template("sweep.html.jinja")
        .render(
            swept=swept,
            pareto=pareto(swept),
            matrix=matrix(swept),
            effects=main_effects(swept),
            parallel=parallel(swept),
            fails=_fails(swept),
            data=embedded_json(_data(swept)),
            policy=policy(style, script),
            style=Markup(style),  # noqa: S704 - our own
            script=Markup(script),  # noqa: S704 - our own
        )
    )


def _fails(swept: Swept) -> set[int]:
    """Numbers of the designs whose factor is below 1."""
    factors = swept.figures.get("factor", ())
    return {n for n, factor in enumerate(factors) if factor < 1}


def _data(swept: Swept) -> dict[str, Any]:
    """The studies, whose lines are mostly alike: each line once, and its numbers in each study."""
    numbers: dict[str, int] = {}
    studies = [
        [numbers.setdefault(line, len(numbers)) for line in text.splitlines()] for text in swept.studies
    ]
    columns = {**swept.keys, **swept.figures}
    values = [
        {name: float(f"{column[n]:.6g}") for name, column in columns.items() if column[n] == column[n]}
        for n in range(len(swept.rows))
    ]  # fmt: skip
    return {"rows": list(swept.rows), "lines": list(numbers), "studies": studies, "values": values}


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("fea.output.sweep_report", "page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _text(room: str, name: str) -> str:
    return (_OUTPUT / room / "page" / name).read_text(encoding="utf-8")
