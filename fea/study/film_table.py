"""The [film] table: the oil of the bearings at both ends, how it gets there, and the surfaces."""

import re
from dataclasses import dataclass
from itertools import pairwise

from fea.base.shipped import shipped_toml
from fea.study.tables import NotNegative, Positive, StudyTable, key, one_of, within
from geometry.errors import InvalidValue, require

# What is assumed where a study says nothing: hot engine oil, its inlet from the main bearings, a hole in the
# crank pin that leads the crank arm; roughness (Rq 0.20 and 0.34 µm) and friction of asperities of a bearing
# that is run in (Sander et al., see `fea.pins.lubrication`).
OIL, PIEZOVISCOSITY_1_GPA, INLET_C = "5W-30", 13.0, 110.0
INLET_BAR, HOLE_DEG, HOLE_MM, ROUGHNESS_UM = 4.0, 30.0, 5.0, 0.4
# Of the friction power, the oil that leaves carries away this share, and rod and crank the rest: a choice.
HEAT_PERCENT = 80.0
DENSITY_15_KG_M3 = 860.0  # engine oils have 840 to 890; only the heat balance takes it
BOUNDARY_FRICTION = 0.02
# At the small end, splashed oil wets the sides, and the atmosphere presses it into a film that ruptures at
# the pressure of its vapour; pin and piston heat it. Both figures are choices.
SMALL_END_BAR, SMALL_END_C = 1.0, 140.0
# How much of the rod's rotation the piston pin shares: none in the piston, half of it where bosses and small
# end rub alike. In a gasoline engine a floating pin turns very slowly (Allmaier & Sander 2020, Piston-pin
# rotation and lubrication, Lubricants 8, 30), which is nearer to a fixed one.
FLOATING = "floating"
TURNS = {FLOATING: 0.5, "fixed": 0.0}
# Of the width, a groove or a hole covers this share at most; of the bore, all grooves this share.
WIDEST, _COVERED = 0.9, 0.5
_GRADE = re.compile(r"(?:SAE)?((?:0|5|10|15|20|25)W-?)?(\d+)")


