"""The directory of a run: written completely or not at all, without ever damaging an earlier run.

A run is written into a hidden directory beside its target, ``.<name>.<random>.part``, which is exchanged with
the target at the end. Its process holds a lock on that directory: an unlocked one was left by a process that
died, and the next run into the same place removes it. If two directories cannot be exchanged in one step, the
earlier run is renamed to ``.<name>.<random>.backup``, which the next run restores if necessary.
"""

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fea.output import lock
from fea.output.earlier import is_earlier_run
from fea.output.errors import OccupiedError, StorageError
from fea.output.exchange import exchange
from fea.output.target import near

PART, BACKUP = "part", "backup"
LONGEST_NAME = 255  # bytes, on every file system in use


def require_replaceable(target: Path) -> None:
    """Require that a run may be written to `target`: it does not exist, is empty or holds an earlier run.

    Raises
    ------
    OccupiedError
        It contains something else, or it is or contains the current directory.
    StorageError
        It cannot be read.
    """
    with _reported(target):
        _require_room_for_name(target)
        if not target.exists():
            _require_directory_above(target)
            return
        if not target.is_dir():
            raise OccupiedError(
                f"{near(target)} is a file: --out must name a new directory or that of an earlier run."
            )
        if Path.cwd().is_relative_to(target.resolve()):
            raise OccupiedError(
                f"{near(target)} is or contains the current directory, which a run cannot replace: choose a "
                "directory below it with --out."
            )
        if any(target.iterdir()) and not is_earlier_run(target):
            raise OccupiedError(
                f"{near(target)} contains files that are not from an earlier run and are never overwritten: "
                "choose another directory with --out, or empty this one.",
            )


@contextmanager
def run_folder(target: Path) -> Iterator[Path]:
    """Yield an empty directory to write a run into; it becomes `target` if the block succeeds.

    If the block ends with an exception, or its process dies, `target` stays as it was. Several simultaneous
    runs into one place are safe: each is complete, and the last one stays.

    Parameters
    ----------
    target
        The directory of the run. Missing parents are created. An existing directory is replaced only if it
        holds an earlier run (see `require_replaceable`, checked at the beginning and again at the end).

    Yields
    ------
    Path
        The directory to write into, on the file system of the target.

    Raises
    ------
    OccupiedError
        `target` contains something other than an earlier run.
    StorageError
        A full disk, a permission or the file system prevents writing.
    """
    require_replaceable(target)
    place = target.resolve()  # a link to a directory stays a link
    with _reported(target):
        made = _make_parents(place)
        try:
            with lock.held(place.parent):
                _mend(place)
                part = _sibling(place, PART)
                part.mkdir()
                owned = lock.take(part)
        except BaseException:
            _unmake_parents(made)
            raise
    done = False
    try:
        yield part
        with _reported(target):
            _flush(part)
            with lock.held(place.parent):
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
        lock.release(owned)


def _require_room_for_name(target: Path) -> None:
    """Require that the name of a sibling is not too long for the file system."""
    if len(os.fsencode(_sibling(target.absolute(), BACKUP).name)) > LONGEST_NAME:
        raise OSError(errno.ENAMETOOLONG, os.strerror(errno.ENAMETOOLONG), str(target))


def _require_directory_above(target: Path) -> None:
    """Require that the existing parents of `target` are directories."""
    above = next(parent for parent in target.absolute().parents if parent.exists())
    if not above.is_dir():
        raise OccupiedError(
            f"{near(target)} is inside {near(above)}, which is not a directory: "
            "choose another directory with --out."
        )


@contextmanager
def _reported(target: Path) -> Iterator[None]:
    """Turn an error of the system into one with a remedy."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise StorageError(
            f"{near(target)} could not be written: {reason}. Choose another directory with --out."
        ) from error


def _make_parents(place: Path) -> list[Path]:
    """Create the missing parents of `place`; return them, the deepest first."""
    missing = [parent for parent in place.parents if not parent.exists()]
    place.parent.mkdir(parents=True, exist_ok=True)
    return missing


def _unmake_parents(made: list[Path]) -> None:
    """Remove the parents that a failed run created, unless they are in use by now."""
    with suppress(OSError):
        for parent in made:
            parent.rmdir()


def _sibling(place: Path, kind: str) -> Path:
    """Return a new hidden name beside `place`."""
    import secrets  # noqa: PLC0415 - it takes OpenSSL with it, and a run has other work before

    return place.with_name(f".{place.name}.{secrets.token_hex(4)}.{kind}")


def _siblings(place: Path, kind: str) -> list[Path]:
    """Return what earlier runs into `place` have left beside it."""
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
        owned = lock.take(part)
        if owned is not None:
            shutil.rmtree(part, ignore_errors=True)
            lock.release(owned)


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


def _flush(directory: Path) -> None:
    """Flush every file to the disk before the name of the run points to them."""
    for root, _, names in os.walk(directory):
        for name in names:
            with Path(root, name).open("rb") as file:
                os.fsync(file.fileno())
        _flush_directory(Path(root))


def _flush_directory(directory: Path) -> None:
    """Flush the entries of a directory to the disk, if the system can open one."""
    with suppress(OSError):
        descriptor = os.open(directory, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
