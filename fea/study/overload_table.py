"""[overload] of a study: a load that the rod bears once, and by how much it may be deformed for good."""

from dataclasses import dataclass

from fea.study.tables import NotNegative, Positive, StudyTable, key
from geometry.errors import require

# Limits of the permanent set. Bend and twist: 0.05 and 0.15 mm over 100 mm, Toyota's repair manual of the
# 2GR-FSE (2007); bores out of round: 10 and 8 µm, Ford's of the 2.0 SOHC (1997); shortening: half of the
# tolerance of the length between the bores, 154.66 to 154.74 mm, Ford's of the 4.2 V6 (2007).
SHORTENING_UM, BEND_UM, TWIST_DEG, BIG_END_UM, SMALL_END_UM = 40.0, 50.0, 0.086, 10.0, 8.0
# The shank's bow before it is loaded, over the distance of the bores (assumed).
BOW = 1e-3
LOADS = ("knock_bar", "liquid_ml", "force_N")


@dataclass(frozen=True)
class OverloadTable(
    StudyTable,
    table="overload",
    intro="A single overload, and the limits of the permanent set that it or running leaves; one of "
    "knock_bar, liquid_ml and force_N at most",
    optional=True,
):
    """[overload]: one load at most."""

    knock_bar: Positive | None = key(
        "150.0", "absolute peak pressure of a knocking cycle, in the mean over the piston"
    )
    liquid_ml: Positive | None = key(
        "60.0", "liquid in the cylinder when the intake shuts (hydrolock)", alias="liquid_cm3"
    )
    force_N: Positive | None = key("90000.0", "that compresses the rod")
    energy_J: Positive | None = key(
        "400.0",
        "of crank and flywheel, which bends the rod until it is used up; default: unlimited",
        needs="liquid_ml: a pressure or a force lasts",
    )
    bow_mm: Positive | None = key(
        "0.15", "of the unloaded shank, in its first mode; default: a thousandth of its length (assumed)"
    )
    most_shortening_um: NotNegative = key(
        "40.0", "permanent set that is accepted: of the distance of the bores", default=SHORTENING_UM
    )
    most_bend_um: NotNegative = key(
        "50.0", "bores' axes out of parallel over 100 mm, seen from the side of the rod", default=BEND_UM
    )
    most_twist_deg: NotNegative = key("0.086", "one bore's axis against the other's", default=TWIST_DEG)
    most_big_end_um: NotNegative = key("10.0", "out of round: big end's bore", default=BIG_END_UM)
    most_small_end_um: NotNegative = key("8.0", "out of round: small end's bore", default=SMALL_END_UM)

    def __post_init__(self) -> None:
        super().__post_init__()
        given = [name for name in LOADS if getattr(self, name) is not None]
        name, rule = f"overload.{self.load}", f"is given with {', '.join(given[1:])}: an overload is one load"
        require(len(given) < 2, name, getattr(self, self.load, None), rule, "Remove one of them.")

    @property
    def load(self) -> str:
        """The key of the overload; empty where there is none."""
        return next((name for name in LOADS if getattr(self, name) is not None), "")

    @property
    def limits(self) -> dict[str, float]:
        """Limits by the names of what is left, µm and degrees."""
        return {
            "length": self.most_shortening_um,
            "bend": self.most_bend_um,
            "twist_deg": self.most_twist_deg,
            "big_end": self.most_big_end_um,
            "small_end": self.most_small_end_um,
        }
