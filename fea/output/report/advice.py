"""What the assumptions of a run change, and what would make its rod pass: worked out from its own stress.

Stress does not depend on strength, so that other strengths and finishes need no further solution. What needs
one comes from `fea.apps.what_if`, if that was solved.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import isclose, isfinite, log
from typing import NamedTuple

import numpy as np

from fea.analysis.figures import CaseFigures
from fea.analysis.life_figures import EnduranceFigures, SurfaceFigures
from fea.analysis.summary_figures import Summary
from fea.base.choices import Fatigue, Finish, Region
from fea.base.material import Material, finish_factor, is_steel, reliability_factor
from fea.base.note import NoteKind
from fea.judge.fatigue import FatigueField, criterion_strength
from fea.judge.safety_factor import SurvivalAnswer
from fea.output.report.assumptions import bearing, in_words
from fea.output.stored_run import Run
from fea.output.units import factor, quantity
from fea.study.material_table import LIBRARY, MaterialTable
from geometry.errors import InvalidValue

# Relative differences between figures of a run and those worked out from its fields, in single precision.
_SAME, _SAME_LIMIT = 5e-3, 3e-4
_RELIABLE = 99.0  # percent
# Of a strength that is assumed.
_LESS = 0.9
# What an assumed finish may be as well.
_OTHER_FINISH = {Finish.SHOT_PEENED: Finish.AS_FORGED, Finish.MACHINED: Finish.GROUND}
_FINISHES = {
    Finish.AS_FORGED: "as forged, not peened", Finish.GROUND: "ground",
    Finish.MACHINED_PEENED: "machined and peened",
}  # fmt: skip
_MOST = 3
# What decides on a mode of failure that other strengths of the rod do not change.
_DECIDES = (
    ("bolts", "grade, thread and preload of the bolts"),
    ("joint", "preload and friction of the joint"),
    ("buckling", "the section of the shank"),
)


class OtherSteel(NamedTuple):
    """A steel of the library with which the rod would pass by this run's stress."""

    name: str
    table: MaterialTable
    yield_strength: float  #: MPa
    fatigue: float  #: safety factor


