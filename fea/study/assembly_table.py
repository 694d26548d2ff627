"""[assembly] of a study file: cap, bolts, bushing and bearing shells, of a rod as it is built."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from fea.base.choices import BoltGrade, Lubricant, Split, ThreadRolled
from fea.study.bolts import Thread, parse_thread
from fea.study.material_table import MaterialTable
from fea.study.tables import Table, key, nearest, not_negative, within
from geometry.errors import InvalidValue, require, require_positive
from geometry.rod import Rod

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
    Table,
    table="assembly",
    intro="The rod as it is built: cap, bolts, bushing, bearing shells; needs the bolt holes of [rod] "
    "(cap_bolt_mm), or a CAD file with a cap. The pins are in contact. What is left out is assumed, and the "
    "run says what",
    optional=True,
):
    """[assembly]: one of preload, torque and stretch; `fea.judge.bolt_choice` assumes what is left out."""

    split: Split | float = key(
        '"straight"',
        "or the angle in degrees between the normal of an oblique joint and the rod",
        default=Split.STRAIGHT,
    )
    bolt_preload_kN: float | None = key(
        "28.0",
        "of each bolt; or one of the next two. Default: 90 % of its yield strength, as in VDI 2230",
        require_positive,
    )
    bolt_torque_Nm: float | None = key("35.0", "", require_positive)
    bolt_angle_deg: float | None = key(
        "60.0", "by which the bolt is turned on after bolt_torque_Nm, the snug torque", within(1.0, 360.0)
    )
    bolt_stretch_mm: float | None = key(
        "0.12", "of the bolt between its ends; 0.001 inch is 0.0254 mm", require_positive
    )
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
    bolt_grip_mm: float | None = key(
        "40.0",
        "from the seat of the head to that of the nut; less: a screw in a threaded hole",
        require_positive,
    )
    bolt_engaged_mm: float | None = key("10.0", "thread of a screw in the rod", require_positive)
    bolt_head_mm: float | None = key("11.6", "outer diameter of the seat under the head", require_positive)
    bolt_nut_mm: float | None = key("11.6", "under the nut", require_positive)
    bolt_shank_mm: float | None = key("8.0", "", require_positive)
    bolt_free_thread_mm: float | None = key("12.8", "length of thread within the grip", not_negative)
    bolt_embedding_um: float | None = key(
        "11.0", "of all surfaces of a bolt together, which takes some of its preload", not_negative
    )
    bolt_tightening_factor: float | None = key(
        "1.6", "largest over least preload of the way of tightening", within(1.0, _LARGEST_TIGHTENING_FACTOR)
    )
    bushing_interference_mm: float | None = key(
        "0.04", "diametral; without it the bushing is bonded", not_negative
    )
    shell_thickness_mm: float | None = key(
        "1.5", "bearing shells inside the big end's ring", require_positive
    )
    shell_interference_mm: float | None = key(
        "0.03", "diametral, from the crush of both shells", not_negative
    )
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
        rule, snug = "needs bolt_torque_Nm, the snug torque from which it counts", self.bolt_torque_Nm
        angle = self.bolt_angle_deg
        require(angle is None or snug is not None, "assembly.bolt_angle_deg", angle, rule, "Give both.")
        _ = self.thread, self.grade

    @property
    def split_angle(self) -> float:
        """Angle of the joint plane's normal from the rod's axis, degrees."""
        return 0.0 if isinstance(self.split, Split) else float(self.split)

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


# Names of the [material.…] tables, and of the parts that they are for.
BOLT, BUSHING, SHELL = "bolt", "bushing", "shell"
UPPER_SHELL, LOWER_SHELL = "upper shell", "lower shell"
_SHELLS = (UPPER_SHELL, LOWER_SHELL)
DEFAULT_GRADE = BoltGrade.G10_9
_ASSUMED = {BUSHING: "cusn8p", SHELL: "steel-backed-shell"}


def table_name(part: str) -> str:
    """Return the name of the [material.…] table that a part's material stands in."""
    return SHELL if part in _SHELLS else part


def assembled(given: Mapping[str, MaterialTable], part: str, otherwise: MaterialTable) -> MaterialTable:
    """Material of a part: of its [material.<part>] table in `given`, or `otherwise`, that of rod and cap."""
    name = table_name(part)
    if part in given or name in given:
        return given[part if part in given else name]
    return MaterialTable(preset=_ASSUMED[name]) if name in _ASSUMED else otherwise


def bolt_material(given: Mapping[str, MaterialTable], grade: BoltGrade | None) -> MaterialTable:
    """Return the material of the bolts: that of [material.bolt], completed by a property class."""
    bolts = given.get(BOLT, MaterialTable())
    return bolts if bolts.preset else replace(bolts, preset=f"bolt-{grade or DEFAULT_GRADE}")


def assumed_materials(given: Mapping[str, MaterialTable], parts: tuple[str, ...]) -> tuple[str, ...]:
    """Say which materials of parts are assumed, with their figures."""
    names = dict.fromkeys(table_name(part) for part in parts if part not in given)
    tables = {name: MaterialTable(preset=_ASSUMED[name]).resolved() for name in names if name in _ASSUMED}
    return tuple(
        f"{name} of {_ASSUMED[name]}, {table.E_GPa:g} GPa, yield strength {table.yield_MPa:g} MPa "
        f"([material.{name}])"
        for name, table in tables.items()
        if name not in given
    )
