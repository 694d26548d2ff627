"""Kill -9 at random moments: an earlier run is never harmed, no part of a run is taken for a whole one.

python tests/benchmarks/killed_runs.py --count 100
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


def digest(folder: Path) -> str:
    """One figure for every byte of a run."""
    sums = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        sums.update(path.name.encode() + path.read_bytes())
    return sums.hexdigest()


def main() -> None:
    """Run, kill, look, and let a last run clean up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    count = parser.parse_args().count
    draw, found = random.Random(0), Counter()  # noqa: S311
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        start = time.monotonic()
        subprocess.run(COMMAND, cwd=folder, check=True)
        usual = time.monotonic() - start
        for _ in range(count):
            before = digest(folder / "r")
            with subprocess.Popen(COMMAND, cwd=folder) as process:
                time.sleep(draw.uniform(0, 1.1 * usual))
                process.send_signal(signal.SIGKILL)
            complete = json.loads((folder / "r" / "summary.json").read_text())["trusted"]
            same = digest(folder / "r") == before
            remains = len(list(folder.iterdir())) - 1
            kind = "earlier run kept" if same else "new run complete"
            found[kind if complete else "HARMED"] += 1
            found["remains to clean up"] += bool(remains)
        subprocess.run(COMMAND, cwd=folder, check=True)
        found["remains after the next run"] = len(list(folder.iterdir())) - 1
    print(dict(found))


if __name__ == "__main__":
    main()
