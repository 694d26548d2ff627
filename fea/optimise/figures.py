"""What a search has found, as figures for the table, for JSON and for the history."""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.analysis.summary_file import OPTIMISED_SCHEMA
from fea.optimise.designs import Design
from fea.optimise.limits import Limit
from fea.optimise.search import Found
from fea.optimise.variables import Variables

# Of the range of a dimension, and of a required factor: nearer ones count as at the bound, or as governing.
_AT_BOUND, _ACTIVE = 0.01, 0.02


@dataclass(frozen=True, kw_only=True)
class DimensionFigures:
    """A free dimension, mm, before and after; `bound` says at which bound it ended."""

    key: str
    low_mm: float
    high_mm: float
    before_mm: float
    after_mm: float
    bound: str | None


@dataclass(frozen=True, kw_only=True)
class LimitFigures:
    """A limit, before and after: the safety factor and the error bar of the stress behind it.

    `assured_after` is the factor less its bar, `active` whether it keeps the rod from being lighter.
    """

    name: str
    required: float
    before: float
    before_error_percent: float
    after: float
    after_error_percent: float
    assured_after: float
    active: bool


@dataclass(frozen=True, kw_only=True)
class DesignFigures:
    """A design that was tried: its mass, the limit with the least margin and the dimensions."""

    number: int
    mass_kg: float
    margin: float
    governing: str
    new_mesh: bool
    dimensions_mm: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class OptimiseFigures:
    """``optimise.json``.

    `holds` says whether every required factor less its error bar is reached on the last mesh, `trusted`
    whether every check of that analysis passed; `evaluations` counts the meshes that were solved,
    `new_meshes` the designs with a mesh of their own, from which others were moved;
    `stopped_by` names the rules of the shape that keep a dimension from changing further.
    """

    schema: str = OPTIMISED_SCHEMA
    study: str
    mass_before_kg: float
    mass_after_kg: float
    saved_percent: float
    holds: bool
    trusted: bool
    ended: str
    evaluations: int
    new_meshes: int
    tolerance_percent: float
    least_wall_mm: float
    dimensions: tuple[DimensionFigures, ...]
    limits: tuple[LimitFigures, ...]
    stopped_by: tuple[str, ...]
    history: tuple[DesignFigures, ...]
    notes: tuple[str, ...]
    files: tuple[str, ...]
    total_s: float

    @property
    def missed(self) -> tuple[LimitFigures, ...]:
        """The limits that the rod does not hold."""
        return tuple(limit for limit in self.limits if limit.assured_after < limit.required)


def dimension_figures(variables: Variables, best: Design) -> tuple[DimensionFigures, ...]:
    """Return the free dimensions before and after."""
    before, after = variables.dimensions(variables.start), variables.dimensions(best.x)
    return tuple(
        DimensionFigures(
            key=key,
            low_mm=float(low),
            high_mm=float(high),
            before_mm=before[key],
            after_mm=after[key],
            bound="least" if x < _AT_BOUND else "largest" if x > 1 - _AT_BOUND else None,
        )
        for key, low, high, x in zip(variables.keys, variables.low, variables.high, best.x, strict=True)
    )


def limit_figures(before: tuple[Limit, ...], after: tuple[Limit, ...]) -> tuple[LimitFigures, ...]:
    """Return the limits before and after."""
    earlier = {limit.name: limit for limit in before}
    return tuple(
        LimitFigures(
            name=limit.name,
            required=limit.required,
            before=earlier.get(limit.name, limit).factor,
            before_error_percent=earlier.get(limit.name, limit).error_percent,
            after=limit.factor,
            after_error_percent=limit.error_percent,
            assured_after=limit.low,
            active=limit.margin < _ACTIVE,
        )
        for limit in after
    )


def history(variables: Variables, found: Found) -> tuple[DesignFigures, ...]:
    """Return all designs that were tried."""
    return tuple(
        DesignFigures(
            number=number,
            mass_kg=design.mass_kg,
            margin=design.margin,
            governing=design.governing.name,
            new_mesh=design.fresh,
            dimensions_mm=variables.dimensions(design.x),
        )
        for number, design in enumerate(found.tried, start=1)
    )
