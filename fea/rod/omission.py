"""What a scene does not need."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Omission:
    """Something left out.

    Attributes
    ----------
    what, why
        In words.
    """

    what: str
    why: str
