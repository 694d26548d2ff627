"""[assembly] of a study: cap, bolts, bushing and bearing shells of a rod as it is built; and standard bolts.

Threads are those of the ISO and the unified profile, both with flanks at 60°; dimensions are basic, without
tolerances (ISO 68-1, ISO 724; ASME B1.1). Pitches, strengths by grade and lubricants: `bolts.toml`.
"""

import math
import re
from dataclasses import dataclass

from fea.base.choices import BoltGrade, CapJoint, Lubricant, ThreadRolled
from fea.base.shipped import shipped_toml
from fea.base.units import INCH
from fea.study.tables import NotNegative, Positive, StudyTable, key, nearest, within
from geometry.errors import InvalidValue, require
from geometry.rod import Rod

# Names of the [material.…] tables, and of the parts that they are for.
BOLT, BUSHING, SHELL = "bolt", "bushing", "shell"
UPPER_SHELL, LOWER_SHELL = "upper shell", "lower shell"
SHELLS = (UPPER_SHELL, LOWER_SHELL)
_DATA = shipped_toml("study/bolts.toml")
_PITCHES = {float(size): pitches for size, pitches in _DATA["pitches"].items()}
# Standard threads have a pitch of 0.045 to 0.18 of their diameter, so that these bounds hold any thread.
_LEAST_PITCH, _LARGEST_PITCH = 0.03, 0.2
_UNIFIED = re.compile(
    r"\s*(#\d{1,2}|\d{1,2}/\d{1,2}|\d?\.\d{1,4})\s*(?:[\"″]|in)?(?:\s*-\s*(\d{1,2}))?\s*(UN(?:C|F|JC|JF|J)?)?\s*",
    re.IGNORECASE,
)
_NAME = re.compile(r"\s*M\s*(\d{1,3}(?:\.\d{1,6})?)(?:\s*[xX×]\s*(\d{1,2}(?:\.\d{1,6})?))?\s*")


@dataclass(frozen=True)
class Thread:
    """A metric thread: nominal diameter d and pitch P, mm."""

    diameter: float
    pitch: float

    @property
    def name(self) -> str:
        """Designation, such as M9x1."""
        return f"M{self.diameter:g}x{self.pitch:g}"

    @property
    def height(self) -> float:
        """H = √3/2 P, height of the fundamental triangle (ISO 68-1), mm."""
        return math.sqrt(3) / 2 * self.pitch

    @property
    def pitch_diameter(self) -> float:
        """d₂ = d − 3/4 H (ISO 724), mm."""
        return self.diameter - 3 / 4 * self.height

    @property
    def root_diameter(self) -> float:
        """d₃ = d − 17/12 H (ISO 68-1, as in ISO 898-1), mm."""
        return self.diameter - 17 / 12 * self.height

    @property
    def stress_diameter(self) -> float:
        """d_S = (d₂ + d₃)/2, mm."""
        return (self.pitch_diameter + self.root_diameter) / 2

    @property
    def stress_area(self) -> float:
        """A_S = π/4 d_S² (ISO 898-1), mm²."""
        return math.pi / 4 * self.stress_diameter**2

    @property
    def root_area(self) -> float:
        """A_d3 = π/4 d₃², mm²."""
        return math.pi / 4 * self.root_diameter**2

    @property
    def nominal_area(self) -> float:
        """A_N = π/4 d², mm²."""
        return math.pi / 4 * self.diameter**2

    @property
    def usual_seat(self) -> float:
        """Outer diameter of the seat under a hexagon head, mm (ISO 4014 has 1.39 to 1.48 d)."""
        return 1.45 * self.diameter


@dataclass(frozen=True)
class UnifiedThread(Thread):
    """An inch thread UN, with the rounded root of bolts, UNR, or the larger one of UNJ."""

    size: str  #: as 3/8
    larger_root: bool = False  #: UNJ

    @property
    def name(self) -> str:
        """Designation, such as 3/8-24."""
        return f"{self.size}-{INCH / self.pitch:.0f}{' UNJ' if self.larger_root else ''}"

    @property
    def root_diameter(self) -> float:
        """d₃ = d − 11/8 H (UNR, ASME B1.1), or d − 4/3 H (UNJ, SAE AS8879), mm."""
        return self.diameter - (4 / 3 if self.larger_root else 11 / 8) * self.height

    @property
    def stress_diameter(self) -> float:
        """D − 0.9743/n = d − 9/8 H (ASME B1.1, appendix B), mm."""
        return self.diameter - 9 / 8 * self.height

    @property
    def usual_seat(self) -> float:
        """As of `Thread`, of hexagon cap screws (ASME B18.2.1)."""
        flats = _UNIFIED_SIZES.get(self.size, (0, 0, 0, 1.5 * self.diameter / INCH))[3]
        return 0.95 * flats * INCH


