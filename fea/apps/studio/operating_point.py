"""Inputs of the studio: dimensions of the rod, speed, gas load, piston mass, material and clearances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

from fea.base.choices import Finish
from fea.output.json_file import JsonObject
from fea.pins.fits import BIG_CLEARANCE, SMALL_CLEARANCE
from fea.rod.loading import EngineLoading
from fea.study.duty_log import LARGEST_RPM
from fea.study.material_table import LIBRARY, MaterialTable, library_material
from fea.study.option_tables import ContactTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study
from fea.study.tables import checked, entries_of, hints_of, unit_of
from geometry.dimensions import key as key_of
from geometry.errors import InvalidValue
from geometry.rod import Rod

_ENGINE = ("rpm", "gas_scale", "piston_mass_kg")
_MATERIAL = ("E_GPa", "nu", "density_kg_m3", "yield_MPa", "ultimate_MPa", "endurance_MPa")
_CLEARANCES = ("small_end_clearance_mm", "big_end_clearance_mm")
_TYPES: dict[str, Any] = dict.fromkeys((*_ENGINE, *_MATERIAL, *_CLEARANCES), float)
_TYPES |= {"material": str, "surface": hints_of(MaterialTable)["surface"]}
# Keys of a material that stay when another material is chosen.
_KEPT = {"surface", "bore_surface", "face_surface", "size_mm", "loading", "reliability_percent"}
# Ends of the sliders over the study's value: of the operating point, and of dimensions that no rule ends.
_LEAST, _MOST, _MOST_DIMENSION = 0.5, 2.0, 1.5
# Of the value: how closely the end of the feasible range is found.
_WITHIN = 1e-3
_OF_POCKETS = ("web_thickness", "flange_thickness", "pocket_corner_radius", "pocket_floor_radius")
_GROUPS = {
    "big end": ("big_end", "cap_"),
    "small end": ("small_end", "bushing", "oil_hole"),
    "shank": ("shank", "flange", "web", "pocket", "ring_step", "oil_gallery"),
}


@dataclass(frozen=True)
class OperatingPoint:
    """Speed, gas load, piston mass, material and clearances; None where the study has no such thing."""

    rpm: float | None
    gas_scale: float | None  #: gas load factor
    piston_mass_kg: float | None
    material: MaterialTable
    contact: ContactTable

    @classmethod
    def of(cls, study: Study) -> "OperatingPoint":
        """Return that of a study; of several speeds the highest."""
        rpm, engine = max((each for each in study.speeds() if each is not None), default=None), study.engine
        if engine is None:
            return cls(None, None, None, study.material, study.contact)
        scale = None if engine.gas == "none" else engine.gas_scale or 1.0
        return cls(rpm, scale, engine.piston_mass_kg, study.material, study.contact)

    @cached_property
    def values(self) -> JsonObject:
        """The plain values that `changed` takes."""
        resolved = self.material.resolved()
        values: JsonObject = {key: getattr(self, key) for key in _ENGINE}
        values |= {"material": self.material.preset, "surface": resolved.surface}
        values |= {key: getattr(resolved, key) for key in _MATERIAL}
        values |= {key: getattr(self.contact, key) for key in _CLEARANCES}
        return {key: value for key, value in values.items() if value is not None}

    def changed(self, values: Mapping[str, Any]) -> "OperatingPoint":
        """Return it with `values`; another material drops the former one's figures. Raises `InvalidValue`."""
        for key in values:
            if key not in _TYPES:
                raise InvalidValue(key, None, f"is not one of {', '.join(_TYPES)}")
        new = {
            key: checked(key, value, _TYPES[key])
            for key, value in values.items()
            if value is not None and value != self.values.get(key)
        }
        if "rpm" in new:
            SpeedTable(new["rpm"]).speeds()
        material = self.material
        if "material" in new:
            kept = {key: value for key, value in entries_of(material).items() if key in _KEPT}
            material = MaterialTable(preset=library_material("material", new.pop("material")).name, **kept)
        of_material, of_contact = (
            {key: new.pop(key) for key in keys if key in new}
            for keys in ((*_MATERIAL, "surface"), _CLEARANCES)
        )
        material = replace(material, **of_material)
        material.material()
        return replace(self, **new, material=material, contact=replace(self.contact, **of_contact))


def applied(study: Study, design: Mapping[str, float], operation: OperatingPoint) -> Study:
    """Return a study at an operating point, with dimensions, mm, by key. Raises `InvalidValue`."""
    study = study.with_rod(**design) if design else study
    engine = study.engine
    if engine is not None:
        scale = operation.gas_scale if operation.gas_scale != 1.0 or engine.gas_scale else engine.gas_scale
        mass = engine.piston_mass_kg if operation.piston_mass_kg is None else operation.piston_mass_kg
        engine = replace(engine, gas_scale=scale, piston_mass_kg=mass)
        study = replace(study, engine=engine, speed=SpeedTable(operation.rpm))
    return replace(study, material=operation.material, contact=operation.contact)


