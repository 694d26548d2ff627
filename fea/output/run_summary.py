"""The figures of a run on disk, and the file of it that shows what governs."""

from pathlib import Path

from fea.analysis.summary_figures import Summary
from fea.output.folder import SUMMARY
from fea.output.json_file import read_summary
from geometry.errors import InvalidValue, require

STUDY = "study.toml"
AGAIN = "Repeat the run: fea run study.toml."


def run_summary(folder: Path) -> Summary:
    """Return the figures of a run of one speed. Raises `InvalidValue`: the folder holds none."""
    remedy = "Name the folder that fea run has written, such as results/leon-2001-6000rpm."
    require(folder.is_dir(), "RUN", str(folder), "is not a directory", remedy)
    speeds = sorted(place.parent.name for place in folder.glob(f"*/{SUMMARY}"))
    if speeds and not (folder / SUMMARY).is_file():
        rule = f"holds runs at several speeds: {', '.join(speeds[:8])}"
        raise InvalidValue("RUN", str(folder), rule, f"Name one of them, such as {folder / speeds[0]}.")
    try:
        summary = read_summary(folder)
    except (OSError, ValueError) as error:
        raise InvalidValue("RUN", str(folder), f"has no readable {SUMMARY} ({error})", remedy) from error
    require((folder / STUDY).is_file(), "RUN", str(folder), f"has no {STUDY}", remedy)
    return summary


def governing_run(folder: Path) -> tuple[Path, Summary]:
    """Return the folder of a run, of several speeds the worst, and its summary; raises as `run_summary`."""
    one = (folder / SUMMARY).is_file()
    speeds = [] if one else sorted(place.parent for place in folder.glob(f"*/{SUMMARY}"))
    runs = [(place, run_summary(place)) for place in speeds or [folder]]
    return min(runs, key=lambda run: run[1].survival.assured_safety_factor)


def governing_file(folder: Path) -> tuple[Path, Summary]:
    """Return the result file that shows what governs a run, of several speeds the worst, and its summary.

    Raises `InvalidValue`: see `run_summary`, or its fields were not kept.
    """
    place, summary = governing_run(folder)
    vtu, rule = place / f"{summary.governing_result}.vtu", "is missing, which shows what governs"
    require(vtu.is_file(), "RUN", str(vtu), rule, AGAIN)
    return vtu, summary
