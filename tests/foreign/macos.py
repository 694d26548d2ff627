"""Run a copy of the program that takes its system to be macOS, on Linux: tests/foreign/macos.py [FOLDER].

The copy does not fork, has no Pardiso, flushes as macOS does, and so on; which libraries and calls macOS has
is not shown. FOLDER (default: conrod-fea-macos in the directory for temporary files) holds the copy and what
it writes. Prints a table; exit code 1 if a trial failed.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from wine import SWEEP

TREE = Path(__file__).parents[2]
THERE = {
    r"sys\.platform\b": '"darwin"',
    r"platform\.machine\(\)": '"arm64"',
    r'hasattr\(os, "sched_getaffinity"\)': "False",
    r"fcntl\.F_FULLFSYNC": "51",  # its number; Linux refuses it
    r'version\("pypardiso"\)': 'version("pypardiso of another processor")',
    r"import Pardiso;": "import Pardiso as Absent;",
}
COARSE = ("--size", "14", "--tolerance", "0", "--quiet")
PEAK = 1e-5  # the same mesh and another solver


class Copy:
    """The program in a folder, where it has a folder to work in."""

    def __init__(self, folder: Path) -> None:
        self.tree, self.work = folder / "tree", folder / "work"
        shutil.rmtree(folder, ignore_errors=True)
        self.work.mkdir(parents=True)
        for name in ("fea", "geometry", "mesh", "loads", "tests"):
            shutil.copytree(TREE / name, self.tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(TREE / "pyproject.toml", self.tree)
        sources = [path for path in self.tree.rglob("*.py") if "tests" not in path.parts]
        changed = 0
        for path in sources:
            text = path.read_text(encoding="utf-8")
            for pattern, value in THERE.items():
                text, count = re.subn(pattern, value, text)
                changed += count
            path.write_text(text, encoding="utf-8")
        assert changed > 20

    def start(self, *arguments: str, tree: Path | None = None) -> "subprocess.Popen[str]":
        """Start Python in the folder to work in, on the copy or another tree."""
        environment = os.environ | {"PYTHONPATH": str(tree or self.tree)}
        return subprocess.Popen(
            [sys.executable, *arguments], cwd=self.work, env=environment, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def fea(self, *arguments: str, tree: Path | None = None) -> str:
        """Run the program; return what it said."""
        process = self.start("-m", "fea", *arguments, tree=tree)
        said = process.communicate(timeout=900)[0]
        assert process.returncode == 0, said[-400:]
        return said


def doctor(copy: Copy) -> str:
    said = copy.fea("doctor")
    assert "CHOLMOD" in said, said
    return "CHOLMOD"


def peaks(copy: Copy) -> str:
    flags = ("run", "--rpm", "6000", *COARSE, "--cycle", "--report", "--screenshot", "--out")
    copy.fea(*flags, "there")
    copy.fea(*flags, "here", tree=TREE)
    there, here = (json.loads((copy.work / name / "summary.json").read_text()) for name in ("there", "here"))
    assert there["model"]["solver"] == "cholmod"
    stress = "max_von_mises_MPa"
    worst = max(
        abs(there["results"][case][stress] / here["results"][case][stress] - 1) for case in here["results"]
    )
    assert worst < PEAK, f"peaks differ by {worst:.1e}"
    return f"peaks differ by {worst:.1e}"


def bolted(copy: Copy) -> str:
    copy.fea("run", "leon-2001-bolted", *COARSE, "--out", "bolted")
    copy.fea("run", "leon-2001-bolted", *COARSE, "--out", "bolted")
    return "twice into one folder"


def step_file(copy: Copy) -> str:
    copy.fea("rod", "--step", "rod.step")
    copy.fea("run", "rod.step", "--engine", "leon-2001", "--material", "leon-2001", *COARSE, "--out", "cad")
    return "read in a fresh interpreter"


def sweep(copy: Copy) -> str:
    (copy.work / "s.toml").write_text(SWEEP)
    copy.fea("sweep", "s.toml", "--workers", "2", "--out", "sweep")
    return "6 rods, 2 workers"


def interrupt(copy: Copy) -> str:
    before = set(copy.work.iterdir())
    process = copy.start("-m", "fea", "run", "--size", "3", "--quiet", "--out", "interrupted")
    time.sleep(8)
    process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    try:
        process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130
    assert set(copy.work.iterdir()) == before
    return f"ended after {time.monotonic() - begun:.1f} s"


def suite(copy: Copy) -> str:
    """What of the tests neither forks nor sets the system itself."""
    names = (
        "machine/test_isolated.py",
        "machine/test_threads.py",
        "output/test_folder.py",
        "geometry/test_system.py",
    )
    chosen = (
        "-k",
        "not what_the_system_refuses",
        f"--rootdir={copy.tree}",
        "-c",
        str(copy.tree / "pyproject.toml"),
    )
    tests = [str(copy.tree / "tests" / name) for name in names]
    said = (copy.start("-m", "pytest", "-q", "-p", "no:cacheprovider", *chosen, *tests)).communicate(
        timeout=900
    )[0]
    last = said.strip().rpartition("\n")[2].strip("= ")
    assert "passed" in last, said[-400:]
    assert "failed" not in last, said[-400:]
    return last


def main() -> int:
    """Make the copy, try it, print a table."""
    folder = Path(sys.argv[1]) if sys.argv[1:] else Path(tempfile.gettempdir(), "conrod-fea-macos")
    copy, failed = Copy(folder.resolve()), 0
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job would hand on SIG_IGN
    for attempt in (doctor, peaks, bolted, step_file, sweep, interrupt, suite):
        try:
            passed, said = "passed", attempt(copy)
        except Exception as error:  # noqa: BLE001 - whatever fails is a row of the table
            failed, passed, said = 1, "FAILED", f"{type(error).__name__}: {error}"
        sys.stdout.write(f"{passed}  {attempt.__name__:10} {said}\n")
        sys.stdout.flush()
    return failed


if __name__ == "__main__":
    sys.exit(main())
