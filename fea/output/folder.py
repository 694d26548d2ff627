"""The directory of a run: written completely or not at all, without ever damaging an earlier run.

A run is written into a hidden directory beside its target, ``.<name>.<random>.part``, which is exchanged with
the target at the end. Its process holds a lock on that directory: an unlocked one was left by a process that
died, and the next run into the same place removes it. If two directories cannot be exchanged in one step, the
earlier run is renamed to ``.<name>.<random>.backup``, which the next run restores if necessary.

Other files that the user names are checked before anything is computed, and shown as short paths.
"""

import csv
import errno
import io
import json
import math
import os
import re
import shutil
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.machine.system import PathLock, exchange, flush, incomplete, replaced
from geometry.arrays import Floats
from geometry.errors import public, require


def require_target(
    option: str, path: Path | None, suffixes: Collection[str], *, parents: bool = False
) -> None:
    """Refuse a file, given by an option, that cannot be written; None stands for none.

    Suffixes are in lower case; an existing device or pipe may have any. With `parents`, missing directories
    above it will be created. Raises `InvalidValue`: the suffix is not allowed, the path is a directory, or
    there is none that it can be written into.
    """
    if path is None:
        return
    require(not path.is_dir(), option, str(path), "is a directory", "Name a file.")
    device = path.exists() and not path.is_file()
    rule = f"must end in {' or '.join(suffixes)}"
    require(device or path.suffix.lower() in suffixes, option, str(path), rule)
    if parents:
        above = next(parent for parent in path.absolute().parents if parent.exists())
        rule, remedy = f"is inside {above}, which is not a directory", "Choose another path."
    else:
        above, remedy = path.parent, "Create the directory first."
        rule = "is in a directory that does not exist"
    require(above.is_dir(), option, str(path), rule, remedy)


def near(path: Path) -> Path:
    """Return a path relative to the current directory if it is below it and that is not the root."""
    here = Path.cwd()
    short = path.is_relative_to(here) and here != here.parent
    return path.relative_to(here) if short else path


def picture_name(result: str) -> str:
    """Return the name of the picture of a result file, which stands beside it."""
    return Path(result).with_suffix(".png").name


class OutputError(Exception):
    """A result could not be written or shown."""


@public
class OccupiedError(OutputError):
    """The output directory contains something other than an earlier run (exit code 2)."""


@public
class StorageError(OutputError):
    """A full disk, a permission or the file system prevents writing (exit code 7)."""


@public
class PictureError(OutputError):
    """No usable picture could be drawn; the result files are not affected (exit code 7)."""


_LONG = 260 - 40  # characters of a folder, without the random part of its name and the names of its files


@contextmanager
def reported(
    path: Path, remedy: str, *, verb: str = "written", kind: type[OutputError] = StorageError
) -> Iterator[None]:
    """Turn an error of the system, met while a path is written, into one of a kind that says what to do."""
    try:
        yield
    except OSError as error:
        if sys.platform == "win32" and len(str(path.absolute())) > _LONG:
            remedy = f"Paths of more than 260 characters need Windows' long paths enabled. {remedy}"
        raise kind(f"{path} could not be {verb}: {error.strerror or error}. {remedy}") from error


