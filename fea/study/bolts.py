"""Metric threads: basic dimensions of the ISO profile (ISO 68-1, ISO 724), and standard pitches."""

import math
import re
import tomllib
from dataclasses import dataclass
from importlib.resources import files

from fea.base.choices import BoltGrade
from fea.study.tables import nearest
from geometry.errors import InvalidValue, require

_DATA = tomllib.loads((files("fea") / "study" / "bolts.toml").read_text(encoding="utf-8"))
_PITCHES = {float(size): pitches for size, pitches in _DATA["pitches"].items()}
# Standard threads have a pitch of 0.045 to 0.18 of their diameter, so that these bounds hold any thread.
_LEAST_PITCH, _LARGEST_PITCH = 0.03, 0.2
_NAME = re.compile(r"\s*M\s*(\d{1,3}(?:\.\d{1,6})?)(?:\s*[xX×]\s*(\d{1,2}(?:\.\d{1,6})?))?\s*")


@dataclass(frozen=True)
class Thread:
    """A metric thread: nominal diameter d and pitch P, mm; basic dimensions, without tolerances."""

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


def parse_thread(key: str, name: str) -> Thread:
    """Read a designation: M9x1, or M10 for the coarse pitch.

    Raises
    ------
    InvalidValue
        It is none, has no standard pitch, or one that no thread has.
    """
    named = _NAME.fullmatch(name)
    remedy = 'Give diameter and pitch in mm, as "M9x1".'
    if named is None:
        raise InvalidValue(key, name, "is not a metric thread", remedy)
    diameter = float(named[1])
    rule = "its diameter must be 2 to 100 mm"
    require(2 <= diameter <= 100, key, name, rule, "Give it in mm.")
    if named[2] is None:
        names = [f"M{size:g}" for size in _PITCHES]
        rule = "has no standard pitch"
        require(diameter in _PITCHES, key, name, rule, f"{remedy} {nearest(name, names)}")
        return Thread(diameter, _PITCHES[diameter][0])
    pitch = float(named[2])
    least, most = _LEAST_PITCH * diameter, _LARGEST_PITCH * diameter
    rule = f"its pitch must be {least:.3g} to {most:.3g} mm"
    require(least <= pitch <= most, key, name, rule, remedy)
    return Thread(diameter, pitch)


def thread_in_hole(hole: float) -> Thread | None:
    """Return the largest fine thread that goes through a hole of a diameter in mm; None where none does."""
    sizes = [size for size in _PITCHES if size <= hole * (1 + 1e-9)]
    return Thread(sizes[-1], _PITCHES[sizes[-1]][1]) if sizes else None


# Diameter up to which bolts of class 8.8 have the lower strengths, mm.
_THIN = 16.0


@dataclass(frozen=True)
class BoltStrength:
    """Strengths of a bolt, MPa: S_p, under which it keeps its length, R_p0.2 and R_m."""

    proof: float
    yield_strength: float
    ultimate: float


_STRENGTHS = {name: BoltStrength(*values) for name, values in _DATA["strengths"].items()}
# S_p over R_p0.2 of classes 10.9 and 12.9, for bolts of other strengths.
PROOF_RATIO = 0.88


def bolt_strength(grade: BoltGrade, diameter: float) -> BoltStrength:
    """Return the strengths of a property class at a nominal diameter, mm."""
    thick = grade is BoltGrade.G8_8 and diameter > _THIN
    return _STRENGTHS["8.8 thick" if thick else grade]
