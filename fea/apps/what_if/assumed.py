"""What assumptions of a run change that need a solution: each is varied alone."""

import re
from collections.abc import Iterator

from fea.analysis.figures import Summary
from fea.analysis.result import Change
from fea.apps.what_if.draft import Draft
from fea.base.note import NoteKind
from fea.base.shipped import shipped_toml
from fea.base.units import BAR
from fea.study.proportions import assumed_at
from fea.study.study import Study
from geometry.dimensions import key as key_of

_VARIED = shipped_toml("study/varied.toml")
_KEY = re.compile(r"^assumed (\w+) = |\((\w+\.\w+)\)")
_VALUE = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")
_MOST = 4  # solutions
_THINNER = 0.95  # of dimensions that are assumed


def assumed_changes(draft: Draft, summary: Summary, place: str) -> Iterator[Change]:
    """Yield what assumptions change: the least factor of the run, and what it becomes."""
    now = min(draft.run.values())
    for words, study in list(_varied(draft, summary, place))[:_MOST]:
        yield Change(words, now, min(draft.factors(study).values()))


def _varied(draft: Draft, summary: Summary, place: str) -> Iterator[tuple[str, Study]]:
    study = draft.study
    peaks = None if study.engine is None else study.engine.computed_peaks(summary.rod.length_mm)
    if peaks is not None:
        low, high = (peak / BAR for peak in peaks)
        late = {"peak_pressure_bar": low}
        yield (
            f"peak pressure {high:.0f} bar, of early combustion; {low:.0f} bar of late",
            study.with_(engine=late),
        )
    if names := assumed_at(study.rod.dimensions, place):
        sizes = {key_of(name): _THINNER * getattr(study.rod.dimensions, name) for name in names}
        yield "dimensions there by assumed proportions, 5 % less", study.with_rod(**sizes)
    values = dict(_assumed_values(summary))
    for key, varied in _VARIED.items():
        if key in values and not (draft.alone and key.startswith("assembly.")):
            table, _, name = f"engine.{key}".rpartition(".")
            other = {name: varied["share"] * values[key]}
            yield varied["words"], study.with_(**{table.rpartition(".")[2]: other})


def _assumed_values(summary: Summary) -> Iterator[tuple[str, float]]:
    """Yield the keys of what a run assumes, and the values."""
    for note in summary.notes:
        found, value = _KEY.search(note.text), _VALUE.search(note.text)
        if note.kind is NoteKind.ASSUMPTION and found and value:
            yield found[1] or found[2], float(value[0])
