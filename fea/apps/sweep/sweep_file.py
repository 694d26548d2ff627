"""A sweep file: a study, what varies in it, and how the designs are chosen."""

import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fea.apps.sweep.base import Base, digest, kind_of, leaves, read_base
from fea.apps.sweep.sampling import Design, Sampling, designs, read_designs
from fea.apps.sweep.variation import Variation, variation, whole
from fea.study.paths import is_file, located, require_size
from fea.study.study import LARGEST_STUDY
from fea.study.tables import checked, unknown_key
from geometry.errors import InvalidValue, require

_KEYS = ("study", "sampling", "samples", "seed", "designs", "frequencies", "set", "vary")
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
    frequencies: int  #: number of natural frequencies to find

    def designs(self) -> list[Design]:
        """Return the values of the varied keys, a design each.

        Raises `InvalidValue`: there are too many, or the file cannot be read.
        """
        if self.sampling is None:
            return read_designs(self.file or Path())
        return designs(self.varied, self.sampling, self.samples, self.seed)

    @cached_property
    def identity(self) -> str:
        """A digest of everything that decides which rods there are, contents of files included."""
        asked = [self.base.raw, sorted((key, repr(value)) for key, value in self.varied.items())]
        counts = [self.sampling, self.samples, self.seed, self.frequencies]
        named = [option for value in self.varied.values() for option in getattr(value, "options", ())]
        paths = [self.base.folder / option for option in named if isinstance(option, str)]
        files = [digest(path) for path in (*self.base.files, *paths, *([self.file] if self.file else []))]
        text = json.dumps([asked, counts, files], default=str, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


def load_sweep(path: Path) -> Sweep:
    """Load a sweep file.

    Raises `InvalidValue`: it cannot be read, is not valid TOML, has an unknown key, or a value breaks a rule.
    """
    name = str(path)
    require(is_file(path), "SWEEP", name, "is not an existing file", "fea sweep --help shows an example.")
    try:
        require_size("SWEEP", path, LARGEST_STUDY)
        raw = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidValue("SWEEP", name, f"cannot be read ({error})") from error
    except (ValueError, RecursionError) as error:
        raise InvalidValue("SWEEP", path.name, f"is not valid TOML: {error}") from error
    return parse_sweep(raw, path.stem, path.resolve().parent)


def parse_sweep(raw: Mapping[str, Any], name: str, folder: Path) -> Sweep:
    """Return a sweep from its tables; relative paths start at `folder`. Errors as `load_sweep`."""
    for key in raw:
        if key not in _KEYS:
            raise unknown_key(f"{name}.toml:", key, _KEYS)
    require("study" in raw, "study", None, "is missing", "Name the study to vary: a shipped one, or a file.")
    fixed = {key: _fixed(key, value) for key, value in leaves("set", raw.get("set", {}))}
    frequencies = whole("frequencies", raw.get("frequencies", 0), 0, _MOST_FREQUENCIES)
    seed = whole("seed", raw.get("seed", 0), 0, _MOST_SEED)
    base = read_base(checked("study", raw["study"], str), folder, fixed)
    if "designs" in raw:
        for key in ("vary", "sampling", "samples", "seed"):
            require(
                key not in raw, key, raw.get(key), "cannot be combined with designs", "Remove one of them."
            )
        file = located("designs", checked("designs", raw["designs"], str), folder)
        return Sweep(name, base, {}, None, None, 0, file, frequencies)
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
    return Sweep(name, base, varied, sampling, samples, seed, None, frequencies)


def _fixed(key: str, value: object) -> Any:
    checked(f"set.{key}", value, kind_of(key, "set"))
    return value


def _samples(samples: object, *, grid: bool) -> int | None:
    if grid:
        rule = "has no effect on a grid, whose ranges have steps"
        require(samples is None, "samples", samples, rule, "Leave it out, or choose another sampling.")
        return None
    require(samples is not None, "samples", None, "is missing", "Say how many designs are wanted.")
    return whole("samples", samples, 1, 10**6)
