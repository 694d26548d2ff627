"""The program run in a copy of this process that is watched: its exit code, words, remains and orphans."""

import contextlib
import os
import shutil
import signal
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

REFUSALS = (2, 3, 4)
JUDGED = (0, 5)


@dataclass(frozen=True)
class Ended:
    """How a run ended."""

    code: int
    said: str
    remains: tuple[str, ...]
    orphans: bool

    def fault(self, results=("results",)):
        """What it did that it may not do; empty where all is well."""
        if self.code not in REFUSALS + JUDGED:
            return f"exit code {self.code}"
        if self.orphans:
            return "left a process behind"
        left = set(self.remains) - (set(results) if self.code in JUDGED else set())
        if left:
            return f"left {sorted(left)}"
        if "Traceback" in self.said or "internal error" in self.said:
            return "a traceback"
        lines = self.said.splitlines()
        if self.code in REFUSALS and not (1 <= len(lines) <= 2 and lines[0].startswith("fea: ")):
            return f"{len(lines)} lines of message"
        return ""


def contained(arguments, files, *, seconds=900):
    """Run `fea ARGUMENTS` in a new directory with `files` (bytes by name); nothing of it stays.

    The copy saves loading the libraries for each of thousands of runs.
    """
    place = Path(tempfile.mkdtemp(prefix="fea-contained-"))
    work, temporary, home = place / "work", place / "tmp", place / "home"
    for folder in (work, temporary, home):
        folder.mkdir()
    for name, content in files.items():
        (work / name).write_bytes(content)
    child = os.fork()
    if not child:
        os.environ["HOME"] = str(home)  # gmsh makes a directory of settings there
        _call(arguments, work, temporary, place / "stderr")
    code = _waited(child, seconds)
    orphans = False
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
        orphans = True
    said = (place / "stderr").read_text(errors="replace")
    remains = {path.name for path in work.iterdir()} - set(files) | {p.name for p in temporary.iterdir()}
    shutil.rmtree(place)
    return Ended(code, said, tuple(sorted(remains)), orphans)


def _waited(child, seconds):
    """The exit code; 124 after the time is up, −n for an end by signal n."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return 124


def _call(arguments, work, temporary, stderr):
    """In the copy."""
    code = 1
    try:
        os.setsid()
        os.chdir(work)
        tempfile.tempdir = str(temporary)
        os.environ["TMPDIR"] = str(temporary)
        os.dup2(os.open(stderr, os.O_WRONLY | os.O_CREAT), 2)
        os.dup2(os.open(os.devnull, os.O_RDWR), 1)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", buffering=1)  # a test may hold others
        from fea.cli.program import call

        code = call(list(map(str, arguments)))
    finally:
        os._exit(code)
