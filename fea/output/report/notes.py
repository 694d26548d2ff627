"""The notes of a run for its report: by consequence, and assumptions together by what they are about."""

import re
from collections.abc import Iterable
from typing import NamedTuple

from fea.base.note import Note, NoteKind
from fea.output.units import named, unit

# Keys of a study in brackets at the end of a note, and a value that is given by its key.
_KEYS = re.compile(r" \((?:\[?[a-z_]+[.\]][\w.\[\]]*|[a-z_]+_[\w]*)(?:,? (?:or |and )?[\w.\[\]]+)*\)\.?$")
_VALUE = re.compile(r"^([a-z]\w*) = ([^\s,]+)")
_SPOKEN = {"endurance_MPa": "an endurance limit", "ultimate_MPa": "an ultimate strength"}
_TOPICS = {
    "contact": "pins and bores", "assembly": "joint and fits", "fatigue": "fatigue strength",
    "film": "oil film", "map": "map of limits",
}  # fmt: skip
# Topics of assumptions that bear on a mode of failure, the first the most.
_BEARING = {
    "yielding": ("material", "engine", "gas", "contact", "assembly"),
    "fatigue": ("fatigue", "material", "engine", "gas", "contact", "assembly"),
    "buckling": ("material", "engine", "gas"),
}
_OF_BOLTS = ("bolts", "assembly", "engine", "gas", "contact")
# Of bolts, what their tightening depends on comes before their shape.
_TIGHTENING = ("preload", "friction")


class NoteGroup(NamedTuple):
    """Notes of one consequence: a heading, and lines, each with its topic or none."""

    heading: str
    lines: tuple[tuple[str, str], ...]
    folded: bool = False  #: behind its heading


def in_words(note: Note) -> str:
    """Return the text of a note without its keys, and of an assumption without the word for it."""
    text = _KEYS.sub("", note.text).removeprefix("assumed ")
    for key, words in _SPOKEN.items():
        text = text.replace(key, words)
    if (found := _VALUE.match(text)) is not None:
        words, own = named(found[1])
        text = f"{words} {found[2]} {unit(own)}".rstrip() + text[found.end() :]
    return text


def bearing(notes: Iterable[Note], mode: str) -> list[Note]:
    """Return the assumptions that bear on a mode of failure, those first that bear on it most."""
    topics = _BEARING.get(mode, _OF_BOLTS)
    rank = {note: topics.index(first) for note in notes if (first := _first(note)) in topics}
    assumed = [note for note in rank if note.kind is NoteKind.ASSUMPTION]
    return sorted(assumed, key=lambda note: (rank[note], _of_tightening(note)))


def _of_tightening(note: Note) -> int:
    return next((k for k, word in enumerate(_TIGHTENING) if word in note.text), len(_TIGHTENING))


def _first(note: Note) -> str:
    return (note.topic.split() or [""])[0]


def note_groups(notes: Iterable[Note], mode: str) -> list[NoteGroup]:
    """Return the notes in groups by consequence; assumptions that bear on the mode of failure come first."""
    every = list(notes)
    limiting = [note for note in every if note.kind in {NoteKind.DOUBT, NoteKind.WARNING}]
    first, done = bearing(every, mode), [note for note in every if note.kind is NoteKind.REMARK]
    rest = [note for note in every if note.kind is NoteKind.ASSUMPTION and note not in first]
    groups = [
        NoteGroup("What limits these figures", tuple((note.topic, in_words(note)) for note in limiting)),
        NoteGroup("Assumed, and the answer depends on it", _by_topic(first)),
        NoteGroup("Assumed beside it", _by_topic(rest), folded=True),
        NoteGroup("What was done", tuple((note.topic, in_words(note)) for note in done), folded=True),
    ]
    return [group for group in groups if group.lines]


def _by_topic(notes: Iterable[Note]) -> tuple[tuple[str, str], ...]:
    found: dict[str, list[str]] = {}
    for note in notes:
        found.setdefault(_TOPICS.get(note.topic, note.topic), []).append(in_words(note))
    return tuple((topic, "; ".join(texts)) for topic, texts in found.items())
