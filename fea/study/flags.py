"""The flags that override a study."""

import dataclasses
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fea.choices import Element, Fatigue, SolverName, Support, Symmetry
from fea.study.speeds import parse_speeds
from fea.study.study import Study
from fea.study.tables import checked, unknown_key
from geometry.invalid import require, require_number


@dataclass(frozen=True)
class Flags:
    """What the user asked on the command line; None leaves the study as it is."""

    rpm: str | None = None
    """Speed or speeds: 6000, 800,3000,6000 or 800:9000:200."""

    size: float | None = None
    """Element size, mm; by default a 28th of the rod's length, smaller on its features."""

    element: Element | None = None
    """Order of the tetrahedra."""

    support: Support | None = None
    """How the rod is held."""

    symmetry: Symmetry | None = None
    """Which part of the rod is solved."""

    pressure: str | None = None
    """How a pin presses on its bore: cosine-180, uniform-120, cosine-ARC (degrees) or webster."""

    solver: SolverName | None = None
    """Linear solver."""

    cycle: bool = False
    """Work out every degree of the crank cycle: envelope, histories, fatigue."""

    fatigue: Fatigue | None = None
    """How mean and amplitude of the cycle are judged."""

    buckling: bool = False
    """Find the load factors at which the rod buckles, and the shapes it takes."""

    tolerance: float | None = None
    """Refine the mesh until every peak is within this, percent."""

    min_safety: float | None = None
    """Exit with 6 when a safety factor is below this."""

    screenshot: bool = False
    """Take a picture of each load case."""

    animate: Path | None = None
    """Write an animation of the cycle to this file (.gif; .mp4 with imageio-ffmpeg)."""

    out: Path | None = None
    """Directory of the results."""

    def applied(self, study: Study) -> Study:
        """Return the study with the flags on top.

        Raises
        ------
        InvalidValue
            A flag's value breaks a rule.
        """
        tables: dict[str, dict[str, Any]] = {
            "speed": {"rpm": None if self.rpm is None else parse_speeds(self.rpm)},
            "mesh": {"size_mm": self.size, "element": self.element},
            "analysis": {
                "support": self.support,
                "symmetry": self.symmetry,
                "pressure": self.pressure,
                "solver": self.solver,
                "tolerance_percent": self.tolerance,
                "min_safety": self.min_safety,
                "cycle": self.cycle or None,
                "fatigue": self.fatigue,
                "buckling": self.buckling or None,
            },
            "output": {
                "screenshot": self.screenshot or None,
                "directory": None if self.out is None else str(self.out.resolve()),
                "animate": None if self.animate is None else str(self.animate.resolve()),
            },
        }
        changes = {}
        for name, values in tables.items():
            given = {key: value for key, value in values.items() if value is not None}
            if given:
                changes[name] = dataclasses.replace(getattr(study, name), **given)
        asked = dataclasses.replace(study, **changes)
        needs = "judges the crank cycle, which is not asked for"
        cycle = self.fatigue is None or asked.analysis.cycle
        require(cycle, "--fatigue", self.fatigue, needs, "Add --cycle.")
        return asked


def python_flags(values: Mapping[str, Any]) -> Flags:
    """Return flags given as Python values: numbers and lists for ``rpm``, text for choices and paths.

    Raises
    ------
    InvalidValue
        An unknown flag or a value of the wrong kind.
    """
    hints = typing.get_type_hints(Flags)
    flags: dict[str, Any] = {}
    for name, value in values.items():
        if name not in hints:
            raise unknown_key("run()", name, hints)
        if value is None:
            continue
        if name == "rpm":
            flags[name] = value if isinstance(value, str) else _speeds_text(value)
        elif name in {"out", "animate"}:
            flags[name] = Path(value)
        else:
            flags[name] = checked(name, value, hints[name])
    return Flags(**flags)


def _speeds_text(value: object) -> str:
    speeds = value if isinstance(value, list | tuple) else [value]
    return ",".join(repr(require_number("rpm", speed)) for speed in speeds)
