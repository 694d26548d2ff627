"""The registry of pin models: what loads the bores, by what a study asks for as `pressure`.

A new model is a module of `fea.pins` with a `fea.pins.model.PinModel`, and one line of `PIN_MODELS`.
"""

import re
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from fea.base.choices import CONTACT, SolverName, Support
from geometry.errors import InvalidValue
from loads.bearing import NAMES, PROFILES, BorePressure


class PinModelEntry(NamedTuple):
    """A registered pin model."""

    pattern: str  #: regular expression of the values of `pressure` that ask for it
    implementation: str  #: "module:class" of a `fea.pins.model.PinModel`, loaded when a rod is prepared
    in_contact: bool = False  #: whether the bores touch pins as [contact] says, which needs fine meshes there
    in_parts: bool = False  #: whether it is for rods of separate parts, which [assembly] describes
    #: Of pressures over an arc: the arcs by the name, or `InvalidValue` where the rest of it is wrong
    arcs: Callable[[str], BorePressure] | None = None
    shown: str = ""  #: the names it is listed by; the pattern by default
    assumption: str = ""  #: what a run assumes of the pins, for its report; by default what the arcs say

    def load(self) -> Any:
        """Return the class that implements it."""
        module, name = self.implementation.split(":")
        return getattr(import_module(module), name)

    def assumed(self, pressure: str) -> str:
        """Return what a run assumes of the pins, for its report."""
        return self.assumption or (self.arcs(pressure).words if self.arcs else "")


# What takes the place of contact where only a prescribed load will do.
PRESCRIBED = "cosine-180"
_PRESSURES = rf"webster|({'|'.join(PROFILES)})-\d+(\.\d+)?"
_BONDED = (
    "Each pin is bonded to its bore: its force is a uniform traction over the whole bore, so that it pulls "
    "one half as hard as it presses on the other."
)
_CONTACT = (
    "The pressure on the bores comes from frictionless contact with the pins, without an oil film. The "
    "piston's bosses carry the pin with half a cosine of pressure, constant along their length."
)
FILM = "oil-film"
_FILM = (
    "The pressures on the bores come from their oil films over the crank cycle, as [film] says; at rest, and "
    "where the piston pin is pressed in, pins press with half a cosine."
)
_FILM_IN_PARTS = (
    "The pressure on the big end's bore comes from its oil film over the crank cycle, as [film] says, while "
    "the joint is closed, and otherwise from frictionless contact, as that of the piston pin does."
)
PIN_MODELS: tuple[PinModelEntry, ...] = (
    PinModelEntry(_PRESSURES, "fea.pins.prescribed:PressedPins", arcs=BorePressure.parse, shown=NAMES),
    PinModelEntry("bonded", "fea.pins.bonded:BondedPins", assumption=_BONDED),
    PinModelEntry(CONTACT, "fea.pins.contact:ContactPins", in_contact=True, assumption=_CONTACT),
    PinModelEntry(FILM, "fea.pins.film_pins:FilmPins", assumption=_FILM),
    PinModelEntry(CONTACT, "fea.pins.assembly:AssemblyPins", in_contact=True, in_parts=True),
    PinModelEntry(
        FILM, "fea.pins.film_pins:FilmPartsPins", in_contact=True, in_parts=True, assumption=_FILM_IN_PARTS
    ),
)
# Those of rods in parts.
PARTS = tuple(entry.pattern for entry in PIN_MODELS if entry.in_parts)


def pin_model(pressure: str, *, in_parts: bool = False) -> PinModelEntry:
    """Return the model of a value of `pressure`, of rods in parts their own. Raises `InvalidValue`: none."""
    for entry in sorted(PIN_MODELS, key=lambda entry: entry.in_parts != in_parts):
        if re.fullmatch(entry.pattern, pressure):
            if entry.arcs is not None:
                entry.arcs(pressure)
            return entry
    *others, last = dict.fromkeys(entry.shown or entry.pattern for entry in PIN_MODELS)
    raise InvalidValue("analysis.pressure", pressure, f"must be {', '.join(others)} or {last}")


def contact_excluded_because(support: Support, solver: SolverName) -> str:
    """Why the pins cannot be in contact, as a rule; empty where they can."""
    if support is Support.CLAMPED:
        return 'cannot be combined with support = "clamped", which replaces the crank pin'
    if solver is SolverName.AMG:
        return "needs the compliance of the bores, which the iterative solver does not give"
    return ""
