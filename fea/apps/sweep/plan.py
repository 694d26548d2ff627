"""The rows of a sweep's table, and the rods that must be computed for them."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fea.apps.sweep.base import digest, files_of
from fea.apps.sweep.sampling import Design
from fea.apps.sweep.sweep_file import Sweep
from geometry.errors import InvalidValue, require

SPEED = "speed.rpm"


@dataclass(frozen=True, kw_only=True)
class PlannedRow:
    """A row of the table: a design (the values of the varied keys) at one of its speeds."""

    number: int
    sample: int  #: number of the design
    design: Mapping[str, Any]
    rpm: float | None  #: None where forces are given, or where the design is refused
    job: str  #: digest of the rod to compute, with all its speeds
    key: str  #: digest of the rod at this speed: equal rows are computed once
    refused: str = ""  #: why the design is no study; empty where it is one


def rows(sweep: Sweep) -> list[PlannedRow]:
    """Return the rows of a sweep.

    One mesh and one factorisation serve all speeds of a rod: of the study's list of speeds, and of designs
    that differ in speed alone. Raises `InvalidValue`: see `Sweep.designs`.
    """
    designs = sweep.designs()
    if designs:
        sweep.base.require_presets_alone(designs[0])
    speeds: dict[str, list[float | None]] = {}
    planned: list[tuple[int, Design, float | None, str, str]] = []
    for sample, design in enumerate(designs):
        for rpm, rod, refused in _speeds(sweep, design):
            planned.append((sample, design, rpm, rod, refused))
            if rpm not in speeds.setdefault(rod, []):
                speeds[rod].append(rpm)
    jobs = {rod: _digest(rod, sorted(speed or 0.0 for speed in own)) for rod, own in speeds.items()}
    return [
        PlannedRow(
            number=number,
            sample=sample,
            design=design,
            rpm=rpm,
            job=jobs[rod],
            key=_digest(jobs[rod], rpm),
            refused=refused,
        )
        for number, (sample, design, rpm, rod, refused) in enumerate(planned)
    ]


def study_text(sweep: Sweep, number: int) -> str:
    """Return the study of a row as a file that ``fea run`` takes.

    Raises `InvalidValue`: there is no such row, or its design breaks a rule.
    """
    planned = rows(sweep)
    require(0 <= number < len(planned), "--study", number, f"must be a row, 0 to {len(planned) - 1}")
    row = planned[number]
    return sweep.base.study(row.design, [row.rpm]).text()


def _speeds(sweep: Sweep, design: Design) -> Iterator[tuple[float | None, str, str]]:
    """Return speed, digest of the rod whatever its speed, and what is wrong, of each row of a design."""
    try:
        study = sweep.base.study(design)
        study.require_loading()
        speeds = study.speeds()
    except InvalidValue as error:
        yield None, _digest("refused", sorted(design.items())), str(error)
        return
    tables = {name: table for name, table in study.as_dict().items() if name not in ("speed", "output")}
    files = [digest(path) for path in files_of(tables)]
    rod = _digest(tables, files, sweep.frequencies)
    for rpm in speeds:
        yield rpm, rod, ""


def _digest(*values: Any) -> str:
    text = json.dumps(values, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]
