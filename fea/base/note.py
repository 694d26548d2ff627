"""Notes for the reader beside the figures; terminal, report and JSON show the same in the same order."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import partial


class NoteKind(StrEnum):
    """Consequence of a note for the answer: notes are shown in this order, that of consequence."""

    DOUBT = "doubt"  # figures are not to be relied on as they stand
    WARNING = "warning"  # limits how far the figures can be used
    ASSUMPTION = "assumption"  # a value that the study does not give
    REMARK = "remark"  # what was done; no figure is in doubt
    OMISSION = "omission"  # the topic is left out of the analysis, and the text says why


# Topics of doubts of what was read, which stand below the headline in full: a rod that carries others does
# not `survive`.
TRACE, MODEL, OTHER_RODS = "pressure trace", "geometry", "other rods"
HEADING = {TRACE, MODEL, OTHER_RODS}
UNITS = "units"  # topic of notes on values that engines do not have
SINGULAR = "singular places"  # topic of notes on places where the exact stress is infinite
CANNOT_GOVERN = "cannot govern"  # topic of the note on load cases that are known less well than the others
_CONSEQUENCE = {kind: number for number, kind in enumerate(NoteKind)}


@dataclass(frozen=True)
class Note:
    """A note; the topic may be empty."""

    kind: NoteKind
    topic: str
    text: str

    def __str__(self) -> str:
        return f"{self.topic}: {self.text}" if self.topic else self.text


def _note(kind: NoteKind, text: str, topic: str = "") -> Note:
    return Note(kind, topic, text)


# Return a note of their kind: ``doubt("the mesh is coarse")``, ``assumption("a steel", "material")``.
doubt, warning = partial(_note, NoteKind.DOUBT), partial(_note, NoteKind.WARNING)
assumption, remark = partial(_note, NoteKind.ASSUMPTION), partial(_note, NoteKind.REMARK)


def assumptions(topic: str, values: Iterable[str]) -> tuple[Note, ...]:
    """Return a note on each value of a topic that the study does not give."""
    return tuple(assumption(f"assumed {value}", topic) for value in values)


class Assumed(list[str]):
    """Assumed values that a study does not give, in words."""

    def or_else(self, given: float | None, default: float, text: str) -> float:
        """Return what is given, or the default, which is noted; the text has a place for it."""
        if given is None:
            self.append(text.format(default))
        return default if given is None else given


def omission(what: str, why: str) -> Note:
    """Return a note on what is left out of the analysis."""
    return Note(NoteKind.OMISSION, what, why)


def by_consequence(notes: Iterable[Note]) -> tuple[tuple[Note, ...], tuple[Note, ...]]:
    """Return the notes, each once and the gravest first, and apart from them what is left out."""
    ordered = sorted(dict.fromkeys(notes), key=lambda note: _CONSEQUENCE[note.kind])
    left_out = tuple(note for note in ordered if note.kind is NoteKind.OMISSION)
    return tuple(ordered[: len(ordered) - len(left_out)]), left_out
