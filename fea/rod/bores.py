"""The two bores of a rod, as the pressures on them need them."""

from dataclasses import dataclass

from geometry.faces import Bore


@dataclass(frozen=True)
class Bores:
    """What the pressures need of the rod.

    Attributes
    ----------
    rod_length
        Between the bores, mm.
    big_radius, big_width, small_radius, small_width
        mm, the widths in the mean.
    small_taper
        The small end's width at the angle φ from +x is small_width + small_taper cos φ, mm.
    """

    rod_length: float
    big_radius: float
    big_width: float
    small_radius: float
    small_width: float
    small_taper: float = 0.0

    @property
    def between(self) -> tuple[float, float]:
        """X where the big end's bore ends and where the small end's begins, mm."""
        return self.big_radius, self.rod_length - self.small_radius

    @classmethod
    def of(cls, bores: tuple[Bore, Bore]) -> "Bores":
        """Take the dimensions of the big and the small end's bore."""
        big, small = bores
        return cls(
            rod_length=small.x,
            big_radius=big.radius,
            big_width=big.width,
            small_radius=small.radius,
            small_width=small.width,
            small_taper=small.taper,
        )
