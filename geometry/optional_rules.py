"""The rules for what a rod may have besides: slant, bushing, oil hole, cap bolts."""

from geometry.bosses import Bosses
from geometry.dimensions import Dimensions
from geometry.invalid import require
from geometry.outline import Outline


def check_options(rod: Dimensions) -> None:
    """Raise `InvalidValue` for the first rule that an option of `rod` breaks."""
    _small_end(rod)
    if (bosses := Outline(rod).bosses) is not None:
        _bosses(rod, bosses)
        _bolts(rod, bosses)


def _small_end(rod: Dimensions) -> None:
    crown, least, most = rod.small_end_crown_width, 0.3 * rod.small_end_width, 0.98 * rod.small_end_width
    require(
        crown == 0 or least <= crown <= most,
        "rod.small_end_crown_width_mm",
        crown,
        f"must be 0 (no slant) or between {least:.4g} and {most:.4g} mm, below the small end's width",
    )
    most = 0.8 * rod.small_end_ring
    rule = f"must be at most eight tenths of the small end's ring, {most:.4g} mm"
    require(rod.bushing <= most, "rod.bushing_mm", rod.bushing, rule, "Thicken small_end_ring_mm.")
    most = 0.5 * min(crown or rod.small_end_width, rod.small_end_bore)
    rule = f"must be at most half of the small end's width at the crown and of its bore, {most:.4g} mm"
    require(rod.oil_hole <= most, "rod.oil_hole_mm", rod.oil_hole, rule, "Reduce it.")


def _bosses(rod: Dimensions, bosses: Bosses) -> None:
    for name in ("cap_bolt_spacing", "cap_boss_length", "cap_boss_fillet"):
        value = getattr(rod, name)
        require(value > 0, f"rod.{name}_mm", value, "must be given beside cap_bolt_mm")
    require(
        rod.big_end_width >= rod.small_end_width,
        "rod.big_end_width_mm",
        rod.big_end_width,
        f"with cap bolts it must be at least the small end's width, {rod.small_end_width:g} mm",
    )
    reach, most = bosses.half_length + bosses.fillet, 0.95 * bosses.ring
    require(
        reach <= most,
        "rod.cap_boss_length_mm",
        rod.cap_boss_length,
        f"half of it and the fillet, {reach:.4g} mm, must end on the ring, within {most:.4g} mm of the pin",
        "Shorten the bosses or reduce cap_boss_fillet_mm.",
    )
    gap = Outline(rod).fillets[0].start[0] - bosses.fillets()[1].end[0]
    require(
        gap >= 0.02 * bosses.ring,
        "rod.cap_boss_length_mm",
        rod.cap_boss_length,
        "bosses and shank must leave a piece of the ring between their fillets",
        "Shorten the bosses, or reduce big_end_fillet_mm or the shank's depth.",
    )


def _bolts(rod: Dimensions, bosses: Bosses) -> None:
    require(
        rod.cap_bolt <= 0.8 * rod.big_end_width,
        "rod.cap_bolt_mm",
        rod.cap_bolt,
        f"must be at most eight tenths of the big end's width, {rod.big_end_width:g} mm",
    )
    inner = max(1.02 * rod.big_end_bore / 2, bosses.seat, bosses.ring - 1.5 * rod.cap_bolt)
    least = 2 * inner + rod.cap_bolt
    require(
        rod.cap_bolt_spacing >= least,
        "rod.cap_bolt_spacing_mm",
        rod.cap_bolt_spacing,
        f"must be at least {least:.4g} mm: holes clear of the bore, plane seats, bosses that cover the ring",
        "Widen it, or lengthen the bosses.",
    )
