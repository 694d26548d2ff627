"""What a rod is run at, beside its dimensions: speed, charge, piston mass, material, finish, clearances."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from fea.base.choices import Finish
from fea.pins.fits import BIG_CLEARANCE, SMALL_CLEARANCE
from fea.study.material_table import MaterialTable
from fea.study.materials import LIBRARY, library_material
from fea.study.option_tables import LARGEST_RPM, ContactTable, SpeedTable
from fea.study.study import Study
from fea.study.tables import checked, entries_of, hints_of, unit_of
from geometry.errors import InvalidValue

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

    @property
    def values(self) -> dict[str, Any]:
        """What `changed` takes, as plain values."""
        resolved = self.material.resolved()
        own: dict[str, Any] = {
            "rpm": self.rpm,
            "gas_scale": self.gas_scale,
            "piston_mass_kg": self.piston_mass_kg,
        }
        own |= {"material": self.material.preset, "surface": resolved.surface}
        own |= {key: getattr(resolved, key) for key in _NUMBERS}
        own |= {key: getattr(self.contact, key) for key in _CLEARANCES}
        return {key: value for key, value in own.items() if value is not None}

    def changed(self, values: Mapping[str, Any]) -> "Operation":
        """Return it with other `values`.

        With another material of the library, figures that are those of the material before are left out.

        Raises
        ------
        InvalidValue
            A value is unknown, of the wrong type or breaks a rule.
        """
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
        tables = [
            {key: new.pop(key) for key in keys if key in new}
            for keys in ((*_NUMBERS, "surface"), _CLEARANCES)
        ]
        material, contact = replace(material, **tables[0]), replace(self.contact, **tables[1])
        material.material()
        return replace(self, **new, material=material, contact=contact)


def applied(study: Study, design: Mapping[str, float], operation: Operation) -> Study:
    """Return a study with other dimensions, mm, by their keys, and another operation.

    Raises
    ------
    InvalidValue
        A value breaks a rule.
    """
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
    """An input for a value of an `Operation`: a number between bounds, or one of some choices."""

    key: str
    label: str
    group: str
    unit: str
    value: Any
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    rest_only: bool = False  #: whether only contact depends on it, which is solved where the hand rests


def controls(study: Study) -> tuple[Control, ...]:
    """Return the inputs for the operation of a study."""
    values, found = Operation.of(study).values, list[Control]()
    for key, group in (
        *((key, "operation") for key in ("rpm", "gas_scale", "piston_mass_kg")),
        *((key, "material") for key in _NUMBERS),
    ):
        if key in values:
            label, unit = unit_of(key)
            label, unit = {"rpm": ("speed", "rpm"), "gas_scale": ("charge", "")}.get(key, (label, unit))
            value, most = values[key], {"rpm": LARGEST_RPM, "nu": 0.4}.get(key, float("inf"))
            found.append(
                Control(key, label, group, unit, value, _FROM * value, min(_TO * value, max(most, value)))
            )
    names = tuple(name for name in LIBRARY if not name.startswith("bolt-"))
    found.append(Control("material", "material", "material", "", values.get("material"), choices=names))
    finishes, made = tuple(Finish), values.get("surface")
    found.append(Control("surface", "finish", "material", "", made, choices=finishes))
    rod = study.rod.dimensions
    if study.analysis.in_contact and rod is not None:
        shares = (SMALL_CLEARANCE * rod.small_end_bore, BIG_CLEARANCE * rod.big_end_bore)
        for key, usual in zip(_CLEARANCES, shares, strict=True):
            label, unit = unit_of(key)
            value = values.get(key, usual)
            bounds = (min(0.0, 2 * value), max(2 * usual, 2 * value))
            found.append(Control(key, label, "pins", unit, value, *bounds, rest_only=True))
    return tuple(found)
