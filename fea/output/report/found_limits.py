"""The limits of speed and boost of a run's rod, where `fea limits` has written them beside the run."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from fea.base.shipped import shipped_toml
from fea.output.folder import SUMMARY
from fea.output.json_file import STUDY, JsonObject
from fea.output.units import quantity
from fea.study.study import Study, load_study
from geometry.errors import InvalidValue

_ENDS = shipped_toml("base/failures.toml")["limits"]
_SCHEMA = "fea/limits/"
# Tables of a study on which its limits depend, and options that flags change as well.
_SAME = ("rod", "material", "engine", "assembly", "contact")
_OPTIONS = ("pressure", "min_safety")


class FoundLimit(NamedTuple):
    """A limit: its value, and what ends it, in words."""

    value: str
    ending: str


def found_limits(run_folder: Path, study: Study) -> dict[str, FoundLimit]:
    """Return the limits of ``speed`` and ``boost`` of a study, see `limits_beside`; none without them."""
    figures = limits_beside(run_folder, study)
    return {} if figures is None else _read(figures)


def limits_beside(run_folder: Path, study: Study) -> JsonObject | None:
    """Return what `fea limits` wrote of a study into a folder beside that of its run.

    A folder is taken whose name has ``limits`` in it and whose study has the same rod, material, engine and
    bolts. Of several the newest counts.
    """
    own = study.as_dict()
    for folder in sorted(_folders(run_folder), key=lambda folder: -(folder / SUMMARY).stat().st_mtime):
        with suppress(OSError, ValueError, InvalidValue):
            figures = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
            other = load_study(folder / STUDY).as_dict()
            if str(figures.get("schema")).startswith(_SCHEMA) and _alike(own, other):
                return dict(figures)
    return None


def answers_for(source: str, study: Study, rpm: float | None) -> bool:
    """Whether a study by its name or file is that of a run at a speed, rpm, but for its mesh and files."""
    with suppress(InvalidValue, OSError):
        other = load_study(source)
        own, options = study.as_dict(), (study.analysis, other.analysis)
        asked = [[getattr(each, name) for name in _OPTIONS] for each in options]
        return _alike(own, other.as_dict()) and asked[0] == asked[1] and rpm in other.speeds()
    return False


def _folders(run_folder: Path) -> Iterator[Path]:
    # A run at one of several speeds lies a folder deeper.
    for above in (run_folder.absolute().parent, run_folder.absolute().parent.parent):
        with suppress(OSError):
            yield from (path.parent for path in above.glob(f"*limits*/{SUMMARY}"))


def _alike(own: JsonObject, other: JsonObject) -> bool:
    return all(own.get(name) == other.get(name) for name in _SAME)


def _read(figures: JsonObject) -> dict[str, FoundLimit]:
    speed, pressed = figures["largest_rpm"], figures["largest_peak_pressure_bar"]
    found = {}
    if speed is not None:
        bar = "" if speed["bar"] is None else f" ± {max(10 * round(speed['bar'] / 10), 10):.0f}"
        found["speed"] = FoundLimit(f"{10 * round(speed['value'] / 10):.0f}{bar} rpm", _ending(speed))
    if pressed is not None:
        boost, peak = pressed["boost_bar"], quantity(pressed["value"], ".0f", "bar")
        value = f"{quantity(boost, '.2g', 'bar')} of boost" if boost > 0 else "no boost"
        found["boost"] = FoundLimit(value, f"{peak} peak at {pressed['rpm']:.0f} rpm. {_ending(pressed)}")
    return found


def _ending(limit: JsonObject) -> str:
    return f"There {_ENDS[limit['mode']].format(place='the ' + limit['place'])}"
