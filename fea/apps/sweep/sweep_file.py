"""A sweep file: a study, what varies in it, and how the designs are chosen."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fea.analysis.figures import Figures
from fea.apps.sweep.base import Base, Extras, digest, files_of, kind_of, leaves, read_base
from fea.apps.sweep.sampling import Design, Sampling, Variation, designs, read_designs, variation, whole
from fea.study.files import is_file, located, read_toml
from fea.study.tables import checked, unknown_key
from geometry.errors import InvalidValue, require

_KEYS = ("study", "sampling", "samples", "seed", "designs", "frequencies", "limits", "set", "vary")
_MOST_FREQUENCIES = 50
_MOST_SEED = 2**32


@dataclass(frozen=True)
class Sweep:
    """What is asked of a sweep."""

    name: str
    base: Base  #: the study, with what [set] changes in all designs
    varied: Mapping[str, Variation]  #: what varies, by key; empty where the designs come from a file
    #: sampling, samples: how they are chosen (None: from `file`), and their number (None for a grid)
    sampling: Sampling | None
    samples: int | None
    seed: int
    file: Path | None  #: CSV file of the designs
    extras: Extras

    def designs(self) -> list[Design]:
        """Return the varied values by design. Raises `InvalidValue`: too many, or an unreadable file."""
        if self.sampling is None:
            return read_designs(self.file or Path())
        return designs(self.varied, self.sampling, self.samples, self.seed)

    @cached_property
    def identity(self) -> str:
        """A digest of everything that decides which rods there are, contents of files included."""
        asked = [self.base.raw, sorted((key, repr(value)) for key, value in self.varied.items())]
        counts = [self.sampling, self.samples, self.seed, self.extras]
        named = [option for value in self.varied.values() for option in getattr(value, "options", ())]
        paths = [self.base.folder / option for option in named if isinstance(option, str)]
        files = [digest(path) for path in (*self.base.files, *paths, *([self.file] if self.file else []))]
        return _digest(asked, counts, files)


def load_sweep(path: Path) -> Sweep:
    """Load a sweep file. Raises `InvalidValue`: unreadable, no valid TOML, unknown key, or a broken rule."""
    name = str(path)
    require(is_file(path), "SWEEP", name, "is not an existing file", "fea sweep --help shows an example.")
    return parse_sweep(read_toml("SWEEP", path), path.stem, path.resolve().parent)


def parse_sweep(raw: Mapping[str, Any], name: str, folder: Path) -> Sweep:
    """Return a sweep from its tables; relative paths start at `folder`. Errors as `load_sweep`."""
    for key in raw:
        if key not in _KEYS:
            raise unknown_key(f"{name}.toml:", key, _KEYS)
    require("study" in raw, "study", None, "is missing", "Name the study to vary: a shipped one, or a file.")
    fixed = dict(leaves("set", raw.get("set", {})))
    for key, value in fixed.items():
        checked(f"set.{key}", value, kind_of(key, "set"))
    frequencies = whole("frequencies", raw.get("frequencies", 0), 0, _MOST_FREQUENCIES)
    extras = Extras(frequencies, checked("limits", raw.get("limits", False), bool))
    seed = whole("seed", raw.get("seed", 0), 0, _MOST_SEED)
    base = read_base(checked("study", raw["study"], str), folder, fixed)
    if "designs" in raw:
        for key in ("vary", "sampling", "samples", "seed"):
            require(
                key not in raw, key, raw.get(key), "cannot be combined with designs", "Remove one of them."
            )
        file = located("designs", checked("designs", raw["designs"], str), folder)
        return Sweep(name, base, {}, None, None, 0, file, extras)
    sampling = checked("sampling", raw.get("sampling", "grid"), Sampling)
    grid = sampling is Sampling.GRID
    varied = {
        key: variation(key, value, kind_of(key, "vary"), grid=grid)
        for key, value in leaves("vary", raw.get("vary", {}))
    }
    require(
        len(varied) > 0, "vary", None, "is missing, so nothing varies", "Name keys in [vary], or designs."
    )
    for key in varied:
        require(key not in fixed, f"set.{key}", fixed.get(key), "is varied as well", "Remove one of them.")
    samples = _samples(raw.get("samples"), grid=grid)
    return Sweep(name, base, varied, sampling, samples, seed, None, extras)


def _samples(samples: object, *, grid: bool) -> int | None:
    if grid:
        rule = "has no effect on a grid, whose ranges have steps"
        require(samples is None, "samples", samples, rule, "Leave it out, or choose another sampling.")
        return None
    require(samples is not None, "samples", None, "is missing", "Give the number of designs.")
    return whole("samples", samples, 1, 10**6)


SPEED = "speed.rpm"


class PlannedRow(Figures):
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
    """Return the study of a row for ``fea run``. Raises `InvalidValue`: no such row, or a broken rule."""
    planned = rows(sweep)
    require(0 <= number < len(planned), "--study", number, f"must be a row, 0 to {len(planned) - 1}")
    row = planned[number]
    return sweep.base.study(row.design, [row.rpm]).text()


def _speeds(sweep: Sweep, design: Design) -> Iterator[tuple[float | None, str, str]]:
    try:
        study = sweep.base.study(design)
        study.require_loading()
        speeds = study.speeds()
    except InvalidValue as error:
        yield None, _digest("refused", sorted(design.items())), str(error)
        return
    tables = {name: table for name, table in study.as_dict().items() if name not in ("speed", "output")}
    files = [digest(path) for path in files_of(tables)]
    rod = _digest(tables, files, sweep.extras)
    for rpm in speeds:
        yield rpm, rod, ""


def _digest(*values: Any) -> str:
    text = json.dumps(values, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]
