"""The page: one HTML file that runs what it holds and fetches nothing."""

import base64
import os
import shutil
import subprocess
import webbrowser
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from markupsafe import Markup

from fea.analysis.summary_figures import Summary
from fea.base.choices import UnitSystem
from fea.judge.safety_factor import SafetyFactor, interval
from fea.output.folder import PictureError, picture_name, write_text
from fea.output.fretting import FRETTING
from fea.output.html import environment, html_page, joined_script, packed_json, page_file
from fea.output.json_file import JsonObject
from fea.output.pictures.picture import draw_pictures
from fea.output.pictures.shown import described_by
from fea.output.report.scene import DrawnRod, scene
from fea.output.report.sections import ReportSection, sections
from fea.output.report.sheet import by_proportions, sheet_rows
from fea.output.stored_run import Run
from fea.output.tables import head_table
from fea.output.units import bar, coordinates, factor, quantity, system, unit
from geometry.arrays import Vector
from geometry.errors import require

_VERDICTS = {
    "survives": ("The rod survives", "The rod meets the required safety factor of {:g}"),
    "does not yield": (
        "The rod does not yield; fatigue is not judged",
        "The rod meets the required safety factor of {:g}, but fatigue is not judged",
    ),
    "shakes down": (
        "The rod flows at first and is elastic then; fatigue is not judged",
        "The rod meets the required safety factor of {:g} once it has flowed, but fatigue is not judged",
    ),
    "fails": ("The rod does not survive", "The rod does not meet the required safety factor of {:g}"),
    "undecided": ("Undecided", "Undecided whether the rod meets the required safety factor of {:g}"),
}


class _Fact(NamedTuple):
    """A figure of the answer: its name, the figure, and what else is to be said of it."""

    name: str
    value: str
    more: str


def _answer(summary: Summary) -> JsonObject:
    """Return the answer of a run for the head of its report.

    Its kind is ``survives``, ``fails`` and so on, or ``untrusted`` where a check failed.
    """
    survival = summary.survival
    required = survival.required_safety_factor
    plain, of_required = _VERDICTS[survival.answer]
    failed = [name.replace("_", " ") for name, check in summary.checks.items() if not check.passed]
    return {
        "verdict": plain if required == 1 else of_required.format(required),
        "text": f"{survival.text[0].upper()}{survival.text[1:]}.",
        "kind": survival.answer if summary.trusted else "untrusted",
        "doubts": failed,
        "facts": list(_facts(summary)),
    }


def _facts(summary: Summary) -> Iterator[_Fact]:
    """Yield the figures that matter most."""
    name, envelope, buckling = summary.worst_case, summary.envelope, summary.buckling
    worst, angle = summary.results[name], summary.loads[name].crank_deg
    where = _where(worst.at_mm)
    where = where if worst.error_percent is None else f"± {bar(worst.error_percent)} %, {where}"
    when = name if angle is None else f"{name}, crank angle {angle:.1f}°"
    yield _factor("yielding", worst.min_safety_factor, when)
    yield _Fact("Largest von Mises stress", quantity(worst.max_von_mises_MPa, ".0f", "MPa"), where)
    if envelope is not None and envelope.fatigue is not None:
        where = envelope.fatigue.where or _where(envelope.fatigue.at_mm)
        judged = f"{envelope.fatigue_criterion.capitalize()}, {where}"
        yield _factor("fatigue", envelope.min_fatigue_safety_factor, judged)
    if (most := summary.survival.fatigue_at_most) is not None:
        between = f"between the load cases, {summary.survival.fatigue_where}; --cycle judges it"
        yield _Fact("Safety factor against fatigue, at most", factor(most), between)
    if buckling.min_safety_factor is not None:
        under = f", under {buckling.column.case}" if buckling.column.case else ""
        yield _Fact(
            "Safety factor against buckling", factor(buckling.min_safety_factor), f"as a column{under}"
        )
    for end, film in (summary.film or {}).items():
        gap = f"± {bar(film.h_min_error_percent)} % at {film.h_min_deg:.0f}°, {film.verdict}"
        thinnest = quantity(film.h_min_um, ".2f", "µm")
        yield _Fact(f"Least oil film, {end.replace('_', ' ')}", thinnest, gap)
    passed = sum(check.passed for check in summary.checks.values())
    mesh = f"{summary.model.elements} elements, {summary.model.element}"
    yield _Fact("Checks passed", f"{passed} of {len(summary.checks)}", mesh)


