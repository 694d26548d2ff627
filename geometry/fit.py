"""Dimensions found from a target mass, centre of gravity and inertia."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geometry.arrays import Floats
from geometry.dimensions import dimensions
from geometry.errors import InvalidValue, require, require_positive
from geometry.mass import joined
from geometry.rod import Rod
from geometry.section import HeightField

SPAN = 3.0  # a free dimension may grow or shrink by this factor
_MET = 1e-3
_DIGITS = (6, 9)  # significant digits of the result: the fewest with which the rod still obeys its rules
_AT_LIMIT = 1e-3  # relative distance
_REFUSED = 10.0  # residual of dimensions that break a rule: large, so that the step is rejected


@dataclass(frozen=True)
class Targets:
    """Target mass properties of a rod; None sets no target for that figure."""

    density: float  #: t/mm³
    mass: float | None = None  #: t
    center: float | None = None  #: centre of gravity, mm from the crank-pin centre
    inertia_z: float | None = None  #: about the pin-parallel axis through the centre of gravity, t·mm²
    bushing_density: float | None = None  #: t/mm³, if the bushing has a density of its own

    def given(self) -> dict[str, float]:
        """Return the targets that were given."""
        every = {"mass": self.mass, "center": self.center, "inertia_z": self.inertia_z}
        sought = {name: value for name, value in every.items() if value is not None}
        return {name: require_positive(f"target {name}", value) for name, value in sought.items()}


@dataclass(frozen=True)
class Fit:
    """The rod that comes closest to its targets."""

    rod: Rod  #: the rod
    residuals: dict[str, float]  #: relative misfit of each target, computed / target − 1
    at_limit: tuple[str, ...]  #: free dimensions that ended at the limit of their allowed range

    @property
    def met(self) -> bool:
        """Whether every target is met to a thousandth."""
        return all(abs(misfit) <= _MET for misfit in self.residuals.values())

    def text(self) -> str:
        """Say whether the targets are met together, and if not, by how much they are missed."""
        if self.met:
            return f"{'all targets are' if len(self.residuals) > 1 else 'the target is'} met within 0.1 %"
        misfits = ", ".join(f"{name} {100 * value:+.2g} %" for name, value in self.residuals.items())
        limits = f"; dimensions at their limits: {', '.join(self.at_limit)}" if self.at_limit else ""
        what = "targets cannot be met together" if len(self.residuals) > 1 else "target cannot be met"
        return f"the {what} with these free dimensions: {misfits}{limits}"


def fit(rod: Rod, targets: Targets, free: Sequence[str]) -> Fit:
    """Adjust free dimensions of a rod until its mass properties come as close as possible to the targets.

    Bounded least squares over the relative misfits; each dimension may change by the factor `SPAN` either
    way. Raises `InvalidValue`: no target, no free dimension, or a name that is not a dimension.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - only a fit needs it

    sought = targets.given()
    require(bool(sought), "targets", None, "are missing: give at least one of mass, center and inertia_z")
    require(bool(free), "free dimensions", list(free), "at least one dimension must be free")
    for name in free:
        require(name in dimensions(), "free dimension", name, f"must be one of {', '.join(dimensions())}")
    start = np.array([getattr(rod, name) for name in free])

    def misfit(shares: Floats) -> Floats:
        try:
            changed = _changed(rod, free, shares * start)
        except InvalidValue:
            return np.full(len(sought), _REFUSED)
        return np.array(list(_misfits(changed, targets, sought).values()))

    solution = least_squares(misfit, np.ones(len(free)), bounds=(1 / SPAN, SPAN), xtol=1e-6, max_nfev=50)
    best = _rounded(rod, free, solution.x * start)
    ends = np.abs(np.log(solution.x)) > np.log(SPAN) - _AT_LIMIT
    limits = tuple(name for name, at_end in zip(free, ends, strict=True) if at_end)
    return Fit(best, _misfits(best, targets, sought), limits)


def _rounded(rod: Rod, free: Sequence[str], values: Floats) -> Rod:
    for digits in _DIGITS:
        with suppress(InvalidValue):
            return _changed(rod, free, [float(f"{value:.{digits}g}") for value in values])
    return _changed(rod, free, values)


def _changed(rod: Rod, free: Sequence[str], values: Floats | list[float]) -> Rod:
    changes: dict[str, Any] = dict(zip(free, map(float, values), strict=True))
    return replace(rod, **changes)


def _misfits(rod: Rod, targets: Targets, sought: dict[str, float]) -> dict[str, float]:
    field = HeightField(rod)
    mass = field.mass().times(targets.density)
    if rod.bushing and targets.bushing_density is not None:
        mass = joined([mass, field.bushing().times(targets.bushing_density - targets.density)])
    reached = {"mass": mass.mass, "center": mass.center[0], "inertia_z": mass.inertia_z}
    return {name: reached[name] / target - 1 for name, target in sought.items()}
