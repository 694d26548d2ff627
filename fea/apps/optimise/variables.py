"""The free dimensions of a rod, each scaled to 0 … 1 between its bounds."""

from dataclasses import dataclass

import numpy as np

from fea.study.option_tables import OptimiseTable
from fea.study.rod_table import dimension_of
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from geometry.section import OF_WALLS, walls

# Of a study that names none: the sizes that set mass and strength of shank and rings.
_USUAL = ("shank_width", "shank_depth_big_end", "shank_depth_small_end", "big_end_ring", "small_end_ring")
_USUAL_OF_I = ("web_thickness", "flange_thickness")
_OF_POCKET = (*_USUAL_OF_I, "pocket_corner_radius", "pocket_floor_radius", "pocket_setback")
# Their bounds, relative to the study's values.
_FROM, _TO = 0.6, 1.4
# Least wall of a study that gives none, mm: thinner webs and rings are hard to forge.
_LEAST_WALL = 3.0
_HALVINGS = 20
_ROUNDING = 1e-9
# Of the range of a dimension: a step that shows the rule that stops it.
_A_LITTLE = 0.01


@dataclass(frozen=True)
class Variables:
    """Free dimensions: (n,) keys of the [rod] table of a study, where they start, and their bounds, mm."""

    study: Study
    keys: tuple[str, ...]
    low: Floats
    high: Floats
    least_wall: float

    @property
    def start(self) -> Floats:
        """The study's own values (n,), scaled."""
        rod = self.study.rod.solid()
        values = np.array([getattr(rod, dimension_of(key)) for key in self.keys])
        return (values - self.low) / (self.high - self.low)

    def dimensions(self, x: Floats) -> dict[str, float]:
        """Return the dimensions, mm, by their keys, of scaled values (n,)."""
        values = self.low + x * (self.high - self.low)
        return dict(zip(self.keys, values.tolist(), strict=True))

    def study_at(self, x: Floats) -> Study:
        """Return the study of scaled values (n,); raises `InvalidValue`: they break a rule of the rod."""
        return self.study.with_rod(**self.dimensions(x))

    def fault(self, x: Floats) -> str:
        """Return why no rod of scaled values (n,) can be drawn with walls thick enough; "" if it can."""
        try:
            rod = self.study_at(x).rod.solid()
        except InvalidValue as error:
            return str(error)
        thinnest, where = min((wall, name) for name, wall in walls(rod).items())
        if thinnest >= self.least_wall * (1 - _ROUNDING):
            return ""
        return f"the {where} must be at least {self.least_wall:.4g} mm thick"

    def obstacles(self, x: Floats) -> dict[str, str]:
        """Return why free dimensions cannot be a little smaller or larger, by key; bounds are left out."""
        reasons = {}
        for number, key in enumerate(self.keys):
            for step, change in ((-_A_LITTLE, "smaller"), (_A_LITTLE, "larger")):
                beside = x.copy()
                beside[number] += step
                why = self.fault(beside) if 0 <= beside[number] <= 1 else ""
                if why:
                    reasons[f"{key.removesuffix('_mm')} cannot be {change}"] = why
        return reasons

    def nearest_feasible(self, x: Floats, sound: Floats) -> Floats:
        """Return the last sound values (n,) on the way to `x` from others that are sound."""
        if not self.fault(x):
            return x
        inside, outside = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = (inside + outside) / 2
            if not self.fault(sound + middle * (x - sound)):
                inside = middle
            else:
                outside = middle
        return sound + inside * (x - sound)


def variables(study: Study) -> Variables:
    """Return a study's free dimensions. Raises `InvalidValue`: there are none, or one is out of bounds."""
    rod, table = study.rod.solid(), study.optimise or OptimiseTable()
    usual = (*_USUAL, *(_USUAL_OF_I if rod.has_pockets else ()))
    bounds = {key: (bound[0], bound[1]) for key, bound in table.free.items()} or {
        f"{name}_mm": (_FROM * getattr(rod, name), _TO * getattr(rod, name)) for name in usual
    }
    for key, (low, high) in bounds.items():
        start = getattr(rod, dimension_of(key))
        rule = f"is 0 in this rod, so the feature is left out: it cannot vary from {low:g} to {high:g} mm"
        require(start > 0, f"rod.{key}", start, rule, "Give it a value, or do not name it as free.")
        rule = "cannot be free: the shank has no pockets, so that it has no effect"
        of_pocket = dimension_of(key) in _OF_POCKET and not (rod.shank_bore and key == "pocket_setback_mm")
        require(rod.has_pockets or not of_pocket, f"optimise.free.{key}", None, rule, "Leave it out.")
        rule = f"must lie between its bounds, {low:g} and {high:g} mm, where the search starts"
        require(low <= start <= high, f"rod.{key}", start, rule, "Widen the bounds.")
    thinnest, where = min((wall, name) for name, wall in walls(rod).items())
    least = min(_LEAST_WALL, thinnest) if table.least_wall_mm is None else table.least_wall_mm
    rule = f"must not exceed the walls of the rod, where the search starts: its {where} is {thinnest:.4g} mm"
    remedy = "Thicken the wall, or reduce the limit."
    require(least <= thinnest, "optimise.least_wall_mm", least, rule, remedy)
    low, high = np.array(list(bounds.values())).T
    a_wall = np.array([dimension_of(key) in OF_WALLS for key in bounds])
    return Variables(study, tuple(bounds), np.where(a_wall, np.maximum(low, least), low), high, least)
