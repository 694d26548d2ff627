"""[material] of a study, and the library of materials: `materials.toml`, and bolts by their grades."""

import difflib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from statistics import linear_regression

import numpy as np

from fea.base.choices import BoltGrade, Finish, Loading
from fea.base.material import (
    MEDIAN,
    YIELD_STRAIN,
    Basquin,
    CoffinManson,
    Marin,
    Material,
    SurfaceFinish,
    estimated_cyclic_yield,
    estimated_endurance,
    finish_factor,
    hardness_of,
    is_steel,
    load_factor,
    size_factor,
)
from fea.base.shipped import TomlTable, shipped_toml
from fea.base.units import GPA, KG_M3
from fea.study.assembly_table import BOLT, BUSHING, SHELL, SHELLS, bolt_strength, grade_source
from fea.study.tables import Positive, StudyTable, entries_of, key, within
from geometry.errors import InvalidValue, require, require_positive


@dataclass(frozen=True)
class LibraryMaterial:
    """A material of the library."""

    name: str
    title: str  #: what it is
    also: tuple[str, ...]  #: other names
    figures: Mapping[str, float]  #: by the keys of [material]
    sources: Mapping[str, str]  #: where figures come from, by those keys; also of what could not be found

    @property
    def source(self) -> str:
        """The sources as one text: each, with its figures where there are several."""
        by_text: dict[str, list[str]] = {}
        for name, text in self.sources.items():
            by_text.setdefault(text, []).append(name)
        several = len(by_text) > 1
        return " ".join(f"{', '.join(keys)}: {text}" if several else text for text, keys in by_text.items())


def _materials() -> Iterator[LibraryMaterial]:
    for name, table in shipped_toml("study/materials.toml").items():
        yield from _variants(name, table)
    for grade in BoltGrade:
        least, name = bolt_strength(grade, 0.0), f"bolt-{grade}"
        figures = {"E_GPa": 205.0, "nu": 0.30, "density_kg_m3": 7850.0}
        strengths = {"yield_MPa": least.yield_strength, "ultimate_MPa": least.ultimate}
        sources = dict.fromkeys(figures | strengths, grade_source(grade))
        yield LibraryMaterial(name, f"Bolt, {grade}", (), figures | strengths, sources)


def _variants(name: str, table: TomlTable) -> Iterator[LibraryMaterial]:
    title, also, source, usual = (table.pop(key, "") for key in ("title", "also", "source", "usual"))
    variants = table.pop("variants", {"": {}})
    if table.pop("interpolate", False):
        # At every whole hardness, linear between those that are given, MPa without decimals.
        given = {int(hardness): figures for hardness, figures in variants.items()}
        tested = sorted(given)
        for hardness in set(range(tested[0], tested[-1])) - given.keys():
            figures = {key: [given[each][key] for each in tested] for key in given[tested[0]]}
            variants[str(hardness)] = {
                key: float(round(np.interp(hardness, tested, values))) for key, values in figures.items()
            }
        variants = {hardness: variants[hardness] for hardness in sorted(variants)}
    by_figure = source if isinstance(source, dict) else {", ".join(table): source}
    sources = {key: text for keys, text in by_figure.items() for key in keys.split(", ")}
    for variant, figures in variants.items():
        names = tuple(also) if variant == usual else ()
        full_name = f"{name}-{variant}" if variant else name
        yield LibraryMaterial(full_name, title, names, table | figures, sources)


LIBRARY = {material.name: material for material in _materials()}
# As names are compared: without regard to case, blanks and hyphens.
_IGNORED = str.maketrans("", "", " -_")


def _plain(name: str) -> str:
    return name.casefold().translate(_IGNORED)


_BY_NAME = {_plain(name): each for each in LIBRARY.values() for name in (*each.also, each.name)}


def library_material(where: str, name: str) -> LibraryMaterial:
    """Return a material by one of its names; `where` names the key. Raises `InvalidValue`: unknown name."""
    if material := _BY_NAME.get(_plain(name)):
        return material
    near = difflib.get_close_matches(_plain(name), _BY_NAME, n=3, cutoff=0.5)
    names = ", ".join(dict.fromkeys(_BY_NAME[plain].name for plain in near))
    remedy = f"Did you mean {names}? " if near else ""
    raise InvalidValue(where, name, "is not in the library", f"{remedy}`fea materials` lists all names.")


