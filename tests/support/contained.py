"""The program run in a copy of this process that is watched: its exit code, words, remains and orphans."""

import contextlib
import os
import shutil
import signal
import tempfile
from dataclasses import dataclass
from pathlib import Path

from program import copied, waited

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
    # gmsh makes a directory of settings in HOME.
    environment = {"HOME": str(home), "TMPDIR": str(temporary)}
    stderr = place / "stderr"
    with stderr.open("wb") as err, open(os.devnull, "wb") as out:  # noqa: PTH123
        child = copied(list(map(str, arguments)), work, environment, out=out.fileno(), err=err.fileno())
    code = waited(child, seconds)
    orphans = False
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
        orphans = True
    said = stderr.read_text(errors="replace")
    remains = {path.name for path in work.iterdir()} - set(files) | {p.name for p in temporary.iterdir()}
    shutil.rmtree(place)
    return Ended(code, said, tuple(sorted(remains)), orphans)