def _where(at: Vector) -> str:
    return f"at x, y, z = {coordinates(at)} {unit('mm')}".replace("-", "−")


def _factor(mode: str, least: SafetyFactor | None, more: str) -> _Fact:
    bar = "" if least is None else interval(least)
    return _Fact(f"Safety factor against {mode}", factor(least), f"{bar}; {more}" if bar else more)


# In this order, as one script: each uses what stands before it.
_SCRIPTS = (
    "vectors.js", "numbers.js", "surface.js", "results.js", "camera.js", "painter.js", "loads.js", "pick.js",
    "hands.js", "charts.js", "legend.js", "films.js", "viewer.js", "start.js",
)  # fmt: skip


def page(run: Run, drawn: DrawnRod | None, picture: bytes | None, folder: Path | None = None) -> str:
    """Return the report of a run, with its rod in three dimensions if there is one.

    It opens with the builder's sheet, whose limits of speed and boost are those beside the run's folder.
    """
    parts = [_pictured(part, folder) for part in sections(run)]
    viewed, script = viewer(run, drawn, parts=parts)
    style = page_file("report", "report.css")
    head = _head(run, picture) | _sheet(run, folder)
    return html_page("report", "report.html.jinja", style, script, **head, sections=parts, **viewed)


def _pictured(part: ReportSection, folder: Path | None) -> ReportSection:
    """Return a section with the picture of its name in the folder of the run, if there is one."""
    file = None if folder is None else folder / f"{part.id}.png"
    if part.id != FRETTING or file is None or not file.is_file():
        return part
    return replace(part, content={**part.content, "picture": base64.b64encode(file.read_bytes()).decode()})


def sheet_page(run: Run, folder: Path | None = None) -> str:
    """Return the builder's sheet of a run alone."""
    style, values = page_file("report", "report.css"), _head(run, None) | _sheet(run, folder)
    return html_page("report", "sheet.html.jinja", style, "", **values, sections=())


def _sheet(run: Run, folder: Path | None) -> JsonObject:
    return {"rows": sheet_rows(run, folder), "proportions": by_proportions(run)}


def viewer(
    run: Run, drawn: DrawnRod | None, more: Sequence[str] = (), parts: Sequence[ReportSection] = ()
) -> tuple[JsonObject, str]:
    """Return what the templates of the rod in three dimensions need, and its script with `more` files."""
    values = {
        "scene": drawn,
        "header": None if drawn is None else packed_json(_with_charts(drawn, parts)),
        "last": run.summary.cycle_degrees,
        "numbers": "" if drawn is None else Markup(drawn.numbers),  # noqa: S704 - base64
        "scales": () if drawn is None else _scales(drawn.header["exaggeration"]),
        "without_motion": run.without_motion or _NOT_KEPT if run.motion is None and run.envelope else "",
    }
    if drawn is None:
        return values, ""
    return values, joined_script(("report", (*_SCRIPTS, *more)))


def head(run: Run, picture: bytes | None = None) -> str:
    """Return the head of the report alone, for a notebook: the answer, the load cases and a picture."""
    return environment("report").get_template("notebook.html.jinja").render(**_head(run, picture))


def _head(run: Run, picture: bytes | None) -> JsonObject:
    return {
        "title": run.summary.title,
        "answer": _answer(run.summary),
        "cases": head_table(run.summary),
        "picture": None if picture is None else base64.b64encode(picture).decode(),
        "worst": run.summary.worst_case,
        "length": unit("mm"),
    }


_NOT_KEPT = "the cycle was analysed without what it needs (analyse(…, report=True) keeps that)"