@contextmanager
def stored(path: Path) -> Iterator[Path]:
    """Yield a place to write a file, as `replaced` does; raises `StorageError`, which says what to do."""
    with reported(path, "Choose another path, or free disk space."), replaced(path) as place:
        yield place


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with unchanged newlines, completely or not at all; raises `StorageError`."""
    with stored(path) as place:
        place.write_text(text, encoding="utf-8", newline="\n")


def make_directory(path: Path) -> None:
    """Create a directory and its missing parents; raises `StorageError` if the system refuses."""
    with reported(path, "Choose another path.", verb="created"):
        path.mkdir(parents=True, exist_ok=True)


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV; what is None stays blank."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def write_columns(path: Path, columns: Mapping[str, npt.ArrayLike]) -> None:
    """Write columns (n,), or numbers for all rows, by name. `ValueError`: lengths differ; `StorageError`."""
    every = np.broadcast_arrays(*(np.atleast_1d(np.asarray(column, float)) for column in columns.values()))
    values = np.stack(every, axis=1) + 0.0  # without negative zeros; what does not apply, NaN, is blank
    row = ",".join(["%.7g"] * values.shape[1]) + "\n"
    rows = (row * len(values) % tuple(values.ravel().tolist())).replace("nan", "")
    write_text(path, ",".join(columns) + "\n" + rows)


def read_columns(path: Path) -> dict[str, Floats]:
    """Read columns (n,) by their names, NaN for none. Raises `OSError`; `ValueError`: not such a table."""
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    names = head.split(",")
    values = [[float(cell) if cell else math.nan for cell in row.split(",")] for row in rows]
    return dict(zip(names, np.array(values).reshape(-1, len(names)).T, strict=True))


REPORT, SHEET = "report.html", "sheet.html"
# The files of the figures of a run and of a search for the lightest rod, and the formats of any version.
SUMMARY, OPTIMISED = "summary.json", "optimise.json"
# Files that `fea report` adds to a run.
_LATER = (REPORT, SHEET, "report.pdf", "sheet.pdf")
_SCHEMAS = ("fea/summary/", "fea/optimise/", "fea/limits/")


def is_earlier_run(directory: Path) -> bool:
    """Return whether `directory` holds a run, or a run at each of several speeds, and nothing else."""
    entries = list(directory.iterdir())
    folders = [entry for entry in entries if entry.is_dir()]
    if not folders:
        return _is_run(directory)
    lists = [_manifest(folder).get("shared_files") for folder in folders]
    shared = lists[0]
    if not isinstance(shared, list) or any(names != shared for names in lists):
        return False
    files = [entry for entry in entries if entry not in folders]
    if any(folder.is_symlink() for folder in folders):
        return False
    return all(map(_is_run, folders)) and all(entry.name in shared and _is_file(entry) for entry in files)


def _is_run(folder: Path) -> bool:
    files = _manifest(folder).get("files")
    if not isinstance(files, list):
        return False
    own = {*files, *_LATER, *(picture_name(str(name)) for name in files if str(name).endswith(".vtu"))}
    return all(entry.name in own and _is_file(entry) for entry in folder.iterdir())


def _is_file(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _manifest(folder: Path) -> dict[str, Any]:
    for name in (SUMMARY, OPTIMISED):
        try:
            summary = json.loads((folder / name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        if isinstance(summary, dict) and str(summary.get("schema")).startswith(_SCHEMAS):
            return summary
    return {}


@contextmanager
def held(directory: Path) -> Iterator[None]:
    """Hold the lock of `directory` during the block; on a file system without locks, do nothing."""
    lock = take(directory, wait=True)
    try:
        yield
    finally:
        if lock:
            lock.release()


def take(path: Path, *, wait: bool = False) -> PathLock | None:
    """Return the lock of a file or directory, or None if it cannot be locked."""
    lock = PathLock(path)
    return lock if lock.take(wait=wait) else None


@contextmanager
def owned(path: Path, where: Path, command: str, remedy: str) -> Iterator[None]:
    """Hold the lock of a file or directory, `where` in messages; `OccupiedError`: another command has it."""
    lock = take(path)
    if lock is None:
        raise OccupiedError(f"{near(where)} is in use by another {command}: {remedy}.")
    try:
        yield
    finally:
        lock.release()


PART, BACKUP = "part", "backup"
ANOTHER_OUT = "Choose another directory with --out."
LONGEST_NAME = 255  # bytes, on every file system in use


def require_replaceable(target: Path) -> None:
    """Require that a run may be written to `target`: it does not exist, is empty or holds an earlier run.

    Raises `OccupiedError`: it contains something else, or it is or contains the current directory;
    `StorageError`: it cannot be read.
    """
    with reported(near(target), ANOTHER_OUT):
        if len(os.fsencode(_sibling(target.absolute(), BACKUP).name)) > LONGEST_NAME:
            raise OSError(errno.ENAMETOOLONG, os.strerror(errno.ENAMETOOLONG), str(target))
        if not target.exists():
            above = next(parent for parent in target.absolute().parents if parent.exists())
            if not above.is_dir():
                raise OccupiedError(
                    f"{near(target)} is inside {near(above)}, which is not a directory: "
                    "choose another directory with --out."
                )
            return
        if not target.is_dir():
            raise OccupiedError(
                f"{near(target)} is a file: --out must name a new directory or that of an earlier run."
            )
        here = Path.cwd()
        if any(place.samefile(target) for place in (here, *here.parents)):  # the case of letters may differ
            raise OccupiedError(
                f"{near(target)} is or contains the current directory, which a run cannot replace: choose a "
                "directory below it with --out."
            )
        if any(target.iterdir()) and not is_earlier_run(target):
            raise OccupiedError(
                f"{near(target)} contains files that are not from an earlier run and are never overwritten: "
                "choose another directory with --out, or empty this one."
            )


@contextmanager
def run_folder(target: Path) -> Iterator[Path]:
    """Yield an empty directory to write a run into; it becomes `target` if the block succeeds.

    If the block ends with an exception, or its process dies, `target` stays as it was. Several simultaneous
    runs into one place are safe: each is complete, and the last one stays. Missing parents are created; only
    an earlier run is replaced (see `require_replaceable`, checked at the beginning and again at the end).
    Raises `OccupiedError`: `target` contains something other than an earlier run; `StorageError`: a full
    disk, a permission or the file system prevents writing.
    """
    place = target.resolve()  # a link to a directory stays a link
    try:
        require_replaceable(target)
    except OccupiedError:
        if not place.parent.is_dir():
            raise
        with held(place.parent):  # without an atomic exchange, another run may just be taking its place
            require_replaceable(target)
    with reported(near(target), ANOTHER_OUT):
        made = [parent for parent in place.parents if not parent.exists()]
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            with held(place.parent):
                _mend(place)
                part = _sibling(place, PART)
                part.mkdir()
                owned = take(part)
        except BaseException:
            _unmake_parents(made)
            raise
    done = False
    try:
        with incomplete(part):
            yield part
        with reported(near(target), ANOTHER_OUT):
            # Flush every file to the disk before the name of the run points to them.
            for root, _, names in os.walk(part):
                for name in names:  # Windows flushes only what is open for writing
                    with Path(root, name).open("r+b") as file:
                        flush(file.fileno())
                _flush_directory(Path(root))
            with held(place.parent):
                require_replaceable(target)
                old = _put(part, place)
            done = True
            _flush_directory(place.parent)
            if old:
                shutil.rmtree(old, ignore_errors=True)
    finally:
        if not done:
            shutil.rmtree(part, ignore_errors=True)
            _unmake_parents(made)
        if owned:
            owned.release()


def _unmake_parents(made: list[Path]) -> None:
    with suppress(OSError):
        for parent in made:
            parent.rmdir()


def final(folder: Path) -> Path:
    """Return where a folder will be that is being written (see `run_folder`); any other one as it is."""
    being_written = rf"\.(.+)\.[0-9a-f]{{8}}\.{PART}"
    return Path(*(re.sub(f"^{being_written}$", r"\1", name) for name in folder.parts))


def _sibling(place: Path, kind: str) -> Path:
    import secrets  # noqa: PLC0415 - it takes OpenSSL with it, and a run has other work before

    return place.with_name(f".{place.name}.{secrets.token_hex(4)}.{kind}")


def _siblings(place: Path, kind: str) -> list[Path]:
    entries = place.parent.iterdir()
    return [
        entry for entry in entries if entry.name.startswith(f".{place.name}.") and entry.suffix == f".{kind}"
    ]


def _mend(place: Path) -> None:
    """Clean up what killed runs have left; the caller holds the lock of the parent."""
    for backup in _siblings(place, BACKUP):
        if place.exists():
            shutil.rmtree(backup, ignore_errors=True)
        else:
            backup.rename(place)
    for part in _siblings(place, PART):
        owned = take(part)
        if owned:
            shutil.rmtree(part, ignore_errors=True)
            owned.release()


def _put(part: Path, place: Path) -> Path | None:
    """Move `part` to `place`; return where the earlier run is now, if there was one."""
    if not place.exists():
        part.rename(place)
        return None
    if exchange(part, place):
        return part
    backup = _sibling(place, BACKUP)
    place.rename(backup)
    try:
        part.rename(place)
    except OSError:
        backup.rename(place)
        raise
    return backup


def _flush_directory(directory: Path) -> None:
    """Flush the entries of a directory to the disk, if the system can open one."""
    with suppress(OSError):
        descriptor = os.open(directory, os.O_RDONLY)
        try:
            flush(descriptor)
        finally:
            os.close(descriptor)