def parse_thread(key: str, name: str) -> Thread:
    """Read M9x1, M10 (coarse), 3/8-24 or 3/8 UNF. Raises `InvalidValue`: no such thread or standard pitch."""
    remedy = 'Give diameter and pitch in mm, as "M9x1", or inches and threads per inch, as "3/8-24".'
    if inches := _UNIFIED.fullmatch(name):
        thread: Thread = _unified(key, name, *inches.groups())
    elif (named := _NAME.fullmatch(name)) is None:
        raise InvalidValue(key, name, "is not a thread", remedy)
    elif named[2] is not None:
        thread = Thread(float(named[1]), float(named[2]))
    else:
        diameter, names = float(named[1]), [f"M{size:g}" for size in _PITCHES]
        rule, other = "has no standard pitch", f"{remedy} {nearest(name, names)}"
        require(diameter in _PITCHES, key, name, rule, other)
        thread = Thread(diameter, _PITCHES[diameter][0])
    rule = "its diameter must be 2 to 100 mm"
    require(2 <= thread.diameter <= 100, key, name, rule, remedy)
    least, most = _LEAST_PITCH * thread.diameter, _LARGEST_PITCH * thread.diameter
    rule = f"its pitch must be {least:.3g} to {most:.3g} mm"
    require(least <= thread.pitch <= most, key, name, rule, remedy)
    return thread


# Diameter, inches, threads per inch of UNC and UNF, and width across the flats of a hexagon head, inches.
_UNIFIED_SIZES: dict[str, list[float]] = _DATA["unified"]


def _unified(key: str, name: str, size: str, count: str | None, series: str | None) -> UnifiedThread:
    """Return an inch thread of a size, and threads per inch or a series: UNC, UNF, UNJF, …."""
    kind = (series or "").upper()
    top, _, bottom = size.partition("/")
    if size.startswith("#"):
        diameter = 0.06 + 0.013 * int(size[1:])  # ASME B1.1: numbered sizes
    else:
        diameter = float(top) / (float(bottom or 1) or math.inf)
    label = next((label for label, row in _UNIFIED_SIZES.items() if math.isclose(row[0], diameter)), size)
    standard = dict(zip("CF", _UNIFIED_SIZES.get(label, [0, 0, 0])[1:], strict=False)).get(kind[-1:], 0)
    threads = float(count or standard)
    remedy = 'Give threads per inch, as "3/8-24", or the series of a standard size, as "3/8 UNF".'
    require(threads > 0, key, name, "does not say how many threads an inch has", remedy)
    rule = f"contradicts itself: {label} {kind} has {standard:g} threads per inch"
    require(not standard or threads == standard, key, name, rule, remedy)
    return UnifiedThread(INCH * diameter, INCH / threads, label, larger_root="J" in kind)


def thread_in_hole(hole: float) -> Thread | None:
    """Return the largest fine thread that goes through a hole of a diameter in mm; None where none does."""
    sizes = [size for size in _PITCHES if size <= hole * (1 + 1e-9)]
    return Thread(sizes[-1], _PITCHES[sizes[-1]][1]) if sizes else None


# Play, over its diameter, of a bolt that is offered for a hole; M8 in 9 mm has it.
_LOOSEST = 0.125


def threads_for_hole(hole: float) -> list[Thread]:
    """Return the standard threads of bolts that fill a hole, of a diameter in mm, the thickest first."""
    metric = [Thread(size, pitch) for size, pitches in _PITCHES.items() for pitch in pitches[::-1]]
    unified = [
        UnifiedThread(INCH * size, INCH / count, label)
        for label, (size, coarse, fine, _) in _UNIFIED_SIZES.items()
        for count in (fine, coarse)
    ]
    fits = [one for one in (*metric, *unified) if one.diameter <= hole * (1 + 1e-9)]
    fits = [one for one in fits if hole <= one.diameter * (1 + _LOOSEST) * (1 + 1e-9)]
    return sorted(fits, key=lambda one: (-one.diameter, one.pitch))


# Diameter up to which bolts of class 8.8 have the lower strengths, mm.
_THIN = 16.0


@dataclass(frozen=True)
class BoltStrength:
    """Strengths of a bolt, MPa: S_p, under which it keeps its length, R_p0.2 and R_m."""

    proof: float
    yield_strength: float
    ultimate: float


