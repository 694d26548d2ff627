"""A study: the complete input of a run, from a shipped study or a TOML file."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Unpack

from fea.base import choices
from fea.base.material import Material
from fea.base.note import Note, assumption
from fea.base.shipped import TomlTable, shipped_names, shipped_toml
from fea.study.assembly_table import BOLT, BUSHING, SHELL, AssemblyTable
from fea.study.changes import (
    TABLES,
    Changes,
    changed_fields,
    parted,
    python_words,
    switched_on,
    with_own_units,
)
from fea.study.defect_table import DefectTable
from fea.study.engine_library import engine_preset
from fea.study.engine_table import EngineTable, with_implied_gas, with_preset
from fea.study.files import (
    beside,
    is_file,
    located,
    parse_toml,
    read_toml,
    ready_study,
    require_text,
    toml_text,
)
from fea.study.film_table import FilmTable
from fea.study.material_table import ASSUMED_PARTS, MaterialTable, bolt_material, table_name
from fea.study.option_tables import (
    PINS,
    AnalysisTable,
    ContactTable,
    ForcesTable,
    GaugeTable,
    MeshTable,
    OptimiseTable,
    OutputTable,
    read_gauges,
)
from fea.study.overload_table import OverloadTable
from fea.study.pin_models import PARTS
from fea.study.plausibility import ImplausibleValue, implausible_values, magnitudes, spared
from fea.study.rod_table import RodTable, read_rod, rod_of_file
from fea.study.scatter_table import ScatterTable
from fea.study.speed_tables import DEFAULT_RPM, DutyTable, SpeedTable
from fea.study.tables import entries_of, nearest, read_table, unknown_key, with_units
from fea.study.two_stroke import BIG
from geometry.errors import InvalidValue, require
from geometry.imports import is_cad, require_readable
from mesh.files.tets import is_mesh, require_known

DEFAULT_STUDY = "leon-2001"
# Where a study says nothing of the material.
ASSUMED_MATERIAL = MaterialTable(preset="leon-2001")
# Speeds that differ by more are not of one engine: 6000,5 has a decimal comma.
_ONE_SERIES = 100.0


@dataclass(frozen=True)
class Study:
    """The complete input of a run: the tables of the study file, in engineering units."""

    name: str  #: of the shipped study or of the file
    rod: RodTable
    material: MaterialTable = ASSUMED_MATERIAL
    #: [material.<part>] by the part's name: a bushing, a solid of a STEP file, or a pin
    part_material: Mapping[str, MaterialTable] = field(default_factory=dict)
    engine: EngineTable | None = None
    speed: SpeedTable = field(default_factory=SpeedTable)
    duty: DutyTable | None = None
    scatter: ScatterTable | None = None
    overload: OverloadTable | None = None
    forces: ForcesTable | None = None
    mesh: MeshTable = field(default_factory=MeshTable)
    analysis: AnalysisTable = field(default_factory=AnalysisTable)
    contact: ContactTable = field(default_factory=ContactTable)
    film: FilmTable = field(default_factory=FilmTable)
    defect: DefectTable = field(default_factory=DefectTable)
    assembly: AssemblyTable | None = None
    optimise: OptimiseTable | None = None
    output: OutputTable = field(default_factory=OutputTable)
    gauge: tuple[GaugeTable, ...] = ()
    folder: Path = field(default_factory=Path.cwd)  #: where relative paths in the study start

    def __post_init__(self) -> None:
        self.material.material()
        for part, table in self.part_material.items():
            if part == BOLT and self.assembly is not None:
                bolt_material(self.part_material, self.assembly.grade).material()
            else:
                table.stiffness() if part in PINS else table.material()
        self.speed.speeds()
        if self.duty is not None:
            self._require_cycle(self.duty)
        if self.rod.mesh is not None:
            self._require_no_remeshing()
        rule = "has no effect where the mesh is not refined"
        remedy = "Leave it out, or the element size and --tolerance 0."
        refined = self.tolerance_percent is not None
        require(refined or not self.analysis.draft, "analysis.draft", "true", rule, remedy)
        if self.assembly is not None:
            self._require_parts(self.assembly)
        for name, path in (("directory", self.output.directory), ("animate", self.output.animate)):
            if path is not None:
                located(f"output.{name}", path, self.folder)
        over_cycle = {"output.pvd_step_deg": self.output.pvd_step_deg, "defect.size": self.defect.size}
        for name, value in over_cycle.items():
            rule = "has no effect without the crank cycle"
            require(value is None or self.analysis.cycle, name, value, rule, "Add --cycle.")
        self._require_film()
        _ = self.defect.size and self.defect.metal(self.material)  # which may not be known
        if self.forces is not None:
            given = list(self.forces.pin_N)
            rule, remedy = "cannot be combined with [engine]", "Remove one of them."
            require(self.engine is None, "forces.pin_N", given, rule, remedy)
            rule = "cannot be combined with [scatter], whose lives are those of crank cycles"
            require(self.scatter is None, "forces.pin_N", given, rule, remedy)
            rule = "cannot be used with [forces], which have no crank cycle"
            require(not self.analysis.cycle, "analysis.cycle", "true", rule, "Give an [engine] instead.")
            rule = "cannot be combined with forces.ratio: a fatigue test counts cycles, and has no speed"
            alone = self.forces.levels() is None or self.speed.rpm is None
            require(alone, "speed.rpm", str(self.speed.rpm), rule, "Remove [speed].")

    def _require_cycle(self, duty: DutyTable) -> None:
        if duty.rpm is not None:
            SpeedTable(duty.speeds).speeds()
        rule, remedy = "cannot be used with [forces], which have no crank cycle", "Give an [engine] instead."
        name, value = ("duty.log", duty.log) if duty.rpm is None else ("duty.rpm", list(duty.rpm))
        require(self.forces is None, name, value, rule, remedy)
        rule = "cannot be switched off with [duty], whose life is that of crank cycles"
        require(self.analysis.cycle, "analysis.cycle", "false", rule, "Leave it out, or remove [duty].")

    def _require_film(self) -> None:
        if self.analysis.film:
            self.require_film("analysis.film", "true")
        elif self.analysis.needs_film:
            self.require_film("analysis.pressure", str(self.analysis.pressure))

    def require_film(self, name: str, value: float | str) -> None:
        """Raise `InvalidValue`, by the name and value of what asks for an oil film: it cannot be computed."""
        clamped = self.analysis.support is choices.Support.CLAMPED
        rolling = self.engine is not None and BIG in self.engine.roller_bearings
        for excluded, rule in (
            (self.forces is not None, "cannot be used with [forces], which have no crank cycle"),
            (clamped, 'cannot be combined with support = "clamped", which replaces the crank pin'),
            (rolling, "cannot be computed where the big end runs on rollers (engine.roller_bearings)"),
        ):
            require(not excluded, name, value, rule, "Leave out the film, or that.")

    def _require_no_remeshing(self) -> None:
        """Refuse what only a mesh of our own can have: another element size, refinement, a symmetry cell."""
        rule = "cannot be combined with rod.mesh: a mesh from a file is solved as it is, without refinement"
        remedy = "Leave it out; for other elements give the solid as rod.step, or a finer mesh."
        size, tolerance, symmetry = self.mesh.size_mm, self.analysis.tolerance_percent, self.analysis.symmetry
        require(size is None, "mesh.size_mm", size, rule, remedy)
        require(not tolerance, "analysis.tolerance_percent", tolerance, rule, remedy)
        whole = symmetry in (choices.Symmetry.AUTO, choices.Symmetry.NONE)
        rule = "cannot be combined with rod.mesh: a mesh from a file is solved as a whole"
        require(whole, "analysis.symmetry", symmetry, rule, "Leave it out.")

    def _require_parts(self, assembly: AssemblyTable) -> None:
        rule = "cannot be combined with [assembly], whose parts must be solids of their own"
        remedy = "Give the rod by dimensions or as a CAD file, or remove [assembly]."
        path = None if self.rod.mesh is None else str(self.rod.mesh.path)
        require(self.rod.mesh is None, "rod.mesh", path, rule, remedy)
        pressure, remedy = self.analysis.pressure, f'Leave it out, or use pressure = "{choices.CONTACT}".'
        rule = "cannot be combined with [assembly], whose parts and pins press on each other by contact"
        require(pressure in (None, *PARTS), "analysis.pressure", pressure, rule, remedy)
        if self.rod.dimensions is not None:
            assembly.require_dimensions(self.rod.dimensions)

    def require_loading(self) -> None:
        """Refuse a study in which nothing loads the rod, or nothing balances the load.

        Raises `InvalidValue`: there is neither an engine nor a force, or a transverse force that nothing
        balances, or the log of a duty cannot be read.
        """
        _ = self.duty and self.duty.entries  # a log is read before anything is meshed
        if self.forces is None:
            self.require_engine()
        elif self.analysis.support is not choices.Support.CLAMPED:
            _, transverse = self.forces.pin()
            rule = "the transverse component has no reaction under inertia relief"
            remedy = 'Use support = "clamped", or set the transverse component to 0.'
            require(transverse == 0, "forces.pin_N", list(self.forces.pin_N), rule, remedy)

    def unusual(self, measured: Mapping[str, float] | None = None) -> list[ImplausibleValue]:
        """Values outside engines' ranges, the gravest first; `measured`: a file's lengths by key."""
        lengths = dict(measured or {}) if self.rod.from_file else {}
        values = {**self._magnitudes(), **lengths}
        speeds = [rpm for rpm in self.speeds() if rpm]
        extremes: list[float | None] = [max(speeds)] if speeds else [None]
        if speeds and min(speeds) < max(speeds) / _ONE_SERIES:
            extremes.append(min(speeds))
        worst: dict[str, ImplausibleValue] = {}
        for rpm in extremes:
            at = values if rpm is None else {**values, "speed.rpm": rpm}
            for finding in implausible_values(at, frozenset(lengths)):
                worst.setdefault(finding.key, finding)
        return sorted(worst.values(), key=lambda finding: not finding.refused)

    def _magnitudes(self) -> dict[str, float]:
        tables: TomlTable = {} if self.rod.from_file else {"rod": self.rod.as_dict()}
        for name in TABLES.keys() - {"rod", "material"}:
            tables[name] = entries_of(getattr(self, name)) if getattr(self, name) else {}
        tables["material"] = vars(self.material.resolved())
        tables |= {f"material.{part}": vars(table.resolved()) for part, table in self.part_material.items()}
        return magnitudes(tables)

    def unusual_notes(self, measured: Mapping[str, float] | None = None) -> tuple[Note, ...]:
        """Return a note on each value outside of the ranges of engines; `measured` as of `unusual`."""
        return tuple(finding.note for finding in self.unusual(measured))

    def require_plausible(self, measured: Mapping[str, float] | None = None) -> None:
        """Refuse values far outside of the ranges of engines, unless the study insists on them.

        Raises `InvalidValue`: a value is so far outside that it must be in another unit than its key says.
        """
        refused = [finding for finding in self.unusual(measured) if finding.refused]
        if refused and not self.analysis.unusual:
            value = float(f"{refused[0].value:.4g}")
            remedy = "Correct it; to insist, give --unusual, or unusual = true in [analysis]."
            raise InvalidValue(refused[0].key, value, refused[0].text, remedy)

    def require_engine(self) -> EngineTable:
        """Return the engine; raises `InvalidValue`: there is none."""
        if self.engine is not None:
            return self.engine
        rule, remedy, example = "has neither [engine] nor [forces]", "Add one of them.", ""
        if self.forces is not None:
            rule, remedy = "has no [engine], so there is no crank cycle", "Given forces are for fea run."
        elif self.rod.from_file:
            remedy, example = ready_study(self.name, self.rod.as_dict())
        raise InvalidValue("STUDY", self.name, rule, remedy, example)

    @property
    def tolerance_percent(self) -> float | None:
        """Error bar, percent, to which the mesh is refined; None where it is made once.

        Without a value, the tolerance is `CONVERGED_PERCENT`, unless an element size or first-order elements
        are asked for: that is the mesh that is wanted. A mesh from a file is never refined.
        """
        given, mesh = self.analysis.tolerance_percent, self.mesh
        if self.rod.mesh is not None:
            return None
        if given is None and mesh.size_mm is None and mesh.element is choices.Element.P2:
            return choices.CONVERGED_PERCENT
        return given or None

    def speeds(self) -> tuple[float | None, ...]:
        """Return the speeds, rpm; None alone where forces are given instead of an engine."""
        return (None,) if self.engine is None else self.engine_speeds(self.engine)

    def engine_speeds(self, engine: EngineTable) -> tuple[float, ...]:
        """Return the speeds, rpm: of [speed], or of [duty], or the redline of a library's engine, or 6000."""
        if self.speed.rpm is None and self.duty is not None:
            return SpeedTable(self.duty.run_speeds).speeds()
        preset = engine.library()
        return self.speed.speeds(DEFAULT_RPM if preset is None else preset.redline_rpm)

    def with_engine(self, name: str) -> "Study":
        """Return the study with a library engine. Raises `InvalidValue`: unknown, or forces are given."""
        preset = engine_preset(name, "--engine")
        return replace(self, engine=EngineTable(**preset.entries(), preset=preset.name))

    def with_(self, **changes: Unpack[Changes]) -> "Study":
        """Return the study with other tables; each is checked as in a study file, and the rest stays.

        A table is changed by its keys, ``rod={"length": "5.7 in"}``, of which None takes one away; replaced
        by a name (material, engine), by speeds (a number, a text with a unit, several) or by an object of it;
        and taken away by None; ``gauge`` by a list of tables. Files are relative to the current directory.
        Raises `InvalidValue`: a table or a key is unknown, or a value breaks a rule.

        Examples
        --------
        >>> from fea import load_study
        >>> study = load_study("leon-2001").with_(rod={"web_thickness": "0.2 in"}, material="4340")
        >>> study.rod.dimensions.web_thickness, study.material.preset
        (5.08, '4340')
        >>> study.with_(speed="100 Hz", analysis={"cycle": True}).speeds()
        (6000.0,)
        """
        with python_words():
            study = replace(self, **changed_fields(self, changes))
            rule, remedy = "cannot be used with [forces], which have no speed", "Give forces=None, too."
            loose = study.forces is None or changes.get("speed") is None
            require(loose, "speed", str(changes.get("speed")), rule, remedy)
            return study

    def with_rod(self, **dimensions: Any) -> "Study":
        """Return the study with other dimensions of its rod, by the keys of [rod]: a short `with_`.

        Raises `InvalidValue`: the rod has no dimensions, or one of those given is unknown or breaks a rule.

        Examples
        --------
        >>> from fea import load_study
        >>> load_study("leon-2001").with_rod(web_thickness_mm=5.0).rod.dimensions.web_thickness
        5.0
        """
        return replace(self, rod=self.rod.with_dimensions(dimensions))

    def materials(self, parts: Iterable[str]) -> tuple[Material, ...]:
        """Return the material of each part, by `part_material_table`. Raises `InvalidValue`: no such part."""
        names = list(parts)
        allowed = {*names, *PINS}
        if self.assembly is not None:
            allowed |= {BOLT, *map(table_name, names)}
        for part in self.part_material.keys() - allowed:
            remedy = f"The parts of this rod are: {', '.join(names)}."
            raise InvalidValue(f"[material.{part}]", None, "does not name a part of this rod", remedy)
        tables = [self.part_material_table(name) for name in names]
        linings = [table_name(name) in (BUSHING, SHELL) for name in names]
        return tuple(
            replace(table.material(), lining=lines and table is not self.material)
            for table, lines in zip(tables, linings, strict=True)
        )

    def part_material_table(self, part: str) -> MaterialTable:
        """Return the table of a part's material: its own, or that of [material].

        In an assembly, bushing and bearing shells without a table are of their usual materials.
        """
        if self.assembly is None:
            return self.part_material.get(part, self.material)
        name = table_name(part)
        assumed = MaterialTable(preset=ASSUMED_PARTS[name]) if name in ASSUMED_PARTS else self.material
        return self.part_material.get(part, self.part_material.get(name, assumed))

    @property
    def material_notes(self) -> tuple[Note, ...]:
        """A note if the material is assumed."""
        if self.material is not ASSUMED_MATERIAL:
            return ()
        table = self.material.resolved()
        text = (
            f"assumed {self.material.preset}, {table.E_GPa:g} GPa, {table.density_kg_m3:g} kg/m³, "
            f"yield strength {table.yield_MPa:g} MPa ([material] or --material)"
        )
        return (assumption(text, "material"),)

    @property
    def pin_stiffness(self) -> dict[str, tuple[float, float]]:
        """Young's modulus, MPa, and Poisson's ratio of the pins whose material is given, by their names."""
        return {name: self.part_material[name].stiffness() for name in PINS if name in self.part_material}

    def as_dict(self) -> TomlTable:
        """Return the tables that say something, with plain values, as a study file holds them."""
        parts = {part: entries_of(table.resolved()) for part, table in self.part_material.items()}
        tables = {"rod": self.rod.as_dict(), "material": entries_of(self.material.resolved()) | parts}
        used = {
            "speed": self.engine is not None and (self.speed.rpm is not None or self.duty is None),
            "contact": self.in_contact,
            "film": self.analysis.needs_film,
            "defect": self.defect != DefectTable(),
            "mesh": self.rod.mesh is None,
        }
        for name in TABLES:
            table = getattr(self, name)
            if name == "speed" and self.engine is not None and self.speed.rpm is None and self.duty is None:
                table = SpeedTable(self.engine_speeds(self.engine)[0])
            if name not in tables and used.get(name, True) and table is not None:
                tables[name] = entries_of(table.resolved() if name == "engine" else table)
        return tables | ({"gauge": [entries_of(each) for each in self.gauge]} if self.gauge else {})

    @property
    def in_contact(self) -> bool:
        """Whether a pin touches its bore, or parts touch each other."""
        return self.analysis.in_contact or self.assembly is not None

    def text(self) -> str:
        """Return the study as a TOML file that runs again and gives the same."""
        tables = self.as_dict()
        return toml_text(with_units(tables) if spared(self._magnitudes()) else tables)


