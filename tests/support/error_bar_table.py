"""The report of tests/benchmarks/error_bars.py."""

import numpy as np

# Factors on the estimate that are tried beside the one in use (1).
MULTIPLES = (0.75, 1.0, 1.25, 1.5, 2.0)

Groups = dict[str, list[dict]]


def report_text(kept: dict[str, Groups], command: str) -> str:
    """Coverage and medians by group, and of the half of the rods that no factor was fitted to."""
    groups = grouped(kept)
    lines = [
        "# How far the error bars hold",
        f"Made by `{command}`; {sum(name.split()[0] != 'known' for name in kept)} rods.",
        "| group | cases | held | median bar/error | 10 % … 90 % | median bar % | worst error/bar |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
        *(_row(name, rows) for name, rows in groups.items()),
    ]
    return "\n".join(lines)


def grouped(kept: dict[str, Groups]) -> Groups:
    """Rows by group, over all bodies."""
    groups: Groups = {}
    for found in kept.values():
        for name, rows in found.items():
            groups.setdefault(name, []).extend(rows)
    second = [r for name, rows in groups.items() if "first order" not in name for r in rows]
    return {"all of second order": second, **groups}


def _row(name: str, rows: list[dict]) -> str:
    bar, error = (np.array([r[key] for r in rows]) for key in ("bar_percent", "error_percent"))
    ratio = bar / np.maximum(error, 0.01)
    low, median, high = np.quantile(ratio, [0.1, 0.5, 0.9])
    return (
        f"| {name} | {len(rows)} | {np.mean(error <= bar):.1%} | {median:.1f} | {low:.1f} … {high:.1f} "
        f"| {np.median(bar):.1f} | {(error / bar).max():.2f} |"
    )