_LINE = ("fatigue_strength_coefficient_MPa", "fatigue_strength_exponent")
_TESTS = ("sn_cycles", "sn_amplitude_MPa")
_DUCTILITY = ("fatigue_ductility_coefficient", "fatigue_ductility_exponent")
_CURVE = ("cyclic_strength_coefficient_MPa", "cyclic_strength_exponent")
SN_KEYS = (*_LINE, *_TESTS)
# Of metals b is −0.05 to −0.15; a line that is flatter or steeper than these has another unit or sign.
_FLATTEST, _STEEPEST = -0.02, -0.5


def fitted(cycles: tuple[float, ...], amplitudes: tuple[float, ...]) -> Basquin:
    """Fit Basquin's line to broken specimens (ASTM E739). `InvalidValue`: too few, or not falling."""
    same, rule = len(cycles) == len(amplitudes), f"must have as many values as sn_cycles ({len(cycles)})"
    require(same, "material.sn_amplitude_MPa", list(amplitudes), rule)
    several, rule = len(set(amplitudes)) > 1, "must contain two amplitudes that differ, or more"
    require(several, "material.sn_amplitude_MPa", list(amplitudes), rule)
    # ln N = ln σ_a / b + level, and σ_a = σ_f′ (2N)^b.
    steepness, level = linear_regression(np.log(amplitudes), np.log(cycles))
    rule = "must fall as sn_amplitude_MPa rises"
    require(steepness < 0, "material.sn_cycles", list(cycles), rule, "Check the order of both lists.")
    exponent = 1 / float(steepness)
    _require_slope("sn_cycles", list(cycles), exponent)
    return Basquin(math.exp(-exponent * (level + math.log(2))), exponent)


def _require_slope(key: str, value: object, exponent: float) -> None:
    given = "" if value == exponent else f"gives an exponent of {exponent:.3g}, which "
    rule = f"{given}must lie between {_STEEPEST:g} and {_FLATTEST:g}"
    require(_STEEPEST <= exponent <= _FLATTEST, f"material.{key}", value, rule, "Check its sign and units.")


# Finishes of forgings and rolled bars, of which the bores and the faces beside them are machined.
_RAW = (Finish.HOT_ROLLED, Finish.AS_FORGED, Finish.SHOT_PEENED)
_PEENED = (Finish.SHOT_PEENED, Finish.MACHINED_PEENED)
_REMEDY = "Give it or a preset in [material]."
# Larger gains than this are known of surface treatments of sharply notched parts only.
_LARGEST_FACTOR = 2.0


