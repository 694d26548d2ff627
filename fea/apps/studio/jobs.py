"""Jobs of the two worker processes of `fea studio`: each function is run in one of them for the server."""

import asyncio
import json
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from itertools import chain, count
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple

import numpy as np

from fea.apps.optimise.designs import Design, Designs
from fea.apps.optimise.problem import variables
from fea.apps.optimise.run_optimise import search_study
from fea.apps.optimise.search import USUAL, search
from fea.apps.run_study import run_study
from fea.apps.studio.figures import MODES, StudioFrame
from fea.apps.studio.operating_point import OperatingPoint, applied, controls
from fea.apps.studio.session import State
from fea.machine.isolated import CrashError, IsolatedProcess, fresh, say
from fea.machine.system import replaced
from fea.output.folder import csv_text, write_text
from fea.output.json_file import JsonObject
from fea.output.pictures.shown import VON_MISES
from fea.output.report.scene import case_fields
from fea.study.study import Study
from geometry.cad.formats import step_file
from geometry.session import session

MODEL = "fea.apps.studio.live_rod"
# Files that are written at once, and those that take a process of their own, by kind; with their suffixes.
QUICK, SLOW = {"study": ".toml", "table": ".csv"}, {"step": ".step", "report": ""}
# A peak above this share of the end of the legend keeps it, so that colours keep their meaning in a drag.
_KEEPS_LEGEND = 0.6


class _Worker:
    """State of a worker process."""

    study: Study
    model: Any
    live: Any = None
    steps: Iterator[Any] = iter(())
    mesh: tuple[int, int, bytes] = (-1, 0, b"")  # number of the base, checksum and packed triangles


class FrameMessage(NamedTuple):
    """A frame for the page: its header, places and values of its nodes, and its triangles."""

    header: JsonObject
    numbers: bytes
    triangles: bytes


def open_worker(study: Study, model: str) -> None:
    """Begin: the model is a module with `LiveRod` and `fresh`."""
    _Worker.study, _Worker.model = study, resolve_name(model)


def open_live(study: Study, model: str) -> None:
    """Begin with a rod that answers at once, which takes seconds."""
    open_worker(study, model)
    _Worker.live = _Worker.model.LiveRod(study)


def describe() -> JsonObject:
    """Return what the page needs for its layout."""
    study, live = _Worker.study, _Worker.live
    return {
        "title": study.name,
        "dimensions": [_plain(each) for each in live.dimensions],
        "ranges": ranges({"design": live.base_design}),
        "controls": [_plain(control) for control in controls(study)],
        "required": study.analysis.min_safety or 1.0,
    }


def ranges(state: State) -> JsonObject:
    """Return how far each dimension can go, and why it ends there, by its name."""
    return {name: _plain(each) for name, each in _Worker.live.ranges(dict(state["design"])).items()}


def frame(serial: int, state: State, top: float, field: str) -> FrameMessage:
    """Return the interpolated frame of a design; `top`: the end of the legend before."""
    return _message(serial, state, top, _Worker.live.frame(dict(state["design"]), _operation(state), field))


def begin(kind: str, state: State, what: str) -> None:
    """Begin a job of several steps: "touch" a dimension, or solve "exact" with a field."""
    live, design, operation = _Worker.live, dict(state["design"]), _operation(state)
    touch = kind == "touch"
    _Worker.steps = live.touch(what, design, operation) if touch else live.exact(design, operation, what)


def step(serial: int, state: State, top: float) -> FrameMessage | float | None:
    """Take the next step; return a frame, the progress of sampling, or None at the end."""
    found = next(_Worker.steps, None)
    return _message(serial, state, top, found) if isinstance(found, StudioFrame) else found


def converge(serial: int, state: State, top: float) -> FrameMessage:
    """Solve a design on a mesh of its own, refined, with the pins that its study asks for."""
    return _message(serial, state, top, _Worker.model.fresh(_applied(state)))


def _operation(state: State) -> OperatingPoint:
    return _operation_of(tuple(state["operation"].items()))


@lru_cache(maxsize=8)
def _operation_of(values: tuple[tuple[str, Any], ...]) -> OperatingPoint:
    return OperatingPoint.of(_Worker.study).changed(dict(values))


def _applied(state: State) -> Study:
    return applied(_Worker.study, dict(state["design"]), _operation(state))


def _plain(value: Any) -> JsonObject:
    """A dataclass as JSON has it: what is not finite is None."""
    text = json.dumps(value, default=lambda each: float(each) if isinstance(each, np.generic) else vars(each))
    plain: JsonObject = json.loads(text, parse_constant=lambda _: None)
    return plain


