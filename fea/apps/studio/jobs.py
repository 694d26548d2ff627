"""What the two processes of `fea studio` do for its server: each function is a job of one of them."""

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
from fea.apps.studio.frame import MODES, Frame
from fea.apps.studio.operation import Operation, applied, controls
from fea.apps.studio.session import State
from fea.machine.isolated import CrashError, IsolatedProcess, fresh, say
from fea.machine.system import replaced
from fea.output.json_file import JsonObject
from fea.output.pictures.shown import VON_MISES
from fea.output.report.scene import case_fields
from fea.output.text import csv_text, write_text
from fea.study.study import Study
from geometry.cad.formats import step_file
from geometry.session import session

MODEL = "fea.apps.studio.live_rod"
# What can be written at once, and what takes a process of its own.
QUICK, SLOW = ("study", "table"), ("step", "report")
# Of the end of the legend: a peak above this share keeps it, so that colours mean the same while one drags.
_KEEPS_LEGEND = 0.6


class _Inside:
    """In a worker: what it computes with."""

    study: Study
    model: Any
    live: Any = None
    steps: Iterator[Any] = iter(())
    mesh: tuple[int, int, bytes] = (-1, 0, b"")  # number of the base, and what is packed of its triangles


class Answer(NamedTuple):
    """A frame for the page: what is told of it, places and values of its nodes, and its triangles."""

    header: JsonObject
    numbers: bytes
    triangles: bytes


def open_worker(study: Study, model: str) -> None:
    """Begin: the model is a module with `LiveRod` and `fresh`."""
    _Inside.study, _Inside.model = study, resolve_name(model)


def open_live(study: Study, model: str) -> None:
    """Begin with a rod that answers at once, which takes seconds."""
    open_worker(study, model)
    _Inside.live = _Inside.model.LiveRod(study)


def describe() -> JsonObject:
    """Return what the page needs to lay itself out."""
    study, live = _Inside.study, _Inside.live
    return {
        "title": study.name,
        "dimensions": [_plain(each) for each in live.dimensions],
        "ranges": ranges({"design": live.base_design}),
        "controls": [_plain(control) for control in controls(study)],
        "required": study.analysis.min_safety or 1.0,
    }


def ranges(state: State) -> JsonObject:
    """Return how far each dimension can go, and why it ends there, by its name."""
    return {name: _plain(each) for name, each in _Inside.live.ranges(dict(state["design"])).items()}


def frame(serial: int, state: State, top: float, field: str) -> Answer:
    """Return what is known of a design at once; `top` is the end of the legend before."""
    return _answer(serial, state, top, _Inside.live.frame(dict(state["design"]), _operation(state), field))


def begin(kind: str, state: State, what: str) -> None:
    """Begin what takes several steps: "touch" a dimension, solve "exact" with a field, or "cross"."""
    live, design, operation = _Inside.live, dict(state["design"]), _operation(state)
    if kind == "cross":
        _Inside.steps = live.cross(design, operation)
    elif kind == "touch":
        _Inside.steps = live.touch(what, design, operation)
    else:
        _Inside.steps = live.exact(design, operation, what)


def step(serial: int, state: State, top: float) -> Answer | float | None:
    """Take the next step; return a frame, the progress of anchors, or None at the end."""
    found = next(_Inside.steps, None)
    return _answer(serial, state, top, found) if isinstance(found, Frame) else found


def converge(serial: int, state: State, top: float) -> Answer:
    """Solve a design on a mesh of its own, refined, with the pins that its study asks for."""
    return _answer(serial, state, top, _Inside.model.fresh(_applied(state)))


def _operation(state: State) -> Operation:
    return _operated(tuple(state["operation"].items()))


@lru_cache(maxsize=8)
def _operated(values: tuple[tuple[str, Any], ...]) -> Operation:
    return Operation.of(_Inside.study).changed(dict(values))


def _applied(state: State) -> Study:
    return applied(_Inside.study, dict(state["design"]), _operation(state))