@dataclass(frozen=True)
class MaterialTable(StudyTable, table="material"):
    """[material]: a preset's name, or the constants; constants override those of a preset.

    `size_mm`, `loading` and `reliability_percent` convert limits of specimens into limits of the part, and so
    does the finish of its surface. The S–N line, for the life over a [duty], is given by σ_f′ and b or tests.
    """

    E_GPa: float | None = key("207.0", "Young's modulus", stated=True)
    nu: float | None = key("0.28", "Poisson's ratio", stated=True)
    density_kg_m3: float | None = key("7700.0", stated=True)
    yield_MPa: float | None = key("620.4", stated=True)
    cyclic_yield_MPa: Positive | None = key(
        "480.0", "0.2 % yield strength in repeated loading; default: by the ultimate strength"
    )
    cyclic_strength_coefficient_MPa: Positive | None = key(
        "1655.0", "instead: K' of the cyclic curve K' e^n'", needs=_CURVE[1]
    )
    cyclic_strength_exponent: float | None = key("0.131", "n' of that curve", within(0, 1), needs=_CURVE[0])
    ultimate_MPa: float | None = key("723.8", "needed for fatigue (cycle = true)")
    endurance_MPa: Positive | None = key(
        "360.0", "of polished specimens, fully reversed tension; default for steel: 0.425 times the ultimate"
    )
    endurance_cycles: float | None = key(
        "5e8", "for which that limit holds, of a metal without a true one, as aluminium", within(1e4, 1e11)
    )
    endurance_torsion_MPa: float | None = key(
        "220.0", "for Crossland's criterion; default: 0.60 of the limit in tension"
    )
    surface: Finish | float | None = key(
        '"machined"',
        'factor on the endurance limit: "polished", "ground", "machined" (bar stock), "hot-rolled", '
        '"as-forged", "shot-peened" (a cleaned forging: the default), "machined-peened" (a bar that is '
        "machined and peened), or a number, as 0.7",
    )
    bore_surface: Finish | float | None = key(
        '"machined"', "on the bores; machined where surface is that of a raw forging or bar"
    )
    face_surface: Finish | float | None = key('"machined"', "on the faces beside the bores, likewise")
    size_mm: float | None = key("20.0", "diameter of an equivalent round section in bending: reduces it too")
    loading: Loading | None = key(
        '"axial"', '0.85 for a limit measured in bending, as an estimated one is; or "bending": 1'
    )
    reliability_percent: float | None = key("99.0", "reduces it too; default: 50, the median of tests")
    fatigue_strength_coefficient_MPa: Positive | None = key(
        "1188.0", "S-N line of polished specimens, S (2N)^b: needed for [duty]", needs=_LINE[1]
    )
    fatigue_strength_exponent: float | None = key("-0.0711", "b of that line", needs=_LINE[0])
    sn_cycles: tuple[Positive, ...] | None = key(
        "[2.0e4, 1.0e5, 5.0e5]",
        "instead of both: specimens that broke, fully reversed, after these cycles",
        needs=_TESTS[1],
    )
    sn_amplitude_MPa: tuple[Positive, ...] | None = key(
        "[560, 500, 445]", "at these amplitudes", needs=_TESTS[0]
    )
    fatigue_ductility_coefficient: Positive | None = key(
        "0.6",
        "plastic strain over life, e (2N)^c, for lives below 10⁴ cycles; default: estimated",
        needs=_DUCTILITY[1],
    )
    fatigue_ductility_exponent: float | None = key(
        "-0.6", "c of that line", within(-1.0, -0.3), needs=_DUCTILITY[0]
    )
    support: bool | None = key(
        "false",
        "whether the gradient of stress supports the surface (FKM); default: of steel, without size_mm",
    )
    hardness_HV: float | None = key(
        "320.0", "Vickers, of a low-alloy steel, for defects; default: by the ultimate", within(80, 700)
    )
    thermal_expansion_1_K: float | None = key(
        "11.5e-6", "for an assembly's temperature; default: that of the metal"
    )
    preset: str | None = key(
        '"leon-2001"',
        '"4340" (36 HRC), "4340-hrc-42", "300M", "EN24T", "C70S6", "42CrMo4", "Ti-6Al-4V", "7075-T6", …: '
        "`fea materials` lists them",
        flag="material",
        help="Material of the rod in place of the study's, as 4340 (`fea materials` lists them).",
    )

    def resolved(self) -> "MaterialTable":
        """Return the table with the preset's constants filled in."""
        base: TomlTable = {}
        if self.preset is not None:
            base = dict(library_material("material.preset", self.preset).figures)
        given = {name: value for name, value in entries_of(self).items() if name != "preset"}
        if given.keys() & set(SN_KEYS):  # one way to give the line replaces another
            base = {name: value for name, value in base.items() if name not in SN_KEYS}
        if "endurance_MPa" in given:
            base.pop("endurance_cycles", None)
        return MaterialTable(**base | given)

    def material(self) -> Material:
        """Return the material in coherent units."""
        table = self.resolved()
        (modulus, nu), marin = table.stiffness(), table.marin()
        endurance, torsion = table.endurance_MPa, table.endurance_torsion_MPa
        estimated = endurance is None and table.ultimate_MPa is not None
        if endurance is None and table.ultimate_MPa is not None:
            endurance = estimated_endurance(table.ultimate_MPa, modulus)
        factor = marin.size * marin.reliability
        ductility = [getattr(table, key) for key in _DUCTILITY]
        return Material(
            youngs_modulus=modulus,
            poissons_ratio=nu,
            density=table.needed("density_kg_m3", remedy=_REMEDY) * KG_M3,
            yield_strength=table.needed("yield_MPa", remedy=_REMEDY),
            ultimate_strength=table.ultimate_MPa,
            endurance_limit=None if endurance is None else marin.load * factor * endurance,
            torsion_limit=None if torsion is None else factor * torsion,
            endurance_estimated=estimated and endurance is not None,
            endurance_cycles=table.endurance_cycles,
            marin=marin,
            basquin=table.basquin(),
            support=table.supported(),
            hardness=table.hardness(modulus),
            hardness_estimated=table.hardness_HV is None,
            coffin_manson=None if None in ductility else CoffinManson(*ductility),
            cyclic_yield=table.cyclic_yield(modulus),
            cyclic_estimated=table.cyclic_yield_MPa is None and table.cyclic_strength_exponent is None,
        )

    def supported(self) -> bool:
        """Return whether the gradient of stress raises the limit. Raises `InvalidValue`: where it cannot."""
        bent = self.size_mm is not None or self.loading is Loading.BENDING
        steel = self.ultimate_MPa is not None and is_steel(self.stiffness()[0])
        if self.support is None:
            return steel and not bent
        rule, remedy = "is known of steel of known ultimate_MPa only", "Leave it out."
        require(steel or not self.support, "material.support", self.support, rule, remedy)
        rule = 'cannot be combined with size_mm or loading = "bending", which contain it'
        require(not (bent and self.support), "material.support", self.support, rule, remedy)
        return self.support

    def hardness(self, modulus: float) -> float | None:
        """Return the Vickers hardness, else by the strength of a steel. Raises `InvalidValue`: no steel."""
        given, steel = self.hardness_HV, is_steel(modulus)
        rule = f"is used of low-alloy steel only, and E_GPa = {modulus / GPA:g} is of another metal"
        require(steel or given is None, "material.hardness_HV", given, rule, "Leave it out.")
        return hardness_of(self.ultimate_MPa) if steel and not given and self.ultimate_MPa else given

    def cyclic_yield(self, modulus: float) -> float | None:
        """Return the cyclic yield strength, MPa, given or estimated; None where neither is possible.

        Raises `InvalidValue`: it is given twice.
        """
        coefficient, exponent = self.cyclic_strength_coefficient_MPa, self.cyclic_strength_exponent
        given, rule = self.cyclic_yield_MPa, f"cannot be combined with {' and '.join(_CURVE)}"
        once = given is None or coefficient is None
        require(once, "material.cyclic_yield_MPa", given, rule, "Keep one of them.")
        if coefficient is not None and exponent is not None:
            return float(coefficient * YIELD_STRAIN**exponent)
        if given is not None or self.ultimate_MPa is None:
            return given
        return estimated_cyclic_yield(self.ultimate_MPa, modulus)

    def basquin(self) -> Basquin | None:
        """Return the S–N line, or None. Raises `InvalidValue`: given twice, or not falling."""
        coefficient, exponent, cycles, amplitudes = (getattr(self, key) for key in SN_KEYS)
        once = cycles is None or coefficient is None
        rule = f"cannot be combined with {' and '.join(_LINE)}"
        require(once, "material.sn_cycles", cycles, rule, "Keep the constants or the tests.")
        if coefficient is not None:
            _require_slope(_LINE[1], exponent, exponent)
            return Basquin(coefficient, exponent)
        return None if cycles is None else fitted(cycles, amplitudes)

    def stiffness(self) -> tuple[float, float]:
        """Return Young's modulus, MPa, and Poisson's ratio."""
        table = self.resolved()
        modulus = require_positive("material.E_GPa", table.needed("E_GPa", remedy=_REMEDY))
        nu = table.needed("nu", remedy=_REMEDY)
        require(-1 < nu < 0.5, "material.nu", nu, "must be above −1 and below 0.5")
        return modulus * GPA, nu

    def marin(self) -> Marin:
        """Return Marin's factors, from a polished specimen to the part.

        A surface that is not given counts as that of a forging that was cleaned by blasting or peening, as
        rods are delivered, with the factor of a steel of the same strength, whatever the metal is; it counts
        as polished where the ultimate strength is not known. The bores, and the faces beside them, are
        machined where the rest of the part is left as it was forged or rolled, unless their finish is
        given. An estimated endurance limit is that of bending, so that it gets k_c of axial load. Raises
        `InvalidValue`: a value is out of its range, a finish is named but not the ultimate strength, or the
        metal is none that a finish was tested on.
        """
        usual = Finish.POLISHED if self.ultimate_MPa is None else Finish.SHOT_PEENED
        made = usual if self.surface is None else self.surface
        machined = Finish.MACHINED if made in _RAW else made
        rest = self._surface("surface", made)
        percent = MEDIAN if self.reliability_percent is None else self.reliability_percent
        estimated = all(getattr(self, key) is None for key in ("endurance_MPa", *SN_KEYS))
        return Marin(
            size=1.0 if self.size_mm is None else size_factor(self.size_mm),
            load=load_factor(self.loading or (Loading.AXIAL if estimated else Loading.BENDING)),
            reliability_percent=percent,
            bores=self._surface("bore_surface", machined),
            faces=self._surface("face_surface", machined),
            rest=rest,
        )

    def _surface(self, key: str, otherwise: Finish | float) -> SurfaceFinish:
        given = getattr(self, key)
        made = otherwise if given is None else given
        name, assumed = f"material.{key}", given is None and made != self.surface
        if made is Finish.POLISHED:
            return SurfaceFinish(assumed=assumed)
        if not isinstance(made, Finish):
            rule = f"must be above 0 and at most {_LARGEST_FACTOR:g}, the factor of the surface, or a finish"
            require(0 < made <= _LARGEST_FACTOR, name, made, rule)
            return SurfaceFinish(made, "given", assumed)
        missing, rule = "material.ultimate_MPa", f"is missing: the factor of {key} depends on it"
        require(self.ultimate_MPa is not None, missing, None, rule, f"Give it, or leave {key} out.")
        ultimate = require_positive(missing, self.ultimate_MPa)
        steel = is_steel(self.stiffness()[0])
        if made in _PEENED and not assumed:
            rule, remedy = "is known of steel only", "Give the factor as a number instead."
            require(steel, name, made, rule, remedy)
        return SurfaceFinish(finish_factor(made, ultimate), made.value, assumed, not steel)