@dataclass(frozen=True)
class Control:
    """An input: a number between bounds, or one of some choices; a dimension's bounds are in its range."""

    key: str
    label: str
    group: str
    unit: str
    value: Any
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    help: str = ""
    rest_only: bool = False  #: whether only contact depends on it, which is solved at rest


def controls(study: Study) -> Iterator[Control]:
    """Yield the inputs for the operating point of a study."""
    values = OperatingPoint.of(study).values
    groups = dict.fromkeys(_ENGINE, "operation") | dict.fromkeys(_MATERIAL, "material")
    for key in filter(values.__contains__, groups):
        label, unit = {"rpm": ("speed", "rpm"), "gas_scale": ("gas load", "")}.get(key, unit_of(key))
        value, most = values[key], {"rpm": LARGEST_RPM, "nu": 0.4}.get(key, float("inf"))
        high = min(_MOST * value, max(most, value))
        yield Control(key, label, groups[key], unit, value, _LEAST * value, high)
    names = tuple(name for name in LIBRARY if not name.startswith("bolt-"))
    yield Control("material", "material", "material", "", values.get("material"), choices=names)
    yield Control("surface", "finish", "material", "", values.get("surface"), choices=tuple(Finish))
    rod = study.rod.dimensions
    if study.analysis.in_contact and rod is not None:
        shares = (SMALL_CLEARANCE * rod.small_end_bore, BIG_CLEARANCE * rod.big_end_bore)
        for key, usual in zip(_CLEARANCES, shares, strict=True):
            label, unit = unit_of(key)
            value = values.get(key, usual)
            bounds = (min(0.0, 2 * value), max(2 * usual, 2 * value))
            yield Control(key, label, "pins", unit, value, *bounds, rest_only=True)


@dataclass(frozen=True)
class SliderRange:
    """How far a dimension can go while the others stay."""

    low: float
    high: float
    #: low_reason, high_reason: the rule that ends it there; empty where only the slider ends
    low_reason: str = ""
    high_reason: str = ""
    #: What the moved mesh is known to reach, and what is interpolated; None where nothing is known yet
    reach_low: float | None = None
    reach_high: float | None = None
    covered_low: float | None = None
    covered_high: float | None = None


def dimensions(study: Study) -> tuple[Control, ...]:
    """Return the dimensions that a rod has, without those of features left out; none of a file's."""
    rod = study.rod.dimensions
    if rod is None:
        return ()
    found = []
    for each in fields(Rod):
        value, declared = getattr(rod, each.name), each.metadata
        idle = each.name in _OF_POCKETS and not rod.has_pockets
        idle |= each.name == "pocket_setback" and not (rod.has_pockets or rod.shank_bore)
        if declared.get("unit") != "mm" or not value or idle:
            continue
        label, unit = unit_of(key_of(each.name))
        group = next((name for name, starts in _GROUPS.items() if each.name.startswith(starts)), "rod")
        group = "rod" if each.name in ("big_end_bore", "small_end_bore") else group
        found.append(Control(key_of(each.name), label, group, unit, value, help=declared["help"]))
    order = ["rod", *_GROUPS]
    return tuple(sorted(found, key=lambda control: order.index(control.group)))


def fault(study: Study, design: Mapping[str, float]) -> str:
    """Return the rule that a design breaks; empty where it can be drawn and driven."""
    try:
        length = study.rod.with_dimensions(design).length
        if study.engine is not None and length is not None and length != study.rod.length:
            EngineLoading.of(study.engine, length)
    except InvalidValue as error:
        label = unit_of(error.name.rpartition(".")[2])[0]
        return f"the {label} {error.rule}"
    return ""


def feasible(study: Study, design: Mapping[str, float], name: str, value: float) -> SliderRange:
    """Return how far a dimension can go from a drawable design until the first rule is broken."""
    ends, reasons = [], []
    for share in (_LEAST, _MOST_DIMENSION):
        near, far = value, share * value
        reason = fault(study, {**design, name: far})
        while reason and abs(far - near) > _WITHIN * value:
            middle = (near + far) / 2
            if broken := fault(study, {**design, name: middle}):
                far, reason = middle, broken
            else:
                near = middle
        ends.append(near if reason else far)
        reasons.append(reason)
    return SliderRange(ends[0], ends[1], reasons[0], reasons[1])
