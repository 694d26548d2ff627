"""From measured runs to the figures of the report: medians, ratios, exponents."""

import math
import statistics
from collections.abc import Sequence
from typing import Any

Row = dict[str, Any]


class Figures:
    """Figures of the runs, by program and size.

    Parameters
    ----------
    rows
        Every run.
    """

    def __init__(self, rows: Sequence[Row]) -> None:
        self._rows = rows

    def sizes(self, program: str) -> list[int]:
        """Sizes a program was asked for, smallest first."""
        return sorted({row["dofs"] for row in self._rows if row["program"] == program})

    def dofs(self, size: int) -> int:
        """Degrees of freedom the mesh of a size really has."""
        return next(int(row["case"]["dofs"]) for row in self._rows if row["dofs"] == size)

    def elements(self, size: int) -> int:
        return next(int(row["case"]["elements"]) for row in self._rows if row["dofs"] == size)

    def done(self, program: str, size: int) -> list[Row]:
        """The runs that came to an end."""
        found = [row for row in self._rows if row["program"] == program and row["dofs"] == size]
        return [row for row in found if row["status"] == "done"]

    def failure(self, program: str, size: int) -> str:
        """Why there is no figure; empty where there is one."""
        rows = [row for row in self._rows if row["program"] == program and row["dofs"] == size]
        if self.done(program, size) or not rows:
            return ""
        return str(rows[0]["status"])

    def median(self, program: str, size: int, key: str = "seconds") -> float:
        """Median over the runs; not a number where there are none."""
        values = [row[key] for row in self.done(program, size) if key in row]
        return statistics.median(values) if values else math.nan

    def spread(self, program: str, size: int) -> tuple[float, float]:
        """Shortest and longest run, s."""
        values = [row["seconds"] for row in self.done(program, size)]
        return min(values), max(values)

    def stage(self, program: str, size: int, stage: str) -> float:
        """Median of a stage, s; 0 where the program has no such stage."""
        values = [row["stages"].get(stage, 0.0) for row in self.done(program, size) if "stages" in row]
        return statistics.median(values) if values else math.nan

    @property
    def load(self) -> float:
        """Median load average of the machine at the end of the runs."""
        return statistics.median(row["load"] for row in self._rows)

    def ratio(self, program: str, other: str, size: int) -> float:
        """Median over the rounds of the ratio of the two programs' times within a round."""
        times = {row["round"]: row["seconds"] for row in self.done(other, size)}
        pairs = [
            row["seconds"] / times[row["round"]] for row in self.done(program, size) if row["round"] in times
        ]
        return statistics.median(pairs) if pairs else math.nan

    def solver(self, program: str, size: int) -> str:
        """The linear solver a program chose, where it says so."""
        return str(next((row["solver"] for row in self.done(program, size) if "solver" in row), ""))

    def agreement(self, program: str, size: int) -> dict[str, float]:
        """Largest differences from the reference."""
        found = [row["agreement"] for row in self.done(program, size) if row.get("agreement")]
        return dict(found[-1]) if found else {}

    def bytes_per_dof(self, program: str, size: int) -> float:
        """Memory taken beyond what the process held before it began, per degree of freedom."""
        base = self.median(program, size, "base_mb")
        extra = self.median(program, size, "peak_mb") - (0.0 if math.isnan(base) else base)
        return extra * 2**20 / self.dofs(size)

    def exponent(self, program: str, key: str = "seconds") -> float:
        """Slope of log figure over log dofs by least squares, of the least figures above 30 000 dofs."""
        points = [
            (math.log(self.dofs(size)), math.log(min(row[key] for row in self.done(program, size))))
            for size in self.sizes(program)
            if size > 30_000 and self.done(program, size)
        ]
        if len(points) < 2:
            return math.nan
        slope, _ = statistics.linear_regression(*zip(*points, strict=True))
        return slope