REFERENCE_TEMPERATURE = 20.0  # °C, at which dimensions and fits are given

# By name, ranges of Young's modulus and density, and the mean linear expansion: its head says more.
_METALS = shipped_toml("study/metals.toml")
_LARGEST = 1e-4


def thermal_expansion(name: str, table: MaterialTable) -> tuple[float, str | None]:
    """Return α, 1/K, of a material and, where it is assumed, the metal that it is taken for.

    Messages name the table of the study, `name`: ``material.bushing``. Raises `InvalidValue`: it is out of
    range, or not given and the metal is not recognised.
    """
    resolved, key = table.resolved(), f"{name}.thermal_expansion_1_K"
    given = resolved.thermal_expansion_1_K
    if given is not None:
        rule = f"must not be negative and be at most {_LARGEST:g}"
        require(0 <= given <= _LARGEST, key, given, rule, "That of steel is 11.5e-6.")
        return given, None
    constants = {name: getattr(resolved, name) for name in ("E_GPa", "density_kg_m3")}
    for metal, of in _METALS.items():
        if all(value and of[name][0] <= value <= of[name][1] for name, value in constants.items()):
            return of["thermal_expansion_1_K"], metal
    raise InvalidValue(
        key, None, "is missing, and E_GPa and density_kg_m3 are of no common metal", "Give it."
    )


