"""The keys of [engine] that say how a pressure trace is to be read."""

from dataclasses import dataclass, fields, replace
from typing import Any

from fea.choices import PressureReference, PressureUnit
from geometry.invalid import require, require_number

# A crank turns by this in a whole four-stroke cycle; smoothing over more than a few degrees flattens a peak.
_CYCLE_DEG = 720.0
_WIDEST_SMOOTHING = 10.0


@dataclass(frozen=True)
class TraceKeys:
    """How a trace is to be read; what is None is found out from the file.

    Attributes
    ----------
    angle_column, pressure_column
        Name or number (from 1) of a column; for pressures also a range (``"2-61"``) to be averaged.
    angle_offset_deg
        Added to the angles of the file, so that firing TDC is at 360°.
    pressure_unit, pressure_reference
        Of the pressures in the file.
    smoothing_deg
        Width of the moving average; 0 for none.
    strokes
        4, or 2 for an engine that fires in every revolution.
    """

    angle_column: str | int | None = None
    angle_offset_deg: float | None = None
    pressure_column: str | int | None = None
    pressure_unit: PressureUnit | None = None
    pressure_reference: PressureReference | None = None
    smoothing_deg: float | None = None
    strokes: int | None = None

    def __post_init__(self) -> None:
        """Refuse values out of range."""
        if self.angle_offset_deg is not None:
            _require_within("angle_offset_deg", self.angle_offset_deg, -_CYCLE_DEG, _CYCLE_DEG)
        if self.smoothing_deg is not None:
            _require_within("smoothing_deg", self.smoothing_deg, 0.0, _WIDEST_SMOOTHING)
        if self.strokes is not None:
            require(self.strokes in (2, 4), "engine.strokes", self.strokes, "must be 2 or 4")

    @classmethod
    def of(cls, table: object) -> "TraceKeys":
        """Take the keys from a table that has them among its fields."""
        return cls(**{name: getattr(table, name) for name in cls.names()})

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the keys."""
        return tuple(field.name for field in fields(cls))

    @property
    def given(self) -> dict[str, Any]:
        """The keys that say something."""
        return {name: value for name in self.names() if (value := getattr(self, name)) is not None}

    def with_found(self, **found: object) -> "TraceKeys":
        """Return the keys with those added that were found out."""
        return replace(self, **found)  # type: ignore[arg-type]


def _require_within(key: str, value: float, least: float, most: float) -> None:
    require_number(f"engine.{key}", value)
    rule = f"must lie between {least:g} and {most:g} degrees"
    require(least <= value <= most, f"engine.{key}", value, rule)
