"""A rod: its dimensions, checked."""

from dataclasses import dataclass

from geometry import rules
from geometry.dimensions import Dimensions


@dataclass(frozen=True, kw_only=True)
class Rod(Dimensions):
    """A connecting rod whose dimensions obey every rule.

    Every dimension must be given; `geometry.proportions.proportioned` derives missing ones.

    Raises
    ------
    InvalidValue
        A dimension breaks a rule; the message names it by its key in a study (``rod.web_thickness_mm``).
    """

    def __post_init__(self) -> None:
        rules.check(self)
