"""The checks that decide whether a result can be trusted."""

from dataclasses import dataclass

from fea.base.shipped import shipped_toml

_DATA = shipped_toml("base/checks.toml")
LIMITS: dict[str, float] = {name: checked["limit"] for name, checked in _DATA.items()}
TITLES: dict[str, str] = {name: checked["title"] for name, checked in _DATA.items()}
# What it means for the results if it fails.
MEANINGS: dict[str, str] = {name: row["meaning"] for name, row in _DATA.items() if "meaning" in row}


@dataclass(frozen=True)
class Check:
    """A checked value and its limit."""

    value: float  #: the measured value
    limit: float  #: the largest value that passes

    @property
    def passed(self) -> bool:
        """Whether the value is within the limit (NaN is not)."""
        return self.value <= self.limit


def check(name: str, value: float) -> Check:
    """Check `value` against the limit called `name`."""
    return Check(value, LIMITS[name])
