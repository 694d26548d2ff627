"""The page: one HTML file that runs what it holds and fetches nothing."""

import base64
import webbrowser
from pathlib import Path
from typing import Any

from markupsafe import Markup

from fea.analysis.result import Run
from fea.output.html import environment, html_page, page_file
from fea.output.report.answer import answer
from fea.output.report.coding import embedded_json
from fea.output.report.scene import Scene
from fea.output.report.sections import Section, sections
from fea.output.report.tables import head_table
from fea.output.target import PictureError
from geometry.errors import require

# In this order, as one script: each uses what stands before it.
_SCRIPTS = (
    "vectors.js", "numbers.js", "surface.js", "results.js", "camera.js", "painter.js", "loads.js", "pick.js",
    "hands.js", "charts.js", "viewer.js", "start.js",
)  # fmt: skip


def page(run: Run, drawn: Scene | None, picture: bytes | None) -> str:
    """Return the report of a run, with its rod in three dimensions if there is one."""
    parts = sections(run)
    return html_page(
        "report",
        "report.html.jinja",
        page_file("report", "report.css"),
        "" if drawn is None else _script(),
        **_head(run, picture),
        sections=parts,
        scene=drawn,
        header=None if drawn is None else embedded_json(_with_charts(drawn, parts)),
        numbers="" if drawn is None else Markup(drawn.numbers),  # noqa: S704 - base64
        scales=() if drawn is None else _scales(drawn.header["exaggeration"]),
        without_motion=_without_motion(run),
    )


def _without_motion(run: Run) -> str:
    """Why the crank does not turn where the cycle was analysed; empty otherwise."""
    if run.motion is not None or run.envelope is None:
        return ""
    return run.without_motion or _NOT_KEPT


def head(run: Run, picture: bytes | None = None) -> str:
    """Return the head of the report alone, for a notebook: the answer, the load cases and a picture."""
    return environment("report").get_template("notebook.html.jinja").render(**_head(run, picture))


def _head(run: Run, picture: bytes | None) -> dict[str, Any]:
    return {
        "title": run.summary.title,
        "answer": answer(run.summary),
        "cases": head_table(run.summary),
        "picture": None if picture is None else base64.b64encode(picture).decode(),
        "worst": run.summary.worst_case,
    }


_NOT_KEPT = "the cycle was analysed without what it needs (analyse(…, report=True) keeps that)"


def _script() -> str:
    body = "\n".join(page_file("report", name) for name in _SCRIPTS)
    return f'(() => {{\n"use strict";\n{body}}})();\n'


def _with_charts(drawn: Scene, parts: list[Section]) -> dict[str, Any]:
    """The header of the scene; the charts only where there is a slider that moves along them."""
    turns = any(result["kind"] == "cycle" for result in drawn.header["results"])
    charts = [chart.moving() for part in parts for chart in part.charts] if turns else []
    return {**drawn.header, "charts": charts}


def _scales(usual: float) -> list[tuple[float, str]]:
    """Magnifications of the displacements to choose from."""
    found = {0.0: "none", 1.0: "true size", usual / 2: "", usual: "", 2 * usual: ""}
    return [
        (scale, words or f"× {scale:g}") for scale, words in found.items() if scale in {0, 1} or scale > 1
    ]


_MARK = '<meta name="generator" content="conrod-fea">'
_HEAD = 4096  # characters within which the mark stands


def open_report(file: Path) -> None:
    """Open a report.

    Raises
    ------
    InvalidValue
        There is no such file, or it is no report of this program.
    PictureError
        There is no browser.
    """
    require(file.is_file(), "FILE", str(file), "is not a file", "Name a report.html that fea wrote.")
    with file.open(encoding="utf-8", errors="replace") as text:
        ours = _MARK in text.read(_HEAD)
    require(ours, "FILE", str(file), "is not a report of fea", "Name a report.html that fea wrote.")
    if not webbrowser.open(file.resolve().as_uri()):
        raise PictureError(
            f"No browser was found to open {file}: open it by hand, or copy it to a machine with one."
        )
