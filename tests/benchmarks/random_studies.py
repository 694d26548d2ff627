"""Studies drawn at random over the input space: each is rechecked, marked or refused, none wrong or crashed.

    python tests/benchmarks/random_studies.py --count 2000 --resume outcomes.json

The check of `tests/support/recheck.py` looks at the written files alone. Every study runs in a process that
may crash or hang without taking the others with it.
"""

import argparse
import json
import multiprocessing
import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

TIMEOUT = 300.0  # seconds a study


def main() -> None:
    """Draw, run, recheck and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--resume", type=Path, help="a JSON file to keep outcomes in")
    arguments = parser.parse_args()
    kept = json.loads(arguments.resume.read_text()) if arguments.resume and arguments.resume.exists() else {}
    pool = None
    for seed in map(str, range(arguments.first, arguments.first + arguments.count)):
        if seed in kept:
            continue
        pool = pool or multiprocessing.get_context("spawn").Pool(1)
        kept[seed] = attempt(pool, int(seed))
        if kept[seed]["outcome"] == "HUNG":
            pool.terminate()
            pool = None
        if arguments.resume:
            arguments.resume.write_text(json.dumps(kept))
    if pool:
        pool.close()
        pool.join()
    report(kept)


def attempt(pool, seed: int) -> dict[str, object]:
    """One study in the pool's process."""
    from drawn_studies import outcome

    try:
        return pool.apply_async(outcome, (seed,)).get(TIMEOUT)
    except multiprocessing.TimeoutError:
        return {"outcome": "HUNG"}


def report(kept: dict[str, dict]) -> None:
    """Print the counts, by whom studies were refused or marked, and the worst that passed."""
    print(len(kept), "studies:", dict(Counter(entry["outcome"] for entry in kept.values())))
    for kind in ("refused", "marked"):
        by = Counter(entry["by"].split(":")[0] for entry in kept.values() if entry["outcome"] == kind)
        print(kind, "by", dict(by.most_common(12)))
    for name in ("equilibrium", "section"):
        worst = max((entry.get(name, 0.0) for entry in kept.values()), default=0.0)
        print(f"worst {name}: {worst:.2g}")
    for seed, entry in kept.items():
        if entry["outcome"] in ("WRONG", "crashed", "HUNG"):
            print(f"study {seed}: {entry}")


if __name__ == "__main__":
    main()