def _with_charts(drawn: DrawnRod, parts: Sequence[ReportSection]) -> JsonObject:
    turns = any(result["kind"] == "cycle" for result in drawn.header["results"]) or drawn.header["films"]
    drawings = [chart for part in parts for chart in part.content.get("charts", ()) if chart.series]
    charts = [chart.moving() for chart in drawings] if turns else []
    return {**drawn.header, "charts": charts}


def _scales(usual: float) -> list[tuple[float, str]]:
    named = {0.0: "none", 1.0: "true size", usual / 2: "", usual: "", 2 * usual: ""}
    return [(scale, words or f"× {scale:g}") for scale, words in named.items() if scale == 0 or scale >= 1]


_MARK = '<meta name="generator" content="conrod-fea">'
_HEAD = 4096  # characters within which the mark stands


def open_report(file: Path) -> None:
    """Open a report. Raises `InvalidValue`: it is none of this program; `PictureError`: no browser."""
    require(file.is_file(), "FILE", str(file), "is not a file", "Name a report.html that fea wrote.")
    with file.open(encoding="utf-8", errors="replace") as text:
        ours = _MARK in text.read(_HEAD)
    require(ours, "FILE", str(file), "is not a report of fea", "Name a report.html that fea wrote.")
    if not webbrowser.open(file.resolve().as_uri()):
        raise PictureError(
            f"No browser was found to open {file}: open it by hand, or copy it to a machine with one."
        )


def write_sheet(path: Path, run: Run, folder: Path | None = None) -> None:
    """Write the builder's sheet of a run, whose folder may be another one, alone. Raises `StorageError`."""
    write_text(path, sheet_page(run, folder or path.parent))


def write_report(path: Path, run: Run, folder: Path | None = None) -> None:
    """Write a report; its picture is that of the run's folder, or drawn, or left out. `StorageError`."""
    with ThreadPoolExecutor(1) as beside:  # another process draws meanwhile
        units = run.study.output.units
        picture = beside.submit(copy_context().run, still, folder or path.parent, run.summary, units)
        drawn = scene(run)
        text = page(run, drawn, picture.result(), folder or path.parent)
    write_text(path, text)


def still(folder: Path, summary: Summary, drawn_in: UnitSystem = UnitSystem.SI) -> bytes | None:
    """The picture of the worst case in a folder, in units `drawn_in`, or a new one, or None."""
    result = f"{summary.worst_case}.vtu"
    there = folder / picture_name(result)
    if there.is_file() and drawn_in is system():
        return there.read_bytes()
    if not (folder / result).is_file():
        return None
    with TemporaryDirectory() as scratch:
        png = Path(scratch, there.name)
        try:
            draw_pictures([replace(described_by(summary, folder / result), png=png)])
        except PictureError:
            return None
        return png.read_bytes()


# Programs of the Chromium family, by the names that systems give them; macOS keeps them out of the path.
_PROGRAMS = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge",
    "microsoft-edge", "brave-browser",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)  # fmt: skip
_PATIENCE = 120.0  # seconds


def write_pdf(page: Path, pdf: Path) -> None:
    """Print a page. Raises `PictureError`: there is no Chromium, or it wrote nothing; says what to do."""
    program = next((found for name in _PROGRAMS if (found := shutil.which(name))), None)
    by_hand = f"Open {page} in any browser and print it into a file."
    if program is None:
        raise PictureError(f"No Chromium, Chrome or Edge was found to print {page}. {by_hand}")
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        made = Path(profile, pdf.name)
        options = ["--headless", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={profile}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # its sandbox refuses the superuser
            options.append("--no-sandbox")
        command = [program, *options, f"--print-to-pdf={made}", page.absolute().as_uri()]
        try:
            subprocess.run(command, capture_output=True, check=True, timeout=_PATIENCE)  # noqa: S603 - a browser
            written = made.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise PictureError(
                f"{program} could not print {page} ({type(error).__name__}). {by_hand}"
            ) from error
    pdf.write_bytes(written)
