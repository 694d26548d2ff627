"""The flags that override a study."""

import dataclasses
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

from fea.base.choices import Assembly, Element, Fatigue, SolverName, Support, Symmetry
from fea.study.material_table import MaterialTable
from fea.study.paths import absolute, parse_speeds
from fea.study.study import Study
from fea.study.tables import checked, number, unknown_key
from geometry.errors import require, require_number


@dataclass(frozen=True)
class Flags:
    """The options of the command line; None leaves the study's value unchanged."""

    rpm: str | None = None
    """Engine speeds, rpm: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200)."""

    material: str | None = None
    """Material of the rod in place of the study's, by its name (a wrong one lists them all)."""

    engine: str | None = None
    """Engine of the library in place of the study's: toyota-2jz, jeep-4.0, …; any other name lists all."""

    size: float | None = None
    """Element size, mm, smaller on fillets, bores and webs: no refinement unless --tolerance is given."""

    element: Element | None = None
    """Order of the tetrahedra: p1 (4 nodes) or p2 (10 nodes); default: p2."""

    support: Support | None = None
    """Boundary condition: inertia-relief (default; nothing is clamped), or clamped at the big end."""

    symmetry: Symmetry | None = None
    """Part of the rod to solve; default: the smallest part that its mirror planes allow."""

    pressure: str | None = None
    """Pin load on the bores: cosine-180 (default), uniform-120, cosine-ARC, webster, bonded, contact."""

    solver: SolverName | None = None
    """Linear solver; default: auto, chosen by the memory that it needs."""

    assembly: Assembly | None = None
    """Assembly of the stiffness matrix: batched (the default), or scikit-fem, which is slower."""

    cycle: bool = False
    """Analyse the whole crank cycle, degree by degree: stress envelope, histories, fatigue."""

    fatigue: Fatigue | None = None
    """Mean-stress correction used with --cycle; default: goodman."""

    buckling: bool = False
    """Compute the buckling load factors and buckling shapes of the solid."""

    tolerance: float | None = None
    """Refine the mesh until the error bar of every peak is at most this, percent; default: 5; 0: never."""

    min_safety: float | None = None
    """Exit with code 6 unless every safety factor of the run, less its error bar, reaches this value."""

    screenshot: bool = False
    """Save a .png picture of each load case next to its .vtu file."""

    report: bool = False
    """Save report.html: the whole analysis in one file, with the rod in 3-D, for any browser, offline."""

    pvd_step: float | None = None
    """Save the fields of the cycle every so many degrees, for ParaView to play; needs --cycle."""

    animate: Path | None = None
    """Write an animation of the cycle to this file (.gif; .mp4 with imageio-ffmpeg); needs --cycle."""

    out: Path | None = None
    """Directory of the results; default: results/STUDY-RPMrpm. Only an earlier run is ever replaced."""

    def applied(self, study: Study) -> Study:
        """Return the study with the flags on top.

        Raises
        ------
        InvalidValue
            A flag's value breaks a rule.
        """
        tables: dict[str, dict[str, Any]] = {
            "speed": {"rpm": None if self.rpm is None else parse_speeds(self.rpm)},
            "mesh": {"size_mm": number("mesh.size_mm", self.size), "element": self.element},
            "analysis": {
                "support": self.support,
                "symmetry": self.symmetry,
                "pressure": self.pressure,
                "solver": self.solver,
                "assembly": self.assembly,
                "tolerance_percent": number("analysis.tolerance_percent", self.tolerance),
                "min_safety": number("analysis.min_safety", self.min_safety),
                "cycle": self.cycle or None,
                "fatigue": self.fatigue,
                "buckling": self.buckling or None,
            },
            "output": {
                "screenshot": self.screenshot or None,
                "report": self.report or None,
                "pvd_step_deg": number("output.pvd_step_deg", self.pvd_step),
                "directory": absolute("--out", self.out),
                "animate": absolute("--animate", self.animate),
            },
        }
        if self.material is not None:
            study = dataclasses.replace(study, material=MaterialTable(preset=self.material))
        if self.engine is not None:
            rule = "cannot be used with [forces], which replace an engine"
            remedy = "Leave it out, or remove [forces] from the study."
            require(study.forces is None, "--engine", self.engine, rule, remedy)
            study = study.with_engine(self.engine)
        changes = {}
        for name, values in tables.items():
            given = {key: value for key, value in values.items() if value is not None}
            if given:
                changes[name] = dataclasses.replace(getattr(study, name), **given)
        asked = dataclasses.replace(study, **changes)
        still = self.rpm is None or study.forces is None
        rule = "cannot be used with [forces], which have no speed"
        require(still, "--rpm", self.rpm, rule, "Leave it out, or give an [engine].")
        needs = "has no effect without --cycle"
        cycle = self.fatigue is None or asked.analysis.cycle
        require(cycle, "--fatigue", self.fatigue, needs, "Add --cycle.")
        return asked


class AnalysisFlags(TypedDict, total=False):
    """The flags of ``fea run`` that ask for figures, as Python values."""

    rpm: float | Sequence[float] | str
    material: str
    engine: str
    size: float
    element: str
    support: str
    symmetry: str
    pressure: str
    solver: str
    assembly: str
    cycle: bool
    fatigue: str
    buckling: bool
    tolerance: float
    min_safety: float
    report: bool


class RunFlags(AnalysisFlags, total=False):
    """All flags of ``fea run``, as Python values."""

    screenshot: bool
    pvd_step: float
    animate: str | Path
    out: str | Path


def python_flags(values: Mapping[str, Any], valid: type = RunFlags) -> Flags:
    """Return flags given as Python values: numbers and lists for ``rpm``, text for choices and paths.

    Parameters
    ----------
    values
        By the names of the flags.
    valid
        `RunFlags`, or `AnalysisFlags` where nothing is written.

    Raises
    ------
    InvalidValue
        An unknown flag or a value of the wrong kind.
    """
    hints, names = typing.get_type_hints(Flags), typing.get_type_hints(valid)
    flags: dict[str, Any] = {}
    for name, value in values.items():
        if name not in names:
            raise unknown_key("flag", name, names)
        if value is None:
            continue
        if name == "rpm":
            flags[name] = value if isinstance(value, str) else _speeds_text(value)
        elif name in {"out", "animate"}:
            require(isinstance(value, str | Path), name, value, "must be a path")
            flags[name] = Path(value)
        else:
            flags[name] = checked(name, value, hints[name])
    return Flags(**flags)


def _speeds_text(value: object) -> str:
    speeds = value if isinstance(value, list | tuple) else [value]
    return ",".join(repr(require_number("rpm", speed)) for speed in speeds)
