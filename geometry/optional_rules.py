"""The rules for the optional features of a rod: slanted small end, bushing, oil hole, chamfers, cap bolts."""

from geometry.bosses import Bosses
from geometry.dimensions import Dimensions
from geometry.invalid import require
from geometry.outline import Outline


def check_options(rod: Dimensions) -> None:
    """Raise `InvalidValue` for the first rule that an option of `rod` breaks."""
    _small_end(rod)
    _chamfers(rod)
    if (bosses := Outline(rod).bosses) is not None:
        _bosses(rod, bosses)
        _bolts(rod, bosses)


def _small_end(rod: Dimensions) -> None:
    crown, least, most = rod.small_end_crown_width, 0.3 * rod.small_end_width, 0.98 * rod.small_end_width
    require(
        crown == 0 or least <= crown <= most,
        "rod.small_end_crown_width_mm",
        crown,
        f"must be 0 (no slant) or {least:.4g} to {most:.4g} mm, 0.3 to 0.98 of the small end's width",
    )
    most = 0.8 * rod.small_end_ring
    rule = f"must be at most {most:.4g} mm, 0.8 of the small end's ring"
    require(rod.bushing <= most, "rod.bushing_mm", rod.bushing, rule, "Thicken small_end_ring_mm.")
    most = 0.5 * min(crown or rod.small_end_width, rod.small_end_bore)
    rule = f"must be at most {most:.4g} mm: half of the small end's bore and of its width at the crown"
    require(rod.oil_hole <= most, "rod.oil_hole_mm", rod.oil_hole, rule, "Reduce it.")


def _chamfers(rod: Dimensions) -> None:
    for end in ("big_end", "small_end"):
        size, ring = getattr(rod, f"{end}_chamfer"), getattr(rod, f"{end}_ring")
        wall = rod.bushing if end == "small_end" and rod.bushing else ring
        most = min(0.5 * wall, 0.2 * getattr(rod, f"{end}_width"), 0.1 * getattr(rod, f"{end}_bore"))
        rule = (
            f"must be at most {most:.4g} mm: half of the wall, a fifth of the width, a tenth of the bore, "
            "whichever is least"
        )
        require(size <= most, f"rod.{end}_chamfer_mm", size, rule, "Reduce it.")
    rule = "cannot be combined with a slanted small end (small_end_crown_width_mm)"
    plain = rod.small_end_chamfer == 0 or rod.small_end_crown_width == 0
    require(plain, "rod.small_end_chamfer_mm", rod.small_end_chamfer, rule, "Remove one of them.")
    hole = rod.oil_hole / 2 + rod.small_end_chamfer
    room = (rod.small_end_crown_width or rod.small_end_width) / 2
    rule = f"must leave {room:.4g} mm, half of the small end's width, to the oil hole's radius"
    require(hole < room, "rod.small_end_chamfer_mm", rod.small_end_chamfer, rule, "Reduce it.")


def _bosses(rod: Dimensions, bosses: Bosses) -> None:
    for name in ("cap_bolt_spacing", "cap_boss_length", "cap_boss_fillet"):
        value = getattr(rod, name)
        require(value > 0, f"rod.{name}_mm", value, "must be positive if cap_bolt_mm is given")
    require(
        rod.big_end_width >= rod.small_end_width,
        "rod.big_end_width_mm",
        rod.big_end_width,
        f"must be at least the small end's width, {rod.small_end_width:g} mm, if the rod has cap bolts",
    )
    reach, most = bosses.half_length + bosses.fillet, 0.95 * bosses.ring
    require(
        reach <= most,
        "rod.cap_boss_length_mm",
        rod.cap_boss_length,
        f"half of it plus the fillet is {reach:.4g} mm; it must be at most {most:.4g} mm to end on the ring",
        "Shorten the bosses or reduce cap_boss_fillet_mm.",
    )
    gap = Outline(rod).fillets[0].start[0] - bosses.fillets()[1].end[0]
    require(
        gap >= 0.02 * bosses.ring,
        "rod.cap_boss_length_mm",
        rod.cap_boss_length,
        "the fillets of bosses and shank must leave a piece of the ring's outline between them",
        "Shorten the bosses, or reduce big_end_fillet_mm or the shank's depth.",
    )


def _bolts(rod: Dimensions, bosses: Bosses) -> None:
    require(
        rod.cap_bolt <= 0.8 * rod.big_end_width,
        "rod.cap_bolt_mm",
        rod.cap_bolt,
        f"must be at most 0.8 of the big end's width, {rod.big_end_width:g} mm",
    )
    inner = max(1.02 * rod.big_end_bore / 2, bosses.seat, bosses.ring - 1.5 * rod.cap_bolt)
    least = 2 * inner + rod.cap_bolt
    require(
        rod.cap_bolt_spacing >= least,
        "rod.cap_bolt_spacing_mm",
        rod.cap_bolt_spacing,
        f"must be at least {least:.4g} mm, so that the holes clear the bore and the bolts have plane seats",
        "Increase it, or lengthen the bosses.",
    )
