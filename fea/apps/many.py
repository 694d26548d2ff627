"""`analyse_many`: many studies side by side, each in a process of its own, as the rods of a sweep."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future, as_completed
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from fea.apps.frames import differing, frame
from fea.apps.result import Result, analyse
from fea.apps.sweep.evaluate import figures
from fea.apps.sweep.workers import in_own_process, own_processes, usual_workers
from fea.machine.clock import Clock, duration, progress_shown
from fea.machine.threads import threads
from fea.study.changes import python_words
from fea.study.flags import python_flags
from fea.study.study import Study
from geometry.errors import require

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Results(Sequence[Result | Exception]):
    """Results in the order of their studies: each a `Result`, or the error that its analysis ended with."""

    asked: tuple[str | Path | Study, ...]  #: the studies
    entries: tuple[Result | Exception, ...]

    @property
    def errors(self) -> dict[int, Exception]:
        """The error of each study that has no result, by its place in the list, from 0."""
        return {place: entry for place, entry in enumerate(self.entries) if isinstance(entry, Exception)}

    @property
    def succeeded(self) -> list[Result]:
        """The results alone, without the errors."""
        return [entry for entry in self.entries if isinstance(entry, Result)]

    def to_frame(self) -> "pd.DataFrame":
        """Return a row for each study: in which keys it differs from others, its figures or its error.

        The columns are those of ``sweep.csv``. Raises `ImportError`: pandas is not installed.
        """
        studies = [_study(*pair) for pair in zip(self.asked, self.entries, strict=True)]
        rows: dict[int, dict[str, Any]] = {}
        for place, (keys, entry) in enumerate(zip(differing(studies), self.entries, strict=True)):
            if isinstance(entry, Result):
                rows[place] = {**keys, "rpm": entry.rpm, **figures(entry.summary)}
            else:
                rows[place] = {**keys, "error": str(entry) or type(entry).__name__}
        return frame(rows, "study")

    @overload
    def __getitem__(self, place: int) -> Result | Exception: ...
    @overload
    def __getitem__(self, place: slice) -> "Results": ...
    def __getitem__(self, place: int | slice) -> "Result | Exception | Results":
        if isinstance(place, slice):
            return Results(self.asked[place], self.entries[place])
        return self.entries[place]

    def __len__(self) -> int:
        return len(self.entries)

    def __repr__(self) -> str:
        lines = [f"study {place}: {type(error).__name__}: {error}" for place, error in self.errors.items()]
        counts = {"result": len(self.succeeded), "error": len(lines)}
        head = ", ".join(f"{count} {what}{'s' * (count != 1)}" for what, count in counts.items())
        return "\n".join([f"<{head}>", *lines])


def _study(asked: str | Path | Study, entry: Result | Exception) -> Study | None:
    if isinstance(entry, Result):
        return entry.study
    return asked if isinstance(asked, Study) else None


def analyse_many(
    studies: Iterable[str | Path | Study],
    *,
    workers: int | None = None,
    progress: bool | None = None,
    fields: bool = False,
    **flags: Any,
) -> Results:
    """Analyse many studies side by side and return their results in the same order.

    What ends one analysis is its entry among the results; the others go on.

    Parameters
    ----------
    studies
        Studies, shipped ones by name, or the paths of files; see `Study.with_`.
    workers
        How many are analysed at a time, each by a process with one thread; default: one for each processor
        core.
    progress
        Whether a line counts the finished ones; by default in notebooks alone.
    fields
        Whether results keep their fields, some 30 MB of the shipped rod; without them they hold figures
        (`Result.without_fields`).
    **flags
        For all studies, as of `analyse`.

    Raises
    ------
    InvalidValue
        An argument is unknown or breaks a rule. What is wrong with a study is its entry instead.
    """
    rule, remedy = "is one study", "Give a list of studies, or call analyse."
    one = isinstance(studies, str | Path | Study)
    require(not one, "studies", getattr(studies, "name", studies), rule, remedy)
    require(workers is None or workers >= 1, "workers", workers, "must be at least 1")
    python_flags(flags, writes=False)
    asked, clock, failed = tuple(studies), Clock(), 0
    job = _with_fields if fields else _analysed
    count = max(1, min(len(asked), workers or usual_workers()))
    with (
        progress_shown(progress, f"0 of {len(asked)} studies") as show,
        own_processes(count) as pool,
    ):
        each = [pool.submit(_apart, job, study, flags) for study in asked]
        for done, future in enumerate(as_completed(each), 1):
            failed += isinstance(future.result(), Exception)
            said = f", {failed} of them failed" if failed else ""
            show(f"{done} of {len(asked)} studies{said}, {duration(clock.total)}")
    return Results(asked, tuple(_entry(future) for future in each))


def _entry(future: "Future[Any]") -> Result | Exception:
    found = future.result()
    return Result(**found) if isinstance(found, dict) else found


def _apart(job: Any, study: str | Path | Study, flags: Mapping[str, Any]) -> Any:
    """Do a job in this thread's process; return its error."""
    try:
        return in_own_process(job, study, flags, seconds=None, threads=threads(1))
    except Exception as error:  # noqa: BLE001 - whatever it is, the others go on
        return error


@python_words()
def _analysed(study: str | Path | Study, flags: Mapping[str, Any]) -> Result:
    return analyse(study, progress=False, **flags)


def _with_fields(study: str | Path | Study, flags: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a result is made of, which is pickled with its fields."""
    result = _analysed(study, flags)
    return {each.name: getattr(result, each.name) for each in fields(result)} | {"instants": None}
