"""What a reader must know beside the figures; terminal, report and JSON show the same in the same order."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


class NoteKind(StrEnum):
    """What a note is about."""

    ASSUMPTION = "assumption"  # a value that the study does not give
    WARNING = "warning"  # limits how far the figures can be used
    OMISSION = "omission"  # the topic is left out of the analysis, and the text says why


@dataclass(frozen=True)
class Note:
    """A note; the topic may be empty."""

    kind: NoteKind
    topic: str
    text: str

    def __str__(self) -> str:
        return f"{self.topic}: {self.text}" if self.topic else self.text


def assumption(text: str, topic: str = "") -> Note:
    """Return a note on a value that the study does not give."""
    return Note(NoteKind.ASSUMPTION, topic, text)


def assumptions(topic: str, values: Iterable[str]) -> tuple[Note, ...]:
    """Return one note on all values of a topic that the study does not give; none without values."""
    listed = ", ".join(values)
    return (assumption(f"assumed are {listed}", topic),) if listed else ()


def warning(text: str, topic: str = "") -> Note:
    """Return a note that limits how far the figures can be used."""
    return Note(NoteKind.WARNING, topic, text)


def warnings(topic: str, texts: Iterable[str]) -> tuple[Note, ...]:
    """Return a warning of a topic for each text."""
    return tuple(warning(text, topic) for text in texts)


def omission(what: str, why: str) -> Note:
    """Return a note on what is left out of the analysis."""
    return Note(NoteKind.OMISSION, what, why)


def omissions(notes: Iterable[Note]) -> tuple[Note, ...]:
    """Return what is left out of the analysis."""
    return tuple(note for note in notes if note.kind is NoteKind.OMISSION)


def remarks(notes: Iterable[Note]) -> tuple[Note, ...]:
    """Return assumptions and warnings."""
    return tuple(note for note in notes if note.kind is not NoteKind.OMISSION)
