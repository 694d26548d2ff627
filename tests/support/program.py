"""The program run as a process: a new one, or a copy of this one, which has loaded the libraries already."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

COARSE = ("--size", 12)
PLAIN = (str(Path(__file__).with_name("plain.toml")), *COARSE)  # a study that is solved sooner
PROGRAM = (sys.executable, "-m", "fea")
_LIBRARIES = (
    *("gmsh", "meshio", "skfem", "scipy.spatial", "vtkmodules.vtkIOXML", "fea.apps.run_study"),
    *(
        "cyclopts.completion",
        "cyclopts.help",
        "rich.markdown",
        "fea.cli.run",
        "fea.cli.rod",
        "fea.apps.write_run",
    ),
)


def fea(*arguments, cwd, environment=None, largest_file=None):
    """Run `fea` in a directory, in a copy of this process; the finished process with its output as text.

    What the program does with streams, signals and exit codes is that of a new process; what it imports,
    and the threads of its libraries, are not. No file may exceed `largest_file` bytes. Windows copies no
    processes: a new one.
    """
    if not hasattr(os, "fork"):
        assert largest_file is None, "there is no such limit"
        return started(*arguments, cwd=cwd, environment=environment)
    command, most = list(map(str, arguments)), largest_file
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = copied(command, cwd, environment or {}, out=out.fileno(), err=err.fileno(), largest_file=most)
        code = waited(child, 300)
        out.seek(0)
        err.seek(0)
        said = (each.read().decode() for each in (out, err))
        return subprocess.CompletedProcess(command, code, *said)


def started(*arguments, cwd, environment=None):
    """Run `fea` in a directory as a new process; otherwise as `fea`."""
    return subprocess.run(
        [*PROGRAM, *map(str, arguments)],
        cwd=cwd,
        env=os.environ | (environment or {}),
        capture_output=True,
        encoding="utf-8",
        timeout=300,
        check=False,
    )


def copied(arguments, cwd, environment, *, out, err, largest_file=None):
    """Begin `fea ARGUMENTS` in a copy of this process, a group of its own; return its number.

    Parameters
    ----------
    environment
        What to change of the environment.
    out, err
        Descriptors of its standard streams.
    largest_file
        Bytes that no file may exceed; None for no limit.
    """
    _load()
    child = os.fork()
    if not child:
        if largest_file is not None:
            import resource

            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))
        _become(arguments, cwd, environment, out, err)
    return child


def waited(child, seconds):
    """Exit code of a copy; −n for an end by signal n, 124 after the time is up."""
    end, pause = time.monotonic() + seconds, 0.002
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(pause)
        pause = min(0.02, 1.5 * pause)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return 124


@cache
def _load():
    for name in _LIBRARIES:
        import_module(name)


def _become(arguments, cwd, environment, out, err):
    """Be the program, in the copy."""
    code = 1
    try:
        os.setsid()
        os.chdir(cwd)
        os.environ.update(environment)
        if "TMPDIR" in environment:
            tempfile.tempdir = environment["TMPDIR"]
        for target, source in ((0, os.open(os.devnull, os.O_RDONLY)), (1, out), (2, err)):
            os.dup2(source, target)
        # A test may hold other streams; pytest makes errors of warnings.
        sys.stdout, sys.stderr = (os.fdopen(n, "w", encoding="utf-8", closefd=False) for n in (1, 2))
        warnings.resetwarnings()
        for quiet in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", quiet)
        sys.argv = ["fea", *arguments]
        from fea.__main__ import main

        main()
    except SystemExit as leaving:
        code = leaving.code if isinstance(leaving.code, int) else int(leaving.code is not None)
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)


def figures(*arguments, cwd):
    """JSON that `fea ARGUMENTS --json` prints; it must end well."""
    import json

    done = fea(*arguments, "--json", cwd=cwd)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def names(folder):
    """Names of the entries of a directory."""
    return {entry.name for entry in Path(folder).iterdir()}


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
        """The first rule that it broke; empty if none."""
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
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
        orphans = True
    said = stderr.read_text(errors="replace")
    remains = {path.name for path in work.iterdir()} - set(files) | {p.name for p in temporary.iterdir()}
    shutil.rmtree(place)
    return Ended(code, said, tuple(sorted(remains)), orphans)
