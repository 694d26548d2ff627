"""What an earlier run looks like on disk: the only thing a new run may replace.

A run names its files in its `summary.json`; one of several speeds also those beside the speeds' folders.
"""

import json
from pathlib import Path
from typing import Any

from fea.analysis.summary_file import OPTIMISED, OPTIMISED_SCHEMA, SCHEMA, SUMMARY
from fea.output.picture_name import picture_name
from fea.output.report.name import REPORT

# Of any version.
_SCHEMAS = tuple(schema.rpartition("/")[0] + "/" for schema in (SCHEMA, OPTIMISED_SCHEMA))


def is_earlier_run(directory: Path) -> bool:
    """Return whether `directory` holds a run, or a run at each of several speeds, and nothing else."""
    entries = list(directory.iterdir())
    folders = [entry for entry in entries if entry.is_dir()]
    if not folders:
        return _is_run(directory)
    lists = [_manifest(folder).get("shared_files") for folder in folders]
    shared = lists[0]
    if not isinstance(shared, list) or any(names != shared for names in lists):
        return False
    files = [entry for entry in entries if entry not in folders]
    if any(folder.is_symlink() for folder in folders):
        return False
    return all(map(_is_run, folders)) and all(entry.name in shared and _is_file(entry) for entry in files)


def _is_run(folder: Path) -> bool:
    """Return whether a directory holds only what its summary names, pictures of that and a report."""
    files = _manifest(folder).get("files")
    if not isinstance(files, list):
        return False
    own = {*files, REPORT, *(picture_name(str(name)) for name in files if str(name).endswith(".vtu"))}
    return all(entry.name in own and _is_file(entry) for entry in folder.iterdir())


def _is_file(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _manifest(folder: Path) -> dict[str, Any]:
    """Return the summary of a run or a search in a directory, empty where this program wrote none."""
    for name in (SUMMARY, OPTIMISED):
        try:
            summary = json.loads((folder / name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        if isinstance(summary, dict) and str(summary.get("schema")).startswith(_SCHEMAS):
            return summary
    return {}