DEFAULT_GRADE = BoltGrade.G10_9
# Materials of parts of an assembly where the study does not give them.
ASSUMED_PARTS = {BUSHING: "cusn8p", SHELL: "steel-backed-shell"}


def table_name(part: str) -> str:
    """Return the name of the [material.…] table that a part's material stands in."""
    return SHELL if part in SHELLS else part


def bolt_material(given: Mapping[str, MaterialTable], grade: BoltGrade | None) -> MaterialTable:
    """Return the material of the bolts: that of [material.bolt], completed by a property class."""
    bolts = given.get(BOLT, MaterialTable())
    return bolts if bolts.preset else replace(bolts, preset=f"bolt-{grade or DEFAULT_GRADE}")


def assumed_materials(given: Mapping[str, MaterialTable], parts: tuple[str, ...]) -> tuple[str, ...]:
    """Say which materials of parts are assumed, with their figures."""
    names = dict.fromkeys(table_name(part) for part in parts if part not in given)
    tables = {
        name: MaterialTable(preset=ASSUMED_PARTS[name]).resolved() for name in names if name in ASSUMED_PARTS
    }
    return tuple(
        f"{name} of {ASSUMED_PARTS[name]}, {table.E_GPa:g} GPa, yield strength {table.yield_MPa:g} MPa "
        f"([material.{name}])"
        for name, table in tables.items()
        if name not in given
    )
