"""The designs of a search as they come, in a file beside its results: an interrupted search goes on there."""

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from fea.apps.sweep.base import digest, files_of
from fea.base.version import __version__
from fea.machine.system import saying
from fea.output.folder import ANOTHER_OUT, owned
from fea.output.json_file import JsonObject, json_lines
from fea.output.target import near, reported
from fea.study.study import Study
from geometry.arrays import Floats

SUFFIX = ".unfinished"


class Record:
    """The designs that a search asked for, in order: the same search asks for the same ones again.

    `count` is the number of designs that are known from an interrupted search; `empty` says that there is
    none at all yet.
    """

    def __init__(self, path: Path, identity: str) -> None:
        self.path = path
        self._file = path.open("r+b") if path.exists() else path.open("w+b")
        lines = list(json_lines(self._file.read()))
        ours = bool(lines) and lines[0][0] == {"search": identity}
        self._known, self._end = lines[1:] if ours else [], lines[0][1] if ours else 0
        self.count = len(self._known)
        if not ours:
            self.add({"search": identity})
        self.empty = not self.count

    def next(self, kind: str, asked: Floats) -> JsonObject | None:
        """Return the next design if it is the one that is asked for (n,); else None, and forget the rest."""
        if self._known:
            entry, end = self._known.pop(0)
            if (entry["kind"], entry["asked"]) == (kind, asked.tolist()):
                self._end = end
                return entry
            self._known = []
        return None

    def add(self, entry: JsonObject) -> None:
        """Write a design behind those that were returned; raises `StorageError` if the system refuses."""
        with reported(self.path, ANOTHER_OUT):
            self._file.seek(self._end)
            self._file.truncate()
            self._file.write(json.dumps(entry).encode() + b"\n")
            self._file.flush()
        self._end, self.empty = self._file.tell(), False

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@contextmanager
def record(folder: Path, study: Study) -> Iterator[Record]:
    """Yield the record of a search beside its folder; it is removed with the block, but not by an interrupt.

    Raises `OccupiedError`: another search is at work there; `StorageError`: the disk, a permission or the
    file system refuses.
    """
    place = folder.resolve()
    path = place.with_name(place.name + SUFFIX)
    with reported(path, ANOTHER_OUT):
        place.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    with owned(path, folder, "fea optimise", "wait for it, or choose --out"):
        with reported(path, ANOTHER_OUT):
            kept = Record(path, _identity(study))
        done = False
        try:
            with saying(f"interrupted; the same command resumes from the designs in {near(path)}"):
                yield kept
            done = True
        finally:
            kept.close()
            if done or kept.empty:
                with suppress(OSError):
                    path.unlink()


def _identity(study: Study) -> str:
    table = study.optimise
    same = replace(study, optimise=None if table is None else replace(table, evaluations=None))
    files = [digest(path) for path in files_of(same.as_dict())]
    return hashlib.sha256(json.dumps([__version__, same.text(), files]).encode()).hexdigest()
