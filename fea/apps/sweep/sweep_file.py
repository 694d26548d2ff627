"""A sweep file: a study, the keys that vary in it, how designs are chosen, and the rows of the table."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from fea.apps.sweep.sampling import (
    Design,
    Sampling,
    Variation,
    designs,
    kind_of,
    leaves,
    read_designs,
    variation,
    whole,
)
from fea.base.shipped import TomlTable, shipped_toml
from fea.output.json_file import JsonObject
from fea.study.changes import with_own_units
from fea.study.files import is_file, located, read_toml
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study, load_study, shipped_studies, study_of_tables
from fea.study.tables import checked, unknown_key
from geometry.errors import InvalidValue, require

_KEYS = ("study", "sampling", "samples", "seed", "designs", "frequencies", "limits", "set", "vary")
_NEEDED = ("dask", "distributed", "pyarrow", "SALib")
_MOST_FREQUENCIES = 50
_MOST_SEED = 2**32


class SweepOutputs(NamedTuple):
    """Results that a sweep computes beside the figures of a run."""

    frequencies: int = 0  #: number of natural frequencies
    limits: bool = False  #: the largest speed and peak pressure, as by `fea limits`


@dataclass(frozen=True)
class BaseStudy:
    """Tables of the study that all designs share, and the files they name; paths start at `folder`."""

    name: str
    raw: Mapping[str, Any]
    folder: Path
    files: tuple[Path, ...] = ()

    def study(self, design: Mapping[str, Any], speeds: Sequence[float | None] = ()) -> Study:
        """Return the study with a design's values, at some speeds, rpm. `InvalidValue`: a broken rule."""
        study = study_of_tables(_changed(self.raw, design), self.name, self.folder)
        study.require_plausible()
        rpm = tuple(speed for speed in speeds if speed is not None)
        return study if not rpm else replace(study, speed=SpeedTable(rpm[0] if len(rpm) == 1 else rpm))

    def require_presets_alone(self, keys: Mapping[str, Any]) -> None:
        """Refuse to change a preset beside keys that override each of them. Raises `InvalidValue`."""
        for key in keys:
            name, _, last = key.rpartition(".")
            table: Any = self.raw
            for step in name.split("."):
                table = table.get(step, {}) if isinstance(table, Mapping) else {}
            if last == "preset" and isinstance(table, Mapping):
                others = [each for each in sorted(table) if not isinstance(table[each], Mapping)]
                given = ", ".join(each for each in others if each != "preset")
                rule = f"cannot be changed: [{name}] of the study gives {given}, which override it"
                require(not given, key, None, rule, "Remove those keys from the study.")


def read_base(source: str, folder: Path, fixed: Mapping[str, Any]) -> BaseStudy:
    """Read the study of a sweep: a shipped one, or a file (TOML, CAD or mesh) relative to the sweep's folder.

    `fixed` holds values by key that all designs share. Raises `InvalidValue`: it is not a study, or a fixed
    value breaks a rule.
    """
    shipped = source in shipped_studies()
    place = source if shipped else str(folder / source)
    study = load_study(place)
    if shipped:
        raw: Mapping[str, Any] = shipped_toml(f"studies/{source}.toml")
    elif Path(place).suffix.lower() == ".toml":
        raw = read_toml("study", Path(place))
    else:
        raw = {"rod": study.rod.as_dict()}
    tables = with_own_units(raw)
    tables.pop("output", None)
    base = BaseStudy(study.name, tables, study.folder)
    base.require_presets_alone(fixed)
    base = replace(base, raw=_changed(tables, fixed))
    return replace(base, files=tuple(files_of(base.study({}).as_dict())))


def _changed(raw: Mapping[str, Any], design: Mapping[str, Any]) -> TomlTable:
    """A study's tables with other values for some keys."""
    tables = deepcopy(dict(raw))
    for key, value in design.items():
        *above, name = key.split(".")
        table = tables
        for step in above:
            if isinstance(table.get(step), str):  # an engine by its name
                table[step] = {"preset": table[step]}
            table = table.setdefault(step, {})
        table[name] = value
    return tables


def files_of(tables: Mapping[str, Any]) -> list[Path]:
    """Return the files that the tables of a resolved study name: its paths are absolute."""
    paths = []
    for value in tables.values():
        if isinstance(value, Mapping):
            paths += files_of(value)
        elif isinstance(value, str) and Path(value).is_absolute():
            paths.append(Path(value))
    return paths


def digest(path: Path) -> str:
    """Return a digest of a file's contents; empty where there is no such file."""
    if not is_file(path):
        return ""
    status = path.stat()
    return _file_digest(path, status.st_mtime_ns, status.st_size)


