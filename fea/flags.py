"""The flags that override a study."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path

from fea.choices import Element, SolverName, Support, Symmetry
from fea.speeds import parse_speeds
from fea.study import Study


@dataclass(frozen=True)
class Flags:
    """What the user asked on the command line; None leaves the study as it is."""

    rpm: str | None = None
    """Speed or speeds: 6000, 800,3000,6000 or 800:9000:200."""

    size: float | None = None
    """Element size, mm."""

    element: Element | None = None
    """Order of the tetrahedra."""

    support: Support | None = None
    """How the rod is held."""

    symmetry: Symmetry | None = None
    """Which part of the rod is solved."""

    pressure: str | None = None
    """How a pin presses on its bore: cosine-180, uniform-120, cosine-<arc> or webster."""

    solver: SolverName | None = None
    """Linear solver."""

    min_safety: float | None = None
    """Exit with 6 when a safety factor is below this."""

    screenshot: bool = False
    """Take a picture of each load case."""

    out: Path | None = None
    """Directory of the results."""

    def applied(self, study: Study) -> Study:
        """Return the study with the flags on top.

        Raises
        ------
        InvalidValue
            A flag's value breaks a rule.
        """
        tables = {
            "speed": {"rpm": None if self.rpm is None else parse_speeds(self.rpm)},
            "mesh": {"size_mm": self.size, "element": self.element},
            "analysis": {
                "support": self.support,
                "symmetry": self.symmetry,
                "pressure": self.pressure,
                "solver": self.solver,
                "min_safety": self.min_safety,
            },
            "output": {
                "screenshot": self.screenshot or None,
                "directory": None if self.out is None else str(self.out.resolve()),
            },
        }
        changes = {}
        for name, values in tables.items():
            given = {key: value for key, value in values.items() if value is not None}
            if given:
                changes[name] = dataclasses.replace(getattr(study, name), **given)
        return dataclasses.replace(study, **changes)