# S_p over R_p0.2 of classes 10.9 and 12.9, for bolts of other strengths.
PROOF_RATIO = 0.88
_STRENGTHS = {
    name: BoltStrength(proof or PROOF_RATIO * yielding, yielding, ultimate)
    for name, (proof, yielding, ultimate) in _DATA["strengths"].items()
}
# Friction by lubricant, and the scatter of the preload, per cent, by the way of tightening.
LUBRICANTS = {Lubricant(name): float(friction) for name, friction in _DATA["lubricants"].items()}
SCATTER: dict[str, tuple[int, int]] = {name: (low, high) for name, (low, high) in _DATA["scatter"].items()}


# Grades of makers, beside the property classes, and those whose yield strength is an estimate.
AFTERMARKET, YIELD_ESTIMATED = frozenset(_DATA["sources"]), frozenset(_DATA["estimated"]["yield"])


def bolt_strength(grade: BoltGrade, diameter: float) -> BoltStrength:
    """Return the strengths of a property class or another grade at a nominal diameter, mm."""
    thick = grade is BoltGrade.G8_8 and diameter > _THIN
    return _STRENGTHS["8.8 thick" if thick else grade]


def grade_source(grade: BoltGrade) -> str:
    """Return where the strengths of a grade come from."""
    up_to = ", up to M16" if grade is BoltGrade.G8_8 else ""
    least = f"Bolt of property class {grade}, least strengths of ISO 898-1:2013, table 3{up_to}"
    source = _DATA["sources"].get(grade, f"{least}; elastic constants typical of steel.")
    return f"{source} The endurance of threads is that of VDI 2230, not of this table."


# Of joint planes: an oblique split of 30° to 60° is usual.
LARGEST_SPLIT = 75.0
# Of thread, head and joint; the extremes are coated and greased, and dry and rough.
_LEAST_FRICTION, _LARGEST_FRICTION = 0.01, 1.0
# Where linear expansion and unchanged moduli describe metals.
_COLDEST, _HOTTEST = -60.0, 300.0
_LARGEST_TIGHTENING_FACTOR = 4.0
# Of machined steel on steel, 0.1 (oiled) to 0.2 (dry) in handbooks; serrated and fractured joints hold more.
JOINT_FRICTION = 0.15
TIGHTENED = ("bolt_preload_kN", "bolt_torque_Nm", "bolt_stretch_mm")
_friction = within(_LEAST_FRICTION, _LARGEST_FRICTION)