@cache
def _file_digest(path: Path, _changed_at: int, _size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _digest(*values: Any) -> str:
    text = json.dumps(values, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Sweep:
    """The contents of a sweep file."""

    name: str
    base: BaseStudy  #: with the values of [set]
    varied: Mapping[str, Variation]  #: by key; empty where the designs come from `file`
    sampling: Sampling | None  #: None: the designs come from `file`
    samples: int | None  #: None for a grid
    seed: int
    file: Path | None  #: CSV file of the designs
    outputs: SweepOutputs

    def designs(self) -> list[Design]:
        """Return the varied values by design. Raises `InvalidValue`: too many, or an unreadable file."""
        if self.sampling is None:
            return read_designs(self.file or Path())
        return designs(self.varied, self.sampling, self.samples, self.seed)

    @cached_property
    def identity(self) -> str:
        """A digest of everything that decides which rods there are, contents of files included."""
        asked = [self.base.raw, sorted((key, repr(value)) for key, value in self.varied.items())]
        counts = [self.sampling, self.samples, self.seed, self.outputs]
        options = [option for value in self.varied.values() for option in getattr(value, "options", ())]
        paths = [self.base.folder / option for option in options if isinstance(option, str)]
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
    outputs = SweepOutputs(frequencies, checked("limits", raw.get("limits", False), bool))
    seed = whole("seed", raw.get("seed", 0), 0, _MOST_SEED)
    base = read_base(checked("study", raw["study"], str), folder, fixed)
    if "designs" in raw:
        rule, remedy = "cannot be combined with designs", "Remove one of them."
        for key in ("vary", "sampling", "samples", "seed"):
            require(key not in raw, key, raw.get(key), rule, remedy)
        file = located("designs", checked("designs", raw["designs"], str), folder)
        return Sweep(name, base, {}, None, None, 0, file, outputs)
    sampling = checked("sampling", raw.get("sampling", "grid"), Sampling)
    grid = sampling is Sampling.GRID
    varied = {
        key: variation(key, value, kind_of(key, "vary"), grid=grid)
        for key, value in leaves("vary", raw.get("vary", {}))
    }
    rule, remedy = "is missing, so nothing varies", "Name keys in [vary], or designs."
    require(len(varied) > 0, "vary", None, rule, remedy)
    for key in varied:
        require(key not in fixed, f"set.{key}", fixed.get(key), "is varied as well", "Remove one of them.")
    samples = raw.get("samples")
    if grid:
        rule = "has no effect on a grid, whose ranges have steps"
        require(samples is None, "samples", samples, rule, "Leave it out, or choose another sampling.")
    else:
        require(samples is not None, "samples", None, "is missing", "Give the number of designs.")
        samples = whole("samples", samples, 1, 10**6)
    return Sweep(name, base, varied, sampling, samples, seed, None, outputs)


class RowState(StrEnum):
    """Progress of a row."""

    PENDING = "pending"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True)
class SweepRow:
    """A row of the table: a design (the values of the varied keys) at one of its speeds."""

    number: int
    sample: int  #: number of the design
    design: JsonObject
    rpm: float | None  #: None where forces are given, or where the design is refused
    state: RowState = RowState.PENDING
    reason: str = ""  #: of the failure; a design that breaks a rule of the study has failed already
    figures: JsonObject = field(default_factory=dict)
    job: str = ""  #: digest of the rod to compute, with all its speeds
    key: str = ""  #: digest of the rod at this speed: equal rows are computed once


def rows(sweep: Sweep) -> list[SweepRow]:
    """Return the rows of a sweep.

    One mesh and one factorisation serve all speeds of a rod: of the study's list of speeds, and of designs
    that differ in speed alone. Raises `InvalidValue`: see `Sweep.designs`.
    """
    every = sweep.designs()
    if every:
        sweep.base.require_presets_alone(every[0])
    speeds: dict[str, list[float | None]] = {}
    planned: list[SweepRow] = []
    for sample, design in enumerate(every):
        for rpm, rod, refused in _speeds(sweep, design):
            state = RowState.FAILED if refused else RowState.PENDING
            planned.append(SweepRow(len(planned), sample, design, rpm, state, refused, job=rod))
            if rpm not in speeds.setdefault(rod, []):
                speeds[rod].append(rpm)
    jobs = {rod: _digest(rod, sorted(speed or 0.0 for speed in each)) for rod, each in speeds.items()}
    return [replace(row, job=jobs[row.job], key=_digest(jobs[row.job], row.rpm)) for row in planned]


def _speeds(sweep: Sweep, design: Design) -> Iterator[tuple[float | None, str, str]]:
    """Each speed of a design, the digest of its rod, and why it is refused."""
    try:
        study = sweep.base.study(design)
        study.require_loading()
        speeds = study.speeds()
    except InvalidValue as error:
        yield None, _digest("refused", sorted(design.items())), str(error)
        return
    tables = {name: table for name, table in study.as_dict().items() if name not in ("speed", "output")}
    rod = _digest(tables, [digest(path) for path in files_of(tables)], sweep.outputs)
    for rpm in speeds:
        yield rpm, rod, ""


def study_text(sweep: Sweep, number: int) -> str:
    """Return the study of a row for ``fea run``. Raises `InvalidValue`: no such row, or a broken rule."""
    planned = rows(sweep)
    require(0 <= number < len(planned), "--study", number, f"must be a row, 0 to {len(planned) - 1}")
    row = planned[number]
    return sweep.base.study(row.design, [row.rpm]).text()


def require_extra() -> None:
    """Refuse to begin without them; raises `ImportError`: one is missing (exit code 7)."""
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        packages = " ".join({"dask": "distributed"}.get(name, name) for name in missing)
        raise ImportError(f"fea sweep needs {', '.join(missing)}, not installed here: pip install {packages}")
