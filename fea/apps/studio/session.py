"""The session: designs with undo and redo, and named variants, in a journal from which it resumes."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from fea.base.version import __version__
from fea.output.folder import owned, reported
from fea.output.json_file import JsonObject, json_lines
from fea.study.study import Study

# Designs that can be undone.
_MOST = 500
# Labels of the answers that variants keep, the better the later: interpolated ones are not kept.
KNOWN = ("exact on a moved mesh", "converged")

State = Mapping[str, Mapping[str, Any]]  # "design" and "operation", each by the names of its values
Answer = Mapping[str, Any]  # "label" and "figures" of a frame


def rank(answer: Answer | None) -> int:
    """Return how good an answer is, -1 where there is none."""
    return KNOWN.index(answer["label"]) if answer else -1


@dataclass
class Session:
    """Designs in the order in which they were made; `change` makes and journals every change."""

    states: list[State]
    journal: BinaryIO | None = None
    at: int = 0
    variants: dict[str, JsonObject] = field(default_factory=dict)  #: "state" and "answer" by name

    @property
    def state(self) -> State:
        """The present design."""
        return self.states[self.at]

    def change(self, kind: str, **what: Any) -> None:
        """Make a change, and keep it in the journal.

        "commit" a state, "move" by steps back or forth, "keep" a state and its answer as a variant of a name,
        or "remove" that.
        """
        if kind == "commit" and what["state"] != self.state:
            self.states = [*self.states[: self.at + 1], what["state"]][-_MOST:]
            self.at = len(self.states) - 1
        elif kind == "move":
            self.at = min(max(self.at + what["by"], 0), len(self.states) - 1)
        elif kind == "keep":
            self.variants[what["name"]] = {"state": what["state"], "answer": what["answer"]}
        elif kind == "remove":
            self.variants.pop(what["name"], None)
        if self.journal is not None:
            self.journal.write(json.dumps({"kind": kind, **what}).encode() + b"\n")
            self.journal.flush()

    def answered(self, state: State, answer: Answer) -> bool:
        """Give variants of a state an answer that is no less exact than theirs; return whether any."""
        alike = {name: variant for name, variant in self.variants.items() if variant["state"] == state}
        better = [name for name in alike if rank(alike[name]["answer"]) <= rank(answer)]
        for name in better:
            self.change("keep", name=name, state=state, answer=answer)
        return bool(better)

    def described(self) -> JsonObject:
        """Return what the page shows of the session."""
        undo, redo = self.at > 0, self.at < len(self.states) - 1
        return {**self.state, "undo": undo, "redo": redo, "variants": self.variants}


@contextmanager
def session(study: Study, first: State, folder: Path) -> Iterator[Session]:
    """Yield the session of a study, which resumes from its journal in the folder.

    A study that has been edited has another journal. Raises `OccupiedError`: another `fea studio` has this
    session; `StorageError`: the folder cannot be written.
    """
    identity = hashlib.sha256((__version__ + study.text()).encode()).hexdigest()[:12]
    path = folder / f"session-{identity}.jsonl"
    with reported(path, "Start fea studio in a folder that can be written."):
        folder.mkdir(parents=True, exist_ok=True)
        journal = path.open("a+b")
    with journal, owned(path, path, "fea studio", "use that one, or end it"):
        journal.seek(0)
        kept, changes = Session([first]), list(json_lines(journal.read()))
        for change, _ in changes:
            kept.change(**change)
        journal.truncate(changes[-1][1] if changes else 0)
        kept.journal = journal
        yield kept
