"""Kill -9 at random moments: an earlier run is never harmed, no part of a run is taken for a whole one.

python tests/benchmarks/killed_runs.py --count 100

With `--sweep`, runs over two speeds with their cycles.
"""

import argparse
import hashlib
import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

COMMAND = [sys.executable, "-m", "fea", "run", "--size", "12", "--quiet", "--out", "r"]
SWEEP = ["--rpm", "4000,6000", "--cycle"]


def digest(folder: Path) -> str:
    """One figure for every byte of a run."""
    sums = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        sums.update(str(path.relative_to(folder)).encode() + (path.read_bytes() if path.is_file() else b""))
    return sums.hexdigest()


def trusted(folder: Path, speeds: int) -> bool:
    """Whether there is a whole run of every speed."""
    summaries = [json.loads(path.read_text()) for path in folder.rglob("summary.json")]
    return len(summaries) == speeds and all(summary["trusted"] for summary in summaries)


def main() -> None:
    """Run, kill, look, and let a last run clean up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--sweep", action="store_true", help="over two speeds")
    arguments = parser.parse_args()
    command, speeds = ([*COMMAND, *SWEEP], 2) if arguments.sweep else (COMMAND, 1)
    draw, found = random.Random(0), Counter()  # noqa: S311
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        start = time.monotonic()
        subprocess.run(command, cwd=folder, check=True)
        usual = time.monotonic() - start
        for _ in range(arguments.count):
            before = digest(folder / "r")
            with subprocess.Popen(command, cwd=folder) as process:
                time.sleep(draw.uniform(0, 1.1 * usual))
                process.send_signal(signal.SIGKILL)
            complete = trusted(folder / "r", speeds)
            same = digest(folder / "r") == before
            remains = len(list(folder.iterdir())) - 1
            kind = "earlier run kept" if same else "new run complete"
            found[kind if complete else "HARMED"] += 1
            found["remains to clean up"] += bool(remains)
        subprocess.run(command, cwd=folder, check=True)
        found["remains after the next run"] = len(list(folder.iterdir())) - 1
    print(dict(found))


if __name__ == "__main__":
    main()
