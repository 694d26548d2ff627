"""A study: everything a run is asked, from a shipped name or a TOML file, with flags on top."""

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from fea.choices import Element, Fatigue, SolverName, Support, Symmetry
from fea.material import Material
from fea.study.engine_table import EngineTable
from fea.study.material_table import MaterialTable
from fea.study.paths import is_file, located, require_size, require_text
from fea.study.rod_table import RodTable, read_rod
from fea.study.tables import entries_of, nearest, read_table, toml_text, unknown_key
from geometry.invalid import InvalidValue, require, require_number, require_positive
from loads.bearing import BorePressure

# A key of so many parts: the parser's time grows with their square.
_NESTED = re.compile(r"(?:\.[^.,\n\[\]{}]*){64}")
# Beyond any piston engine; model aircraft engines reach about 40 000.
LARGEST_RPM = 50_000.0
LARGEST_STUDY = 2**18  # bytes; the longest list of speeds takes a tenth
DEFAULT_STUDY = "leon-2001"


@dataclass(frozen=True)
class SpeedTable:
    """[speed]."""

    rpm: float | tuple[float, ...] = 6000.0

    def speeds(self) -> tuple[float, ...]:
        """Return the speeds, rpm, in the order given."""
        values = self.rpm if isinstance(self.rpm, tuple) else (self.rpm,)
        require(len(values) > 0, "speed.rpm", [], "must hold at least one speed")
        for value in values:
            require_number("speed.rpm", value)
            require(0 <= value <= LARGEST_RPM, "speed.rpm", value, f"must lie within 0…{LARGEST_RPM:.0f}")
        named = {f"{value:g}": value for value in reversed(values)}
        for value in values:
            rule = f"is {value:g} rpm to six digits, as {named[f'{value:g}']!r} is"
            require(named[f"{value:g}"] == value, "speed.rpm", repr(value), rule, "Leave one of them out.")
        return tuple(dict.fromkeys(values))


@dataclass(frozen=True)
class ForcesTable:
    """[forces]: given pin forces in place of an engine."""

    pin_N: tuple[float, ...]

    def pin(self) -> tuple[float, float]:
        """Return (axial, transverse), N, tension positive."""
        require(len(self.pin_N) == 2, "forces.pin_N", list(self.pin_N), "must be [axial, transverse]")
        axial, transverse = (require_number("forces.pin_N", value) for value in self.pin_N)
        require(axial != 0 or transverse != 0, "forces.pin_N", list(self.pin_N), "must not vanish")
        return axial, transverse


@dataclass(frozen=True)
class MeshTable:
    """[mesh]."""

    size_mm: float | None = None
    element: Element = Element.P2

    def __post_init__(self) -> None:
        """Refuse a size that is none."""
        if self.size_mm is not None:
            require_positive("mesh.size_mm", self.size_mm)


@dataclass(frozen=True)
class AnalysisTable:
    """[analysis]."""

    support: Support = Support.INERTIA_RELIEF
    symmetry: Symmetry = Symmetry.AUTO
    pressure: str = "cosine-180"
    solver: SolverName = SolverName.AUTO
    tolerance_percent: float | None = None
    min_safety: float | None = None
    cycle: bool = False
    fatigue: Fatigue = Fatigue.GOODMAN
    buckling: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        BorePressure.parse(self.pressure)
        if self.min_safety is not None:
            require_positive("analysis.min_safety", self.min_safety)
        if self.tolerance_percent is not None:
            require_positive("analysis.tolerance_percent", self.tolerance_percent)


@dataclass(frozen=True)
class OutputTable:
    """[output]."""

    directory: str | None = None
    screenshot: bool = False
    animate: str | None = None


