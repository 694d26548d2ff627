"""Something that an analysis leaves out, and why."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Omission:
    """Something that is left out of an analysis.

    Attributes
    ----------
    what, why
        In words.
    """

    what: str
    why: str
