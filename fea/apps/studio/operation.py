"""What changes in the studio: dimensions of the rod, speed, charge, piston mass, material, clearances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

from fea.base.choices import Finish
from fea.pins.fits import BIG_CLEARANCE, SMALL_CLEARANCE
from fea.rod.loading import EngineLoading
from fea.study.material_table import LIBRARY, MaterialTable, library_material
from fea.study.option_tables import ContactTable
from fea.study.speed_tables import LARGEST_RPM, SpeedTable
from fea.study.study import Study
from fea.study.tables import checked, entries_of, hints_of, unit_of
from geometry.dimensions import key as key_of
from geometry.errors import InvalidValue
from geometry.rod import Rod

_NUMBERS = ("E_GPa", "nu", "density_kg_m3", "yield_MPa", "ultimate_MPa", "endurance_MPa")
_CLEARANCES = ("small_end_clearance_mm", "big_end_clearance_mm")
# Bounds of a slider over the study's value.
_FROM, _TO = 0.5, 2.0
_TYPES: dict[str, Any] = {"rpm": float, "gas_scale": float, "piston_mass_kg": float, "material": str}
_TYPES |= dict.fromkeys((*_NUMBERS, *_CLEARANCES), float) | {"surface": hints_of(MaterialTable)["surface"]}


@dataclass(frozen=True)
class Operation:
    """At what a rod is run; None where the study has no such thing."""

    rpm: float | None
    gas_scale: float | None  #: multiple of the engine's charge
    piston_mass_kg: float | None
    material: MaterialTable
    contact: ContactTable

    @classmethod
    def of(cls, study: Study) -> "Operation":
        """Take that of a study; of several speeds the highest."""
        rpm, engine = max((each for each in study.speeds() if each is not None), default=None), study.engine
        if engine is None:
            return cls(None, None, None, study.material, study.contact)
        scale = None if engine.gas == "none" else engine.gas_scale or 1.0
        return cls(rpm, scale, engine.piston_mass_kg, study.material, study.contact)

    @cached_property
    def values(self) -> dict[str, Any]:
        """What `changed` takes, as plain values."""
        resolved = self.material.resolved()
        own: dict[str, Any] = {key: getattr(self, key) for key in ("rpm", "gas_scale", "piston_mass_kg")}
        own |= {"material": self.material.preset, "surface": resolved.surface}
        own |= {key: getattr(resolved, key) for key in _NUMBERS}
        own |= {key: getattr(self.contact, key) for key in _CLEARANCES}
        return {key: value for key, value in own.items() if value is not None}

    def changed(self, values: Mapping[str, Any]) -> "Operation":
        """Return it with `values`; another material drops the former one's figures. Raises `InvalidValue`."""
        before = self.values
        for key in values:
            if key not in _TYPES:
                raise InvalidValue(key, None, f"is not one of {', '.join(_TYPES)}")
        new = {
            key: checked(key, value, _TYPES[key])
            for key, value in values.items()
            if value is not None and value != before.get(key)
        }
        if "rpm" in new:
            SpeedTable(new["rpm"]).speeds()
        material = self.material
        if "material" in new:
            kept = {"surface", "bore_surface", "face_surface", "size_mm", "loading", "reliability_percent"}
            of_part = {key: value for key, value in entries_of(material).items() if key in kept}
            name = library_material("material", new.pop("material")).name
            material = MaterialTable(preset=name, **of_part)
        kinds = (*_NUMBERS, "surface"), _CLEARANCES
        tables = [{key: new.pop(key) for key in keys if key in new} for keys in kinds]
        material, contact = replace(material, **tables[0]), replace(self.contact, **tables[1])
        material.material()
        return replace(self, **new, material=material, contact=contact)


def applied(study: Study, design: Mapping[str, float], operation: Operation) -> Study:
    """Return a study with dimensions, mm, by key, and operation. Raises `InvalidValue`: a rule is broken."""
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
    """An input: a number between bounds, or one of some choices; bounds of a dimension are told apart."""

    key: str
    label: str
    group: str
    unit: str
    value: Any
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    help: str = ""
    rest_only: bool = False  #: whether only contact depends on it, which is solved where the hand rests


def controls(study: Study) -> Iterator[Control]:
    """Yield the inputs for the operation of a study."""
    values = Operation.of(study).values
    for key, group in (
        *((key, "operation") for key in ("rpm", "gas_scale", "piston_mass_kg")),
        *((key, "material") for key in _NUMBERS),
    ):
        if key in values:
            label, unit = unit_of(key)
            label, unit = {"rpm": ("speed", "rpm"), "gas_scale": ("charge", "")}.get(key, (label, unit))
            value, most = values[key], {"rpm": LARGEST_RPM, "nu": 0.4}.get(key, float("inf"))
            high = min(_TO * value, max(most, value))
            yield Control(key, label, group, unit, value, _FROM * value, high)
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


# Ends of a slider over the value, where no rule of the rod ends it before.
_LEAST, _MOST = 0.5, 1.5
# Of the value: how closely the end of the feasible range is found.
_WITHIN = 1e-3
_OF_POCKETS = ("web_thickness", "flange_thickness", "pocket_corner_radius", "pocket_floor_radius")
_GROUPS = {
    "big end": ("big_end", "cap_"),
    "small end": ("small_end", "bushing", "oil_hole"),
    "shank": ("shank", "flange", "web", "pocket", "ring_step", "oil_gallery"),
}


@dataclass(frozen=True)
class Range:
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
        value, told = getattr(rod, each.name), each.metadata
        idle = each.name in _OF_POCKETS and not rod.has_pockets
        idle |= each.name == "pocket_setback" and not (rod.has_pockets or rod.shank_bore)
        if told.get("unit") != "mm" or not value or idle:
            continue
        label, unit = unit_of(key_of(each.name))
        group = next((name for name, own in _GROUPS.items() if each.name.startswith(own)), "rod")
        group = "rod" if each.name in ("big_end_bore", "small_end_bore") else group
        found.append(Control(key_of(each.name), label, group, unit, value, help=told["help"]))
    order = ["rod", *_GROUPS]
    return tuple(sorted(found, key=lambda one: order.index(one.group)))


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


def feasible(study: Study, design: Mapping[str, float], name: str, value: float) -> Range:
    """Return how far a dimension can go from a drawable design until the first rule is broken."""
    ends, reasons = [], []
    for share in (_LEAST, _MOST):
        far = share * value
        why = fault(study, {**design, name: far})
        near = value
        while why and abs(far - near) > _WITHIN * value:
            middle = (near + far) / 2
            there = fault(study, {**design, name: middle})
            if there:
                far, why = middle, there
            else:
                near = middle
        ends.append(near if why else far)
        reasons.append(why)
    (low, high), (low_reason, high_reason) = ends, reasons
    return Range(low, high, low_reason, high_reason)
