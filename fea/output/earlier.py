"""What an earlier run looks like on disk: the only thing a new run may replace."""

import json
from pathlib import Path

CASES = ("tension", "compression", "side", "bending", "gas", "given", "envelope", "buckling")
RUN_FILES = frozenset(
    {"summary.json", "study.toml", "loads.csv", "history.png"}
    | {f"{case}.{extension}" for case in CASES for extension in ("vtu", "png")},
)
# Beside one directory a speed.
SWEEP_FILES = frozenset({"map.csv", "cycle_map.csv", "cycle_map.png"})


def is_earlier_run(directory: Path) -> bool:
    """Return whether `directory` holds a run, or a run at each of several speeds, and nothing else."""
    entries = {entry.name: entry for entry in directory.iterdir()}
    if "map.csv" in entries:
        runs = [entry for name, entry in entries.items() if name not in SWEEP_FILES]
        return all(run.name.endswith("rpm") and _is_directory(run) and is_earlier_run(run) for run in runs)
    return entries.keys() <= RUN_FILES and all(map(_is_file, entries.values())) and _has_summary(directory)


def _is_directory(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _is_file(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _has_summary(directory: Path) -> bool:
    """Return whether there is a summary that a version of this program wrote."""
    try:
        summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(summary, dict) and str(summary.get("schema")).startswith("fea/summary/")
