"""A sharp re-entrant edge under one load case: what can be said although the elastic stress is infinite."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from fea.assess.safety import CAP
from fea.stress.notch import VNotch
from fea.stress.notch_field import NotchField
from geometry.arrays import Floats

# Element size, of the shorter flank and within so much of the thickness, with which the structural stress and
# the notch are known to a few percent; not less than this share of the thickness.
FINE, FINE_WITHIN, _FINEST = 0.12, 0.6, 0.08
# An edge matters where its structural stress uses at least this share of the strength that the worst place of
# its case uses; up to so many edges do in a case.
SHARE, _MATTERING, _IF_DIVERGING = 0.5, 4, 2


@dataclass(frozen=True, kw_only=True)
class SharpPlace:
    """A sharp re-entrant edge under one load case.

    Attributes
    ----------
    at
        (3,) where its structural stress is largest, mm.
    between
        The faces that meet there, in words.
    opening, length
        Angle of the notch, outside the material, rad, and length of the connected edge, mm.
    thickness
        The measure t of the extrapolation, mm: of the material behind the flank with the larger structural
        stress, or the length of that flank where it is shorter.
    stress
        Structural stress across the edge, MPa, tension positive.
    von_mises, bar
        Of the structural stress, MPa, and its error bar, from the errors where it is read.
    yield_strength
        Of the part there, MPa.
    notch
        The singular field; None where the flanks do not tell.
    shorter
        The smaller measure of both flanks, mm.
    plane
        Von Mises stress over the stress across the edge, at the surface of a fillet: plane strain along it.
    """

    at: Floats
    between: tuple[str, str]
    opening: float
    length: float
    thickness: float
    stress: float
    von_mises: float
    bar: float
    yield_strength: float
    notch: NotchField | None
    shorter: float
    plane: float

    @property
    def safety_factor(self) -> float:
        """Against yielding, by the structural stress."""
        return min(self.yield_strength / max(self.von_mises, 1e-300), CAP)

    @property
    def exponent(self) -> float:
        """1 − λ₁: the elastic stress grows as r^(λ₁ − 1) towards the edge."""
        return 1 - VNotch(self.opening).opens

    @property
    def error_percent(self) -> float:
        """The bar relative to the structural stress."""
        return 100 * self.bar / self.von_mises if self.von_mises > 0 else 0.0

    @property
    def element_size(self) -> float:
        """Element size that the place asks for, mm."""
        return max(FINE * self.shorter, _FINEST * self.thickness)

    def fillet(self, required: float) -> float | None:
        """Smallest fillet radius, mm, whose peak has this safety factor; None where none is small enough.

        No fillet helps where the structural stress is too high already.
        """
        if self.notch is None or self.safety_factor < required:
            return None
        return self.notch.radius(self.yield_strength / required / self.plane)

    def peak_with(self, radius: float) -> float | None:
        """Von Mises stress at the peak of a fillet, MPa; None where the flanks do not tell."""
        return None if self.notch is None else self.plane * abs(self.notch.peak(radius))


def worst_of_edges(cases: Iterable[Sequence[SharpPlace]]) -> list[SharpPlace]:
    """Return each edge once, as it is in the load case where its safety factor is least."""
    worst: dict[tuple[str, str], SharpPlace] = {}
    for place in (place for places in cases for place in places):
        if place.between not in worst or place.safety_factor < worst[place.between].safety_factor:
            worst[place.between] = place
    return sorted(worst.values(), key=lambda place: place.safety_factor)


def mattering(
    places: Sequence[SharpPlace], least_factor: float, *, diverging: bool
) -> tuple[SharpPlace, ...]:
    """Return the places that matter beside the rest of the rod.

    Parameters
    ----------
    places
        Of one case, the worst first.
    least_factor
        The least safety factor of the rest.
    diverging
        Whether the stress near singular places exceeds that of the rest: then at least two places matter.
    """
    limit = min([least_factor, *(place.safety_factor for place in places)]) / SHARE
    kept = [place for place in places if place.safety_factor <= limit]
    return tuple(places[: max(min(len(kept), _MATTERING), _IF_DIVERGING if diverging else 0)])
