"""[contact] of a study file: the pins, where the bores' pressure comes from contact."""

from dataclasses import dataclass

from fea.choices import PinModel
from geometry.invalid import require, require_number, require_positive

# Names of the [material.…] tables that belong to pins and not to parts of the rod.
PISTON_PIN, CRANK_PIN = "piston_pin", "crank_pin"
PINS = (PISTON_PIN, CRANK_PIN)


@dataclass(frozen=True)
class ContactTable:
    """[contact]: clearances are diametral, bore less pin; negative ones are press fits.

    What is left out is assumed from the size of the bores (`fea.contact.fits`). `small_end_relief_mm` is how
    far from either end the small end's bore widens towards it, and by how much of its radius.
    """

    small_end_clearance_mm: float | None = None
    big_end_clearance_mm: float | None = None
    piston_pin: PinModel = PinModel.ELASTIC
    piston_pin_bore_mm: float | None = None
    piston_pin_length_mm: float | None = None
    piston_boss_gap_mm: float | None = None
    small_end_relief_mm: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Refuse lengths that no pin has."""
        for key in ("small_end_clearance_mm", "big_end_clearance_mm"):
            value = getattr(self, key)
            if value is not None:
                require_number(f"contact.{key}", value)
        for key in ("piston_pin_bore_mm", "piston_pin_length_mm", "piston_boss_gap_mm"):
            value = getattr(self, key)
            if value is not None:
                require_number(f"contact.{key}", value)
                require(value >= 0, f"contact.{key}", value, "must not be negative")
        if self.small_end_relief_mm is not None:
            name, given = "contact.small_end_relief_mm", list(self.small_end_relief_mm)
            require(len(given) == 2, name, given, "must be [length, depth]")
            for value in given:
                require_positive(name, value)