@dataclass(frozen=True)
class AssemblyTable(
    StudyTable,
    table="assembly",
    intro="The rod as it is built: cap, bolts, bushing, bearing shells; needs the bolt holes of [rod] "
    "(cap_bolt_mm), or a CAD file with a cap. The pins are in contact. What is left out is assumed, and the "
    "run says what",
    optional=True,
):
    """[assembly]: one of preload, torque and stretch; `fea.judge.bolt_choice` assumes what is left out."""

    split: CapJoint | float = key(
        '"straight"',
        "or the angle in degrees between the normal of an oblique joint and the rod",
        default=CapJoint.STRAIGHT,
    )
    bolt_preload_kN: Positive | None = key(
        "28.0", "of each bolt; or one of the next two. Default: 90 % of its yield strength, as in VDI 2230"
    )
    bolt_torque_Nm: Positive | None = key("35.0")
    bolt_angle_deg: float | None = key(
        "60.0",
        "by which the bolt is turned on after bolt_torque_Nm, the snug torque",
        within(1.0, 360.0),
        needs="bolt_torque_Nm, the snug torque from which it counts",
    )
    bolt_stretch_mm: Positive | None = key("0.12", "of the bolt between its ends; 0.001 inch is 0.0254 mm")
    bolt_lubricant: Lubricant | None = key(
        '"moly"', '"oil", "as-delivered" or "dry": the friction of thread and head where it is not given'
    )
    thread_friction: float | None = key("0.12", "", _friction)
    head_friction: float | None = key("0.12", "under the head", _friction)
    bolt_thread: str | None = key(
        '"M8x1"', 'or inches, as "3/8-24"; default: the largest that goes through the hole, with a fine pitch'
    )
    bolt_grade: BoltGrade | float | None = key(
        '"10.9"',
        'property class, 8.8 to 12.9, or "ARP 8740", "ARP 2000", "L19", "Custom Age 625+"; others by their '
        "strengths in [material.bolt]",
    )
    bolt_thread_rolled: ThreadRolled | None = key(
        '"before-heat-treatment"', 'or "after-heat-treatment", which bears more'
    )
    bolt_grip_mm: Positive | None = key(
        "40.0", "from the seat of the head to that of the nut; less: a screw in a threaded hole"
    )
    bolt_engaged_mm: Positive | None = key("10.0", "thread of a screw in the rod")
    bolt_head_mm: Positive | None = key("11.6", "outer diameter of the seat under the head")
    bolt_nut_mm: Positive | None = key("11.6", "under the nut")
    bolt_shank_mm: Positive | None = key("8.0")
    bolt_free_thread_mm: NotNegative | None = key("12.8", "length of thread within the grip")
    bolt_embedding_um: NotNegative | None = key(
        "11.0", "of all surfaces of a bolt together, which takes some of its preload"
    )
    bolt_tightening_factor: float | None = key(
        "1.6", "largest over least preload of the way of tightening", within(1.0, _LARGEST_TIGHTENING_FACTOR)
    )
    bushing_interference_mm: NotNegative | None = key("0.04", "diametral; without it the bushing is bonded")
    shell_thickness_mm: Positive | None = key("1.5", "bearing shells inside the big end's ring")
    shell_interference_mm: NotNegative | None = key("0.03", "diametral, from the crush of both shells")
    joint_friction: float | None = key("0.15", "between cap and rod", within(0.0, _LARGEST_FRICTION))
    temperature_C: float | None = key(
        "120.0",
        "of all parts: fits and preload change with it from 20 °C; moduli do not",
        within(_COLDEST, _HOTTEST),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        within(-LARGEST_SPLIT, LARGEST_SPLIT)("assembly.split", self.split_angle)
        for keys in (TIGHTENED, ("bolt_nut_mm", "bolt_engaged_mm")):
            given = [name for name in keys if getattr(self, name) is not None]
            rule = f"cannot be combined with {' and '.join(given[1:])}"
            for name in given[:-1]:
                raise InvalidValue(f"assembly.{name}", getattr(self, name), rule, "Keep one of them.")
        _ = self.thread, self.grade

    @property
    def split_angle(self) -> float:
        """Angle of the joint plane's normal from the rod's axis, degrees."""
        return 0.0 if isinstance(self.split, CapJoint) else float(self.split)

    @property
    def bushing_touches(self) -> bool:
        """Whether the bushing is pressed in, and not bonded to the rod."""
        return self.bushing_interference_mm is not None

    @property
    def friction(self) -> float:
        """Friction between the parts, `JOINT_FRICTION` if it is not given."""
        return JOINT_FRICTION if self.joint_friction is None else self.joint_friction

    @property
    def thread(self) -> Thread | None:
        """The bolts' thread, if it is given."""
        return None if self.bolt_thread is None else parse_thread("assembly.bolt_thread", self.bolt_thread)

    @property
    def grade(self) -> BoltGrade | None:
        """The bolts' property class, if it is given; a study may say 10.9 without quotes."""
        if self.bolt_grade is None:
            return None
        text = f"{self.bolt_grade:g}" if isinstance(self.bolt_grade, float) else str(self.bolt_grade)
        if text not in list(BoltGrade):
            rule, others = "is not a grade of bolts", "yield_MPa and ultimate_MPa in [material.bolt]"
            remedy = f"{nearest(text, BoltGrade)} For others give {others}."
            raise InvalidValue("assembly.bolt_grade", self.bolt_grade, rule, remedy)
        return BoltGrade(text)

    def require_dimensions(self, rod: Rod) -> None:
        """Refuse a parametric rod that lacks what the assembly needs.

        Raises `InvalidValue`: it has no bolt holes, or an interference is given for a bushing or shells that
        it does not have.
        """
        rule = "is missing: [assembly] splits the big end, and bolts hold the cap"
        remedy = "Give the diameter of the bolt holes, with cap_bolt_spacing_mm, cap_boss_length_mm and "
        require(rod.cap_bolt > 0, "rod.cap_bolt_mm", None, rule, remedy + "cap_boss_fillet_mm, in [rod].")
        value, rule = self.bushing_interference_mm, "needs a bushing in the small end"
        remedy = "Give its wall thickness as rod.bushing_mm."
        fits = value is None or rod.bushing > 0
        require(fits, "assembly.bushing_interference_mm", value, rule, remedy)
        rule, remedy = "needs shell_thickness_mm", "Give the thickness of the shells."
        alone = self.shell_thickness_mm is None and self.shell_interference_mm is not None
        require(not alone, "assembly.shell_interference_mm", self.shell_interference_mm, rule, remedy)