def _message(serial: int, state: State, top: float, frame: StudioFrame) -> FrameMessage:
    header = {"kind": "frame", "serial": serial, "state": state, "operation": frame.operation.values}
    header |= {"label": str(frame.label), "figures": None}
    header |= {name: getattr(frame, name) for name in ("pins", "new_mesh", "corrected", "one_piece")}
    if frame.points is None or frame.values is None or frame.figures is None:
        return FrameMessage(header, b"", b"")
    checks = frame.figures.checks or {}
    failed = [name.replace("_", " ") for name, check in checks.items() if not check.passed]
    if frame.triangles is not None or frame.base != _Worker.mesh[0]:
        triangles = _Worker.live.triangles if frame.triangles is None else frame.triangles
        packed = triangles.astype("<u4").tobytes()
        _Worker.mesh = (frame.base, zlib.crc32(packed), packed)
    header["figures"] = _plain(frame.figures) | {"governs": frame.figures.governs, "failed": failed}
    peak = max(case.peak_MPa for case in frame.figures.cases)
    largest = {VON_MISES: np.array([np.nanmax(frame.values)])}
    legend = case_fields(largest, top if _KEEPS_LEGEND * top <= peak <= top else peak)[0]
    header |= {"mesh": _Worker.mesh[1], "nodes": len(frame.points), "field": legend}
    numbers = b"".join(np.ascontiguousarray(each, "<f4").data for each in (frame.points, frame.values))
    return FrameMessage(header, numbers, _Worker.mesh[2])


def export(what: str, state: State, variants: Mapping[str, Any], folder: str, name: str) -> JsonObject:
    """Write a study, solid, report or table into a folder; return its path, and a text to offer as a copy."""
    study, suffix = _applied(state), (QUICK | SLOW)[what]
    stem = "variants" if what == "table" else re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-") or "study"
    # study.toml, study-2.toml, …
    tries = (f"{stem}{number}{suffix}" for number in chain(("",), count(-2, -1)))
    path = next(place for place in map(Path(folder).joinpath, tries) if not place.exists())
    if what in QUICK:
        text = study.text() if what == "study" else _table(variants)
        write_text(path, text)
        return {"path": str(path), "text": text}
    if what == "step":
        with session(), replaced(path) as part:
            part.write_bytes(step_file(study.rod.solid()))
        return {"path": str(path)}
    output = replace(study.output, directory=str(path.resolve()), report=True, screenshot=False)
    run_study(replace(study, output=output))
    return {"path": str(path / "report.html")}


def _table(variants: Mapping[str, Any]) -> str:
    rows = []
    for name, variant in variants.items():
        row = {"variant": name, **variant["state"]["design"], **variant["state"]["operation"]}
        if answer := variant["answer"]:
            figures = answer["figures"]
            row |= {key: answer[key] for key in ("label", "pins")}
            row |= {key: figures[key] for key in ("mass_kg", "governs")}
            for mode in MODES:
                factor = figures[mode] or {}
                row |= {mode: factor.get("factor"), f"{mode}_bar_percent": factor.get("bar_percent")}
        rows.append(row)
    columns = dict.fromkeys(key for row in rows for key in row)
    return csv_text([columns, *([row.get(key) for key in columns] for row in rows)])


def lighten(state: State) -> JsonObject:
    """Search for the lightest rod from a design; each design that is tried is reported as a line."""
    free = variables(search_study(_applied(state)))

    def described(design: Design, done: int = 0, _now: int = 0) -> JsonObject:
        changed = {**state, "design": {**state["design"], **free.dimensions(design.x)}}
        figures = {"mass_kg": design.mass_kg, "margin": design.margin, "governs": design.governing.name}
        return {"state": changed, "count": done, "most": USUAL, **figures}

    found = search(Designs(free, lambda *tried: say(json.dumps(described(*tried)))), free.start, USUAL)
    return described(found.best)


class Worker:
    """Runs one job after another in a process of its own, whose first job is the `opening`."""

    def __init__(self, opening: Callable[..., Any], *arguments: Any) -> None:
        self._opening = partial(opening, *arguments)
        self._process: IsolatedProcess | None = None

    async def run(
        self, job: Callable[..., Any], *arguments: Any, listener: Callable[[str], None] | None = None
    ) -> Any:
        """Return the result of a picklable job, or raise its error.

        The listener is called, in this thread, with the lines that the job reports. Raises `CrashError`,
        `MemoryError`: the process has ended; the next job has another one.
        """
        loop = asyncio.get_running_loop()

        def report(line: str) -> None:
            if listener is not None:
                loop.call_soon_threadsafe(listener, line)

        begins = self._process is None
        # By the main thread, whose end is that of the process.
        process = self._process = self._process or fresh()
        try:
            if begins:
                await asyncio.to_thread(_run, process, self._opening, None)
            return await asyncio.to_thread(_run, process, partial(job, *arguments), report)
        except Exception:
            if begins:  # a worker that is not open cannot work; the next job opens it again
                self.stop()
            raise
        finally:
            if self._process is process and not process.alive:
                self._process = None

    def stop(self) -> None:
        """End the process, also within a job."""
        if self._process is not None:
            self._process.close()
            self._process = None


def _run(process: IsolatedProcess, job: Callable[[], Any], listener: Callable[[str], None] | None) -> Any:
    try:
        return process.run(job, listener=listener)
    except KeyboardInterrupt:  # it was ended by a signal that would interrupt this program
        raise CrashError("it was ended", "SIGTERM") from None