@dataclass(frozen=True)
class FilmTable(
    StudyTable,
    table="film",
    intro="The oil films of both bearings; switches them on. What is left out is assumed, and the run says "
    "what",
    optional=True,
):
    """[film]: pressures are above that of the surroundings."""

    oil: str | None = key(
        '"5W-30"',
        "SAE grade: an oil that just meets it; the film's temperature follows from its heat balance",
    )
    viscosity_40C_mPas: Positive | None = key(
        "58.0",
        "in place of a grade: dynamic viscosity at 40 °C and, below, at 100 °C",
        needs="viscosity_100C_mPas, that at the other temperature",
    )
    viscosity_100C_mPas: Positive | None = key(
        "8.5", needs="viscosity_40C_mPas, that at the other temperature"
    )
    viscosity_mPas: Positive | None = key(
        "8.0", "in place of both: of the film, at whatever temperature, without pressure"
    )
    piezoviscosity_1_GPa: float | None = key("13.0", "by Roelands' law; 0: none", within(0, 40))
    radial_clearance_um: Positive | None = key(
        "25.0",
        "radius of the big end's bore less that of the crank pin; default: half of "
        "contact.big_end_clearance_mm; the small end has that of contact.small_end_clearance_mm",
    )
    inlet_bar: float | None = key("4.0", "of the oil in the crank pin's hole", within(0.01, 100))
    inlet_C: float | None = key("110.0", "temperature of that oil", within(-40, 180))
    heat_percent: float | None = key("80.0", "share of the friction that heats the oil", within(0, 100))
    hole_deg: float | None = key(
        "30.0", "of the hole, from the crank arm outwards in the sense of rotation", within(-360, 360)
    )
    hole_diameter_mm: Positive | None = key("5.0", "of the hole in the crank pin")
    grooves_deg: tuple[float, ...] = key(
        "[90.0, 270.0]",
        "middle of each groove: in the shell from the rod's axis, in the pin as hole_deg",
        within(-360, 360),
        default=(),
    )
    groove_arc_deg: float | None = key("20.0", "length of each; 360: all round", within(0.1, 360))
    groove_width_mm: Positive | None = key("16.0", "along the pin, in the middle of the bore")
    grooves_in: str = key(
        '"shell"', "or pin; they hold oil of inlet_bar", one_of(("shell", "pin")), default="shell"
    )
    piston_pin: str | None = key(
        '"floating"', "shares half of the rod's swing; or fixed in the piston", one_of(TURNS)
    )
    small_end_C: float | None = key("140.0", "temperature of the small end's film", within(-40, 250))
    small_end_inlet_bar: float | None = key(
        "1.0", "of the oil beside the small end and in its hole, above a ruptured film's", within(0.01, 100)
    )
    small_end_hole_diameter_mm: Positive | None = key(
        "4.0", "diameter; default: that of rod.oil_hole_mm, if there is one"
    )
    small_end_hole_deg: float = key("0.0", "of that hole; 0: at the top", within(-360, 360), default=0.0)
    roughness_um: NotNegative | None = key("0.4", "of both surfaces: root of the sum of their Rq²")
    boundary_friction: float | None = key("0.02", "where the surfaces touch", within(0, 1))
    lining_MPa: Positive | None = key("70.0", "specific load that the lining endures")

    def __post_init__(self) -> None:
        super().__post_init__()
        cold, hot = self.viscosity_40C_mPas, self.viscosity_100C_mPas
        if cold is not None and hot is not None:
            rule = f"must be less than that at 40 °C, {cold:g} mPa·s"
            require(cold > hot, "film.viscosity_100C_mPas", hot, rule)
        if self.oil is not None:
            grade(self.oil)
        of_grooves = {"groove_arc_deg": self.groove_arc_deg, "groove_width_mm": self.groove_width_mm}
        for name, value in of_grooves.items():
            rule = "is needed with film.grooves_deg, and has no use without"
            require((value is None) == (not self.grooves_deg), f"film.{name}", value, rule)
        starts = sorted(angle % 360 for angle in self.grooves_deg)
        apart = min((b - a for a, b in pairwise([*starts, *(a + 360 for a in starts[:1])])), default=360)
        rule = f"must not exceed the {apart:g}° from groove to groove, which would overlap"
        arc = self.groove_arc_deg or 0.0
        require(arc <= apart, "film.groove_arc_deg", arc, rule)

    def require_land(self, width: float) -> None:
        """Refuse grooves that do not leave enough of a bore of a width, mm."""
        arc, wide = self.groove_arc_deg or 0.0, self.groove_width_mm or 0.0
        rule = f"leaves no land at its ends: at most {WIDEST * width:.4g} mm in this bore"
        require(wide <= WIDEST * width, "film.groove_width_mm", wide, rule)
        covered = len(self.grooves_deg) * arc / 360 * wide / width
        rule = f"lets the grooves cover {covered:.0%} of the bore, of which {_COVERED:.0%} must carry"
        require(covered <= _COVERED, "film.groove_width_mm", wide, rule, "Use narrower or shorter ones.")


def grade(name: str) -> tuple[float, float]:
    """Least viscosity of an SAE grade: at 100 °C, mm²/s, and 150 °C, mPa·s. `InvalidValue`: unknown."""
    grades = shipped_toml("study/oils.toml")
    numbers = [each for each in grades if each.isdigit()]
    parts = _GRADE.fullmatch(name.upper().replace(" ", ""))
    if parts is None or parts[2] not in numbers:
        rule = f"is not an SAE grade: {', '.join(numbers)}, alone or behind a winter grade (0W to 25W)"
        raise InvalidValue("film.oil", name, rule, 'Write "5W-30" or "40", or give viscosities.')
    winter = (parts[1] or "").rstrip("-")
    exact = f"{winter}-{parts[2]}"
    oil = grades[exact if exact in grades else parts[2]]
    return oil["kinematic_100_mm2_s"], oil["high_shear_150_mPas"]