def _plain(value: Any) -> JsonObject:
    """A dataclass as JSON has it: what is not finite is None."""
    text = json.dumps(value, default=lambda own: float(own) if isinstance(own, np.generic) else vars(own))
    plain: JsonObject = json.loads(text, parse_constant=lambda _: None)
    return plain


def _answer(serial: int, state: State, top: float, found: Frame) -> Answer:
    header = {"kind": "frame", "serial": serial, "state": state, "operation": found.operation.values}
    header |= {"label": str(found.label), "pins": found.pins, "new_mesh": found.new_mesh, "figures": None}
    header |= {"corrected": found.corrected, "one_piece": found.one_piece}
    if found.points is None or found.values is None or found.figures is None:
        return Answer(header, b"", b"")
    checks = found.figures.checks or {}
    failed = [name.replace("_", " ") for name, check in checks.items() if not check.passed]
    if found.triangles is not None or found.base != _Inside.mesh[0]:
        triangles = _Inside.live.triangles if found.triangles is None else found.triangles
        packed = triangles.astype("<u4").tobytes()
        _Inside.mesh = (found.base, zlib.crc32(packed), packed)
    header["figures"] = _plain(found.figures) | {"governs": found.figures.governs, "failed": failed}
    peak = max(case.peak_MPa for case in found.figures.cases)
    largest = {VON_MISES: np.array([np.nanmax(found.values)])}
    legend = case_fields(largest, top if _KEEPS_LEGEND * top <= peak <= top else peak)[0]
    header |= {"mesh": _Inside.mesh[1], "nodes": len(found.points), "field": legend}
    numbers = b"".join(np.ascontiguousarray(each, "<f4").data for each in (found.points, found.values))
    return Answer(header, numbers, _Inside.mesh[2])


def export(what: str, state: State, variants: Mapping[str, Any], folder: str, name: str) -> JsonObject:
    """Write a study, solid, report or table into a folder; return its path, and a text to offer as a copy."""
    study, suffix = _applied(state), {"study": ".toml", "table": ".csv", "step": ".step", "report": ""}[what]
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
    """Search the lightest rod from a design; the designs that are tried are said as they come."""
    free = variables(search_study(_applied(state)))

    def told(design: Design, done: int = 0, _now: int = 0) -> JsonObject:
        changed = {**state, "design": {**state["design"], **free.dimensions(design.x)}}
        figures = {"mass_kg": design.mass_kg, "margin": design.margin, "governs": design.governing.name}
        return {"state": changed, "count": done, "most": USUAL, **figures}

    found = search(Designs(free, lambda *tried: say(json.dumps(told(*tried)))), free.start, USUAL)
    return told(found.best)


class Worker:
    """Does one job after another in a process of its own, whose first job is the `opening`."""

    def __init__(self, opening: Callable[..., Any], *arguments: Any) -> None:
        self._opening = partial(opening, *arguments)
        self._process: IsolatedProcess | None = None

    async def run(
        self, job: Callable[..., Any], *arguments: Any, listener: Callable[[str], None] | None = None
    ) -> Any:
        """Return the result of a picklable job, or raise its error.

        The listener is called, in this thread, with the lines that the job says. Raises `CrashError`,
        `MemoryError`: the process has ended; the next job has another one.
        """
        loop = asyncio.get_running_loop()

        def heard(line: str) -> None:
            if listener is not None:
                loop.call_soon_threadsafe(listener, line)

        begins = self._process is None
        # By the main thread, whose end is that of the process.
        process = self._process = self._process or fresh()
        try:
            if begins:
                await asyncio.to_thread(_waited, process, self._opening, None)
            return await asyncio.to_thread(_waited, process, partial(job, *arguments), heard)
        except Exception:
            if begins:  # what was not opened cannot work; the next job opens it again
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


def _waited(process: IsolatedProcess, job: Callable[[], Any], listener: Callable[[str], None] | None) -> Any:
    try:
        return process.run(job, listener=listener)
    except KeyboardInterrupt:  # it was ended by a signal that would interrupt this program
        raise CrashError("it was ended", "SIGTERM") from None