def shipped_studies() -> tuple[str, ...]:
    """Return the names of the studies that come with the package."""
    return shipped_names("studies")


def load_study(source: str | Path = DEFAULT_STUDY) -> Study:
    """Load a shipped study by name, or a TOML file, a CAD file or a mesh by path.

    A CAD file or a mesh is a study that gives the rod alone. Raises `InvalidValue`: no such study, TOML that
    does not parse, an unknown key, or a value that breaks a rule.
    """
    require(isinstance(source, str | Path), "STUDY", source, "must be a name or a path")
    source = str(source)
    if source in shipped_studies():
        return study_of_tables(shipped_toml(f"studies/{source}.toml"), source, Path.cwd())
    path = Path(source)
    if (is_cad(path) or is_mesh(path)) and is_file(path):
        require_text("STUDY", source)
        return Study(path.stem, rod_of_file(path.resolve()))
    require_readable("STUDY", path)
    require_known("STUDY", path)
    if not is_file(path):
        if path.suffix:
            raise InvalidValue("STUDY", source, "is not an existing file", beside(path))
        remedy = nearest(source, shipped_studies())
        raise InvalidValue("STUDY", source, "is neither a shipped study nor an existing file", remedy)
    require_text("STUDY", source)
    return study_of_tables(read_toml("STUDY", path), path.stem, path.resolve().parent)


