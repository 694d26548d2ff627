"""Do headline, table, report, studio, limits, summary.json and exit code agree on random studies?

    python tests/benchmarks/verdict_campaign.py [--studies 100] [--first 0] [--resume FILE.jsonl]

Random rods in one piece and in parts, with and without the whole cycle, films and `--min-safety`, on coarse
meshes. Where the whole cycle is known the studio's converged answer and, for rods of one piece, `fea limits`
are asked too. What governs, its factor, its interval and the word for it must be the same everywhere.
"""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from scripts import Row, campaign, command, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from agreeing import disagreements, random_asked


def outcome(seed: int) -> Row | None:
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


def report_text(rows: list[Row]) -> str:
    """The report."""
    found = [row for row in rows if "lost" not in row]
    counts = [("studies", f"{len(found)}")]
    counts += [
        (name, f"{sum(bool(row[name]) for row in found)}")
        for name in ("parts", "cycle", "film", "min_safety")
    ]
    counts.append(("that disagree with themselves", f"{sum(bool(row['wrong']) for row in found)}"))
    counts += [("without an end", f"{row['seed']}") for row in rows if "lost" in row]
    lines = ["# One verdict", "", f"Made by `{command()}`.", "", *table(("what", "studies"), counts)]
    lines += ["", *(f"- {row['seed']}: {text}" for row in found for text in row["wrong"])]
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=100, what="studies", patience=600.0)