@dataclass(frozen=True)
class Advice:
    """What can be said of a run beyond its figures."""

    run: Run

    @property
    def _summary(self) -> Summary:
        return self.run.summary

    @cached_property
    def material(self) -> Material:
        """The material of the rod."""
        return self.run.study.material.material()

    @cached_property
    def field(self) -> FatigueField | None:
        """The fatigue field of the rod's own material; None where it is not known or another part governs."""
        envelope, arrays = self._summary.envelope, self.run.envelope
        least = None if envelope is None else envelope.min_fatigue_safety_factor
        limit, criterion = self.material.endurance_limit, self.run.study.analysis.fatigue
        strength = criterion_strength(criterion, self.material)
        if least is None or arrays is None or limit is None or strength is None:
            return None
        judged = (arrays["fatigue_safety_factor"] > 0) & (arrays.get("masked", 0.0) == 0)
        endurance = arrays.get("endurance_limit", np.full(judged.shape, limit))
        every = FatigueField(criterion, arrays["mean"], arrays["amplitude"], np.abs(endurance), strength)
        # Where other parts or other materials are judged, the rod's own strengths give another factor.
        own = judged & (np.abs(every.factors() / arrays["fatigue_safety_factor"] - 1) < _SAME)
        if not own.any():
            return None
        found = FatigueField(criterion, every.mean[own], every.amplitude[own], every.endurance[own], strength)
        return found if isclose(found.least(), least, rel_tol=_SAME) else None

    @cached_property
    def _limits(self) -> EnduranceFigures | None:
        envelope = self._summary.envelope
        return next(iter(((envelope and envelope.endurance) or {}).values()), None)

    def _regions(self) -> Mapping[str, SurfaceFigures]:
        return {} if self._limits is None else self._limits.regions

    def _with(self, field: FatigueField, shares: Mapping[str, float]) -> float:
        """Return the fatigue factor with the endurance limits of the regions multiplied by their shares.

        A place is in the region that has its limit; where two have it, the smaller share counts.
        """
        each = np.full(len(field.mean), np.inf)
        for region, surface in self._regions().items():
            there = np.abs(field.endurance / surface.endurance_MPa - 1) < _SAME_LIMIT
            each[there] = np.minimum(each[there], shares.get(region, 1.0))
        return field.least(np.where(np.isfinite(each), each, 1.0))

    def with_finish(self, made: str, finish: Finish) -> float | None:
        """Return the fatigue factor with another finish of all regions `made` in a way; None: not known."""
        ultimate = self.material.ultimate_strength
        if self.field is None or ultimate is None:
            return None
        other, regions = finish_factor(finish, ultimate), self._regions().items()
        shares = {name: other / own.surface_factor for name, own in regions if own.finish == made}
        return self._with(self.field, shares)

    def effects(self) -> list[str]:
        """Return the assumptions to look at first: how much they change, where that was worked out."""
        own = list(self._worked_out()) if self._summary.survival.mode in {"fatigue", "yielding"} else []
        solved = [one for one in self.run.what_if.assumed if not isclose(one.now, one.then, rel_tol=_SAME)]
        found = sorted((*own, *solved), key=lambda effect: -abs(log(effect[2] / effect[1])))
        lines = [f"{text}: {factor(now)} → {factor(then)}" for text, now, then in found[:_MOST]]
        worked = {"fatigue"} if own else set()
        known = bearing(self._summary.notes, self._summary.survival.mode)
        rest = [note for note in known if note.topic not in worked and not self.run.what_if.assumed]
        lines += [f"{in_words(note)} (not varied)" for note in rest[: _MOST - len(lines)]]
        return [f"{line[0].upper()}{line[1:]}" for line in lines]

    def _worked_out(self) -> Iterator[tuple[str, float, float]]:
        summary, field = self._summary, self.field
        assumed = [note for note in summary.notes if note.kind is NoteKind.ASSUMPTION]
        texts = " ".join(note.text for note in assumed)
        if summary.survival.mode == "yielding":
            if any(note.topic == "material" for note in assumed):
                now = float(summary.survival.safety_factor)
                yield "the yield strength, 10 % less", now, _LESS * now
            return
        if field is None:
            return
        now = field.least()
        if "median strength" in texts:
            share = reliability_factor(_RELIABLE)
            yield f"the median strength; borne by {_RELIABLE:g} rods in 100", now, field.least(share)
        if "as endurance limit" in texts or "material" in {note.topic for note in assumed}:
            yield "the endurance limit, 10 % less", now, field.least(_LESS)
        surfaces = self._regions().values()
        for made in dict.fromkeys(surface.finish for surface in surfaces if surface.assumed):
            other = _OTHER_FINISH.get(Finish(made))
            then = None if other is None else self.with_finish(made, other)
            if other is not None and then is not None and not isclose(then, now, rel_tol=_SAME):
                yield f"surfaces that are {made}; {_FINISHES[other]} instead", now, then

    def remedies(self) -> list[str]:
        """Return what would make the rod pass, by this run's stress; empty where it passes."""
        survival = self._summary.survival
        if survival.answer not in {SurvivalAnswer.FAILS, SurvivalAnswer.UNDECIDED}:
            return []
        own = self._stronger() if survival.mode in {"yielding", "fatigue"} else ()
        found = [*self.run.what_if.remedies, *own]
        decides = next(
            (what for part, what in _DECIDES if survival.mode.endswith(part)), "the dimensions there"
        )
        return found or [f"Not worked out: what decides is {decides}"]

    def _stronger(self) -> Iterator[str]:
        survival, field = self._summary.survival, self.field
        required, least = survival.required_safety_factor, self._least_yielding()
        if least is not None and least < required:
            yields = self.material.yield_strength
            needed, now = (quantity(each, ".0f", "MPa") for each in (yields * required / least, yields))
            yield f"Against yielding: a yield strength of {needed} (now {now})"
        spot = None if self._summary.envelope is None else self._summary.envelope.fatigue
        if field is not None and spot is not None and field.least() / self._bar() < required:
            share = field.needed(required * self._bar())
            limit = spot.endurance_MPa or self.material.endurance_limit or 0.0
            needed, now = (quantity(each, ".0f", "MPa") for each in (share * limit, limit))
            yield (
                f"Against fatigue: an endurance limit of {needed} there (now {now})"
                if isfinite(share)
                else "Against fatigue no endurance limit suffices: the mean stress alone is too high"
            )
            yield from self._peened(required)
        solved = any("the steel" in line.lower() for line in self.run.what_if.remedies)
        if is_steel(self.material.youngs_modulus) and not solved:
            if (steel := self.steel()) is None:
                yield "No steel of the library reaches both factors with this shape"
                return
            strength = quantity(steel.yield_strength, ".0f", "MPa")
            yield f"The steel {steel.name}: yield strength {strength}, fatigue factor {factor(steel.fatigue)}"

    def _peened(self, required: float) -> Iterator[str]:
        made = self._regions().get(Region.REST)
        then = None if made is None else self.with_finish(made.finish, Finish.MACHINED_PEENED)
        if then is not None and then >= required * self._bar():
            yield f"The shank and the outside machined and peened: factor {factor(then)}"

    def _bar(self) -> float:
        """By how much the fatigue factor may be too large, relative."""
        envelope = self._summary.envelope
        least = None if envelope is None else envelope.min_fatigue_safety_factor
        return 1.0 if least is None else float(least) / least.low

    def _least_yielding(self) -> float | None:
        """The least factor of rod and cap against yielding, less its error bar; None: of another part."""
        cases: list[CaseFigures] = list(self._summary.results.values())
        if any(case.weakest is None or case.weakest.part not in {"rod", "cap"} for case in cases):
            return None
        return min(case.min_safety_factor.low for case in cases)

    def steel(self) -> OtherSteel | None:
        """Return the weakest steel of the library with which neither yielding nor fatigue ends the rod."""
        least, field, regions = self._least_yielding(), self.field, self._regions()
        required, passing = self._summary.survival.required_safety_factor, list[OtherSteel]()
        if least is None or field is None or field.criterion is Fatigue.SODERBERG or not regions:
            return None
        for name, table, steel in _steels(self.run.study.material):
            surfaces, limit = steel.marin.surfaces.items(), steel.endurance_limit or 0.0
            shares = {
                str(where): own.factor * limit / regions[where].endurance_MPa for where, own in surfaces
            }
            other = replace(field, strength=steel.ultimate_strength or 1.0)
            fatigue = self._with(other, shares)
            yielding = least * steel.yield_strength / self.material.yield_strength
            if min(yielding, fatigue / self._bar()) >= required:
                passing.append(OtherSteel(name, table, steel.yield_strength, fatigue))
        return min(passing, key=lambda one: one.yield_strength, default=None)


# Keys of [material] that stay as they are with another steel.
_KEPT = ("surface", "bore_surface", "face_surface", "loading", "size_mm", "reliability_percent")


def _steels(table: MaterialTable) -> Iterator[tuple[str, MaterialTable, Material]]:
    kept = {name: value for name in _KEPT if (value := getattr(table, name)) is not None}
    for name, known in LIBRARY.items():
        figures = known.figures
        if name.startswith("bolt-") or not is_steel(1e3 * figures.get("E_GPa", 0.0)):
            continue
        if {"yield_MPa", "ultimate_MPa"} <= figures.keys():
            try:
                other = MaterialTable(preset=name, **kept)
                yield name, other, other.material()
            except InvalidValue:  # a finish that this metal cannot have
                continue