def parse_study(text: str, name: str, folder: Path) -> Study:
    """Parse the text of a study file; raises `InvalidValue`: see `load_study`."""
    return study_of_tables(parse_toml("STUDY", f"{name}.toml", text), name, folder)


def study_of_tables(raw: Mapping[str, Any], name: str, folder: Path) -> Study:
    """Return a study from the tables of its file; errors as `parse_study`."""
    for key in raw:
        if key not in (*TABLES, "gauge"):
            raise unknown_key(f"{name}.toml:", key, (*TABLES, "gauge"))
    remedy = 'Add one with dimensions or with preset = "leon-2001".'
    require("rod" in raw, "STUDY", name, "has no [rod] table", remedy)
    raw, part_material = parted(switched_on(with_own_units(raw)))
    if "engine" in raw:
        raw["engine"] = with_implied_gas(with_preset(raw["engine"]))
    given = [key for key in TABLES if key in raw and key != "rod"]
    tables = {key: read_table(TABLES[key], key, raw[key]) for key in given}
    rod = _rod(raw, folder)
    for key in ("engine", "duty"):
        if key in tables:
            tables[key] = tables[key].located(folder)
    gauges = read_gauges(raw.get("gauge", []))
    return Study(name, rod, part_material=part_material, gauge=gauges, folder=folder, **tables)


def _rod(raw: Mapping[str, Any], folder: Path) -> RodTable:
    """Read [rod]; where its dimensions go together in another unit only, the message names it."""
    try:
        return read_rod(raw["rod"], folder)
    except InvalidValue as error:
        found = [each for each in implausible_values(magnitudes(raw)) if each.unit and each.key[:4] == "rod."]
        if not found or not isinstance(error.value, float):
            raise
        remedy = f"{found[0].key} = {found[0].value:g} {found[0].unit}. {error.remedy}".strip()
        raise InvalidValue(error.name, error.value, error.rule, remedy) from error
