"""Do headline, table, report, studio, limits, summary.json and exit code agree on random studies?

    python tests/benchmarks/verdict_campaign.py [--studies 100] [--first 0] [--report FILE.md]

Random rods in one piece and in parts, with and without the whole cycle, films and `--min-safety`, on coarse
meshes. Where the whole cycle is known the studio's converged answer and, for rods of one piece, `fea limits`
are asked too. What governs, its factor, its interval and the word for it must be the same everywhere.
"""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from scripts import campaign, command, publish, reporting, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from agreeing import disagreements, random_asked

PATIENCE = 600.0  # seconds for a study


def outcome(seed: int) -> dict[str, Any] | None:
    """Run a study and compare what it says; None where none was drawn or it is refused."""
    os.environ["COLUMNS"] = "200"
    study = random_asked(seed)
    if study is None:
        return None
    with TemporaryDirectory() as folder:
        wrong = disagreements(study, Path(folder))
    if wrong is None:
        return None
    options = study.analysis
    asked = {"parts": study.assembly is not None, "cycle": options.cycle, "film": options.film}
    return {"seed": seed, **asked, "min_safety": options.min_safety is not None, "wrong": wrong}


def main() -> None:
    """Run all studies and print the report."""
    parser = reporting(__doc__)
    parser.add_argument("--studies", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + 100 * asked.studies)
    found, endless = campaign(outcome, seeds, asked.studies, asked.processes, PATIENCE)
    rows = [("studies", f"{len(found)}")]
    rows += [
        (name, f"{sum(bool(one[name]) for one in found)}")
        for name in ("parts", "cycle", "film", "min_safety")
    ]
    rows.append(("that disagree with themselves", f"{sum(bool(one['wrong']) for one in found)}"))
    rows += [("without an end", f"{seed}") for seed in endless]
    lines = ["# One verdict", "", f"Made by `{command()}`.", "", *table(("what", "studies"), rows)]
    lines += ["", *(f"- {one['seed']}: {text}" for one in found for text in one["wrong"])]
    publish("\n".join(lines).rstrip() + "\n", asked.report)


if __name__ == "__main__":
    main()
