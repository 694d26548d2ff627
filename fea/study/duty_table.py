"""[duty] of a study file: how long an engine runs at which speeds, for the life of its rod."""

from dataclasses import dataclass, replace
from pathlib import Path

from fea.study.engine_table import located_gas
from geometry.invalid import InvalidValue, require, require_positive

# Each entry takes a cycle over all nodes, in about a second.
MOST_ENTRIES = 100
# Shares may be rounded.
_ROUNDING_PERCENT = 0.1


@dataclass(frozen=True)
class DutyTable:
    """[duty]: speeds with the hours at each, or with their shares of the time.

    `gas` is what `gas` in [engine] is, for each speed; without it, the engine's gas acts at all of them.
    """

    rpm: tuple[float, ...]
    hours: tuple[float, ...] | None = None
    share_percent: tuple[float, ...] | None = None
    gas: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Refuse lists that do not belong together, and a duty without time."""
        require(len(self.rpm) > 0, "duty.rpm", [], "must contain at least one speed")
        count, rule = len(self.rpm), f"must contain at most {MOST_ENTRIES} speeds"
        require(count <= MOST_ENTRIES, "duty.rpm", count, rule, "Join speeds that are close to each other.")
        for value in self.rpm:
            require_positive("duty.rpm", value)
        if (self.hours is None) == (self.share_percent is None):
            rule = "is missing" if self.hours is None else "cannot be combined with share_percent"
            remedy = "Give either hours or share_percent, a value for each speed."
            raise InvalidValue("duty.hours", None if self.hours is None else list(self.hours), rule, remedy)
        for key in ("hours", "share_percent"):
            for value in getattr(self, key) or ():
                require_positive(f"duty.{key}", value)
        for key in ("hours", "share_percent", "gas"):
            given = getattr(self, key)
            rule = f"must have as many values as duty.rpm ({len(self.rpm)})"
            require(given is None or len(given) == len(self.rpm), f"duty.{key}", list(given or ()), rule)
        if self.share_percent is not None:
            total, rule = sum(self.share_percent), "must add up to 100"
            whole = abs(total - 100) <= _ROUNDING_PERCENT
            require(whole, "duty.share_percent", list(self.share_percent), f"{rule}, not to {total:g}")

    @property
    def shares(self) -> tuple[float, ...]:
        """Share of the time at each speed; they add up to 1."""
        given = self.hours or self.share_percent or ()
        return tuple(value / sum(given) for value in given)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speeds, rpm, each once."""
        return tuple(dict.fromkeys(self.rpm))

    def located(self, folder: Path) -> "DutyTable":
        """Return the table with the paths of files made absolute."""
        if self.gas is None:
            return self
        return replace(self, gas=tuple(located_gas("duty.gas", gas, folder) for gas in self.gas))
