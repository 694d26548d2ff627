"""Studies drawn at random over the input space: each is rechecked, marked or refused, none wrong or crashed.

    python tests/benchmarks/random_studies.py --count 2000 --resume outcomes.json --workers 2
    python tests/benchmarks/random_studies.py --count 500 --section H

The check of `tests/support/recheck.py` looks at the written files alone. Every study runs in a process that
may crash or hang without taking the others with it. `--report FILE.md` writes the counts of what is kept.
"""

import argparse
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from scripts import LostError, in_process, keep, kept_in

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

COMMAND = "python tests/benchmarks/random_studies.py --count 2000 --resume outcomes.json --report FILE.md"
CPU, WALL = 300.0, 3600.0  # seconds a study
BAD = ("WRONG", "crashed", "LOST")


def main() -> None:
    """Draw, run, recheck and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--section", help="of every shank: I, H, rectangular or tubular")
    parser.add_argument("--again", nargs="*", help="seeds to run once more; all that were bad without any")
    parser.add_argument("--resume", type=Path, help="a JSON file to keep outcomes in")
    parser.add_argument("--report", type=Path, help="a Markdown file for the counts")
    arguments = parser.parse_args()
    kept = kept_in(arguments.resume)
    if arguments.again is not None:
        bad = [seed for seed, entry in kept.items() if entry["outcome"] in BAD]
        kept = {seed: entry for seed, entry in kept.items() if seed not in (arguments.again or bad)}
    seeds = [str(seed) for seed in range(arguments.first, arguments.first + arguments.count)]
    with ThreadPoolExecutor(arguments.workers) as threads:
        coming = {
            threads.submit(attempt, int(seed), arguments.section): seed for seed in seeds if seed not in kept
        }
        for done in as_completed(coming):
            kept[coming[done]] = done.result()
            keep(arguments.resume, kept)
    text = report(kept)
    print(text)
    if arguments.report:
        arguments.report.write_text(f"# Random studies\n\n{text}\n```\n{COMMAND}\n```\n")


def attempt(seed: int, section: str | None) -> dict[str, object]:
    """One study in the process of this thread."""
    try:
        return in_process(outcome, (seed, section), WALL, CPU)
    except LostError as error:
        return {"outcome": "LOST", "by": str(error)}


def outcome(asked: tuple[int, str | None]) -> dict[str, object]:
    """Run the study of a seed and a section."""
    from drawn_studies import outcome as outcome_of

    return outcome_of(*asked)


def report(kept: dict[str, dict]) -> str:
    """The counts as Markdown: by whom studies were refused or marked, and the worst that passed."""
    counts = Counter(entry["outcome"] for entry in kept.values())
    lines = [f"{len(kept)} studies, seeds {min(map(int, kept))}…{max(map(int, kept))}.", ""]
    lines += ["| outcome | studies |", "|---|--:|"]
    said = {"rechecked": "trusted, and the recheck agrees", "marked": "marked as not to be trusted (exit 5)"}
    said |= {"refused": "refused with a reason (exit 2, 3, 4)"}
    lines += [
        f"| {said.get(kind, kind)} | {counts[kind]} |" for kind in ("rechecked", "marked", "refused", *BAD)
    ]
    for kind in ("marked", "refused"):
        by = Counter(
            _by(entry["by"]) for _, entry in sorted(kept.items()) if entry["outcome"] == kind
        ).most_common()
        lines += ["", f"{kind.capitalize()} by: " + ", ".join(f"{who} {count}" for who, count in by) + "."]
    lines += ["", "| largest error of a recheck | |", "|---|--:|"]
    for name in ("equilibrium", "section", "piston"):
        worst = max((entry.get(name, 0.0) for entry in kept.values()), default=0.0)
        lines.append(f"| {name} | {worst:.2g} |")
    bad = [f"- {seed}: {entry}" for seed, entry in sorted(kept.items(), key=_seed) if entry["outcome"] in BAD]
    return "\n".join([*lines, "", *bad]).rstrip() + "\n"


def _by(said: str) -> str:
    """The value or the stage that a refusal names."""
    kind, _, rest = said.partition(": ")
    name = rest.split(" = ")[0] if kind == "InvalidValue" else kind
    return f"`{name}`"


def _seed(item: tuple[str, dict]) -> int:
    return int(item[0])


if __name__ == "__main__":
    main()