@dataclass(frozen=True)
class Study:
    """Everything a run is asked.

    Attributes
    ----------
    name
        Of the shipped study or the file.
    part_material
        [material.<part>] by the part's name: a bushing, or a solid of a STEP file.
    rod, material, engine, speed, forces, mesh, analysis, output
        The tables of the study file, in engineering units.
    folder
        Where relative paths in the study start.
    """

    name: str
    rod: RodTable
    material: MaterialTable = field(default_factory=lambda: MaterialTable(preset="leon-2001"))
    part_material: Mapping[str, MaterialTable] = field(default_factory=dict)
    engine: EngineTable | None = None
    speed: SpeedTable = field(default_factory=SpeedTable)
    forces: ForcesTable | None = None
    mesh: MeshTable = field(default_factory=MeshTable)
    analysis: AnalysisTable = field(default_factory=AnalysisTable)
    output: OutputTable = field(default_factory=OutputTable)
    folder: Path = field(default_factory=Path.cwd)

    def __post_init__(self) -> None:
        """Check every value now, before anything is computed."""
        self.material.material()
        for table in self.part_material.values():
            table.material()
        self.speed.speeds()
        if self.output.directory is not None:
            located("output.directory", self.output.directory, self.folder)
        if self.output.animate is not None:
            located("output.animate", self.output.animate, self.folder)
        if self.forces is not None:
            given = list(self.forces.pin_N)
            require(self.engine is None, "forces.pin_N", given, "stand in place of an engine", "Remove one.")
            rule = "needs an [engine]: given forces have no crank cycle"
            require(not self.analysis.cycle, "analysis.cycle", "true", rule)
            self.forces.pin()

    def require_balance(self) -> None:
        """See to it that something takes up a given transverse force; flags may still change the support.

        Raises
        ------
        InvalidValue
            Nothing does.
        """
        if self.forces is not None and self.analysis.support is not Support.CLAMPED:
            _, transverse = self.forces.pin()
            rule = "has a transverse part, which nothing balances under inertia relief"
            remedy = 'Say support = "clamped", or leave the transverse part out.'
            require(transverse == 0, "forces.pin_N", list(self.forces.pin_N), rule, remedy)

    def materials(self, parts: Iterable[str]) -> tuple[Material, ...]:
        """Return the material of each part; those without a table of their own are of [material].

        Raises
        ------
        InvalidValue
            A table names a part that the rod does not have.
        """
        names = list(parts)
        for part in self.part_material:
            remedy = f"Its parts: {', '.join(names)}."
            require(part in names, f"material.{part}", "", "is no part of this rod", remedy)
        return tuple(self.part_material.get(name, self.material).material() for name in names)

    def as_dict(self) -> dict[str, dict[str, Any]]:
        """Return the tables that say something, with plain values, as a study file holds them."""
        parts = {part: entries_of(table.resolved()) for part, table in self.part_material.items()}
        tables = {"rod": self.rod.as_dict(), "material": entries_of(self.material.resolved()) | parts}
        for name in ("engine", "speed", "forces", "mesh", "analysis", "output"):
            table = getattr(self, name)
            if table is not None and not (name == "speed" and self.engine is None):
                tables[name] = entries_of(table)
        return tables

    def text(self) -> str:
        """Return the study as a TOML file that runs again and gives the same."""
        return toml_text(self.as_dict())


TABLES: Mapping[str, type[Any]] = {
    "material": MaterialTable,
    "engine": EngineTable,
    "speed": SpeedTable,
    "forces": ForcesTable,
    "mesh": MeshTable,
    "analysis": AnalysisTable,
    "output": OutputTable,
}


def shipped_studies() -> tuple[str, ...]:
    """Return the names of the studies that come with the package."""
    folder = resources.files("fea") / "studies"
    return tuple(sorted(entry.name[:-5] for entry in folder.iterdir() if entry.name.endswith(".toml")))


def load_study(source: str | Path = DEFAULT_STUDY) -> Study:
    """Load a shipped study by name or a TOML file by path.

    Raises
    ------
    InvalidValue
        No such study, TOML that does not parse, an unknown key, or a value that breaks a rule.
    """
    require(isinstance(source, str | Path), "STUDY", source, "must be a name or a path")
    source = str(source)
    if source in shipped_studies():
        text = (resources.files("fea") / "studies" / f"{source}.toml").read_text(encoding="utf-8")
        return parse_study(text, source, Path.cwd())
    path = Path(source)
    if not is_file(path):
        remedy = nearest(source, shipped_studies())
        raise InvalidValue("STUDY", source, "is neither a shipped study nor a file", remedy)
    require_text("STUDY", source)
    try:
        require_size("STUDY", path, LARGEST_STUDY)
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidValue("STUDY", source, f"cannot be read ({error})") from error
    return parse_study(text, path.stem, path.resolve().parent)


def parse_study(text: str, name: str, folder: Path) -> Study:
    """Parse the text of a study file.

    Raises
    ------
    InvalidValue
        See `load_study`.
    """
    rule = "nests its keys deeper than any study"
    require(_NESTED.search(text) is None, "STUDY", name, rule, "Tables have one level, or two for parts.")
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # of a number with too many digits a plain ValueError
        raise InvalidValue("STUDY", f"{name}.toml", f"is not valid TOML: {error}") from error
    for key in raw:
        if key != "rod" and key not in TABLES:
            raise unknown_key(f"{name}.toml:", key, ["rod", *TABLES])
    require("rod" in raw, "STUDY", name, "has no [rod] table", 'Give dimensions or preset = "leon-2001".')
    raw, part_material = _parted(raw)
    tables = {key: read_table(cls, key, raw[key]) for key, cls in TABLES.items() if key in raw}
    rod = read_rod(raw["rod"], folder)
    if "engine" in tables:
        tables["engine"] = tables["engine"].located(folder)
    return Study(name, rod, part_material=part_material, folder=folder, **tables)


def _parted(raw: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, MaterialTable]]:
    """Take the [material.<part>] tables out of [material]."""
    material = raw.get("material")
    if not isinstance(material, Mapping):
        return dict(raw), {}
    parts = {key: value for key, value in material.items() if isinstance(value, Mapping)}
    rest = {key: value for key, value in material.items() if key not in parts}
    tables = {key: read_table(MaterialTable, f"material.{key}", value) for key, value in parts.items()}
    left = {key: value for key, value in raw.items() if key != "material"}
    return (left | {"material": rest} if rest else left), tables
