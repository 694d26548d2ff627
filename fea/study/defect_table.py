"""[defect] of a study: a flaw that the rod may have, and how cracks grow in its material."""

import re
from dataclasses import dataclass

from fea.base.material import CrackMetal
from fea.base.shipped import TomlTable, shipped_toml
from fea.study.material_table import MaterialTable
from fea.study.tables import Positive, StudyTable, key
from geometry.errors import InvalidValue, require

_CRACKS = shipped_toml("study/cracks.toml")
_NUMBER = r"\s*([+-]?(?:\d+\.?\d*|\.\d+))\s*"
_FLAW = re.compile(rf"{_NUMBER}[x×]{_NUMBER}(?:@{_NUMBER},{_NUMBER},{_NUMBER})?")
# In the order of `CrackMetal`.
_KEYS = ("growth_coefficient", "growth_exponent", "threshold_MPa_m05", "toughness_MPa_m05")
_EXAMPLE = "Write --defect 0.4x6, or --defect 0.4x6@70,6.6,3."


@dataclass(frozen=True)
class Flaw:
    """A flaw, mm: half an ellipse at the surface, or a whole one inside."""

    depth: float
    length: float
    at: tuple[float, ...] = ()  #: (3,) in the rod frame; empty: where such a flaw grows first


@dataclass(frozen=True)
class DefectTable(
    StudyTable,
    table="defect",
    intro="A flaw of the rod, and how cracks grow, da/dN = C ΔK^m; switches the crank cycle on",
    optional=True,
):
    """[defect]: stress intensities are in MPa √m."""

    size: str | None = key(
        '"0.4x6@70,6.6,3"',
        "a flaw, DEPTHxLENGTH in mm, and where: does it grow over the cycle? Default: where it grows first",
        flag="defect",
    )
    normal: tuple[float, ...] | None = key(
        "[1, 0, 0]", "of the plane of the flaw; default: the worst, across the largest principal stress"
    )
    threshold_MPa_m05: Positive | None = key("5.4", "of long cracks, at any R, below 0 of the highest K")
    growth_coefficient: Positive | None = key("1.65e-8", "C, mm", needs="growth_exponent, its m")
    growth_exponent: Positive | None = key("3.0", "m", needs="growth_coefficient, its C")
    toughness_MPa_m05: Positive | None = key("50.0", "at which the rest breaks")
    service_hours: Positive | None = key("250.0", "until the next inspection: how deep it is then")

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.flaw
        given, rule = self.normal, "must have three components, x, y and z, that are not all 0"
        require(given is None or (len(given) == 3 and any(given)), "defect.normal", list(given or ()), rule)

    @property
    def flaw(self) -> Flaw | None:
        """The flaw, where one is given. Raises `InvalidValue`: another form, or a size not above 0."""
        if self.size is None:
            return None
        if (found := _FLAW.fullmatch(self.size)) is None:
            rule = "must be DEPTHxLENGTH in mm, and may say where, @x,y,z"
            raise InvalidValue("defect.size", self.size, rule, _EXAMPLE)
        depth, length, *at = (float(part) for part in found.groups() if part)
        require(depth > 0 and length > 0, "defect.size", self.size, "must be larger than 0", _EXAMPLE)
        return Flaw(depth, length, tuple(at))

    def metal(self, material: MaterialTable) -> CrackMetal:
        """Return how cracks grow. Raises `InvalidValue`: a figure is not given, nor known of the metal."""
        modulus = material.resolved().needed("E_GPa")
        among = (of for of in _CRACKS.values() if of["E_GPa"][0] <= modulus <= of["E_GPa"][1])
        known: TomlTable = next(among, {})
        values, assumed = list[float](), list[str]()
        for name in _KEYS:
            given, rule = getattr(self, name), f"is missing, and known of {' and '.join(_CRACKS)} only"
            require(given or name in known, f"defect.{name}", None, rule, "Give it in [defect].")
            values.append(given or known[name])
            assumed += [] if given else [f"{name} {known[name]:g}"]
        C, m, threshold, toughness = values
        slope, least = (0.0 if self.threshold_MPa_m05 else known[name] for name in ("slope", "least"))
        return CrackMetal(C, m, threshold, toughness, slope, least, tuple(assumed))
