"""The tables of a study about given forces, mesh, analysis, pins, optimisation and output."""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fea.base import choices
from fea.study.files import absolute
from fea.study.pin_models import FILM, PRESCRIBED, contact_excluded_because, pin_model
from fea.study.rod_table import LEAST, dimension_of
from fea.study.tables import (
    NotNegative,
    Positive,
    StudyTable,
    choice,
    key,
    read_keys,
    read_table,
    switch,
    within,
)
from geometry.dimensions import dimensions
from geometry.dimensions import key as key_of
from geometry.errors import require, require_number, require_positive


@dataclass(frozen=True)
class GaugeTable(
    StudyTable, table="gauge", intro="A strain gauge on the surface, [[gauge]] for each", optional=True
):
    """A strain gauge."""

    at_mm: tuple[float, ...] = key("[70.0, 0.0, 8.0]", "put on the nearest free surface", default=MISSING)
    direction: tuple[float, ...] = key("[1, 0, 0]", "of its grid, along the surface", default=MISSING)
    length_mm: Positive = key("3.0", "of its grid, over which strain is averaged", default=MISSING)
    name: str | None = key('"shank"')
    measured: tuple[float, ...] | None = key(
        "[820, -310]", "strains, µm/m, one for each load case in its order"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, three in (("at_mm", self.at_mm), ("direction", self.direction)):
            rule = "must have three components, x, y and z; those of a direction are not all 0"
            require(len(three) == 3 and (any(three) or name == "at_mm"), f"gauge.{name}", list(three), rule)


def read_gauges(raw: Any) -> tuple[GaugeTable, ...]:
    """Read the gauges of a study, tables of keys or `GaugeTable`.

    Raises `InvalidValue`: no list of tables, a wrong key, a broken rule, or two gauges of one name.
    """
    rule = "must be a list of tables"
    require(isinstance(raw, list | tuple), "gauge", str(raw), rule, "Write [[gauge]] above each.")
    gauges = tuple(
        each if isinstance(each, GaugeTable) else read_table(GaugeTable, "gauge", each) for each in raw
    )
    names = [gauge.name for gauge in gauges if gauge.name is not None]
    for name in names:
        rule = "is the name of two gauges"
        require(names.count(name) == 1, "gauge.name", name, rule, "Give each its own.")
    return gauges


LARGEST_STEP = 360.0  # degrees, of the cycle's fields for ParaView


@dataclass(frozen=True)
class ForcesTable(
    StudyTable,
    table="forces",
    intro="Instead of [engine] and [speed]: given forces on the piston pin, [axial, transverse], tension "
    "positive",
    optional=True,
):
    """[forces]: given pin forces instead of an engine."""

    pin_N: tuple[float, ...] = key("[-45914.89, 0.0]", "along the rod, and across it", default=MISSING)
    ratio: float | None = key(
        "-1.25", "fatigue test: R, least over largest axial force; pin_N is either of them", require_number
    )

    def pin(self) -> tuple[float, float]:
        """Return (axial, transverse), N, tension positive."""
        require(len(self.pin_N) == 2, "forces.pin_N", list(self.pin_N), "must be [axial, transverse]")
        axial, transverse = (require_number("forces.pin_N", value) for value in self.pin_N)
        rule = "at least one component must not be zero"
        require(axial != 0 or transverse != 0, "forces.pin_N", list(self.pin_N), rule)
        return axial, transverse

    def levels(self) -> tuple[float, float] | None:
        """Return the largest and the least axial force of a fatigue test, N; None where the force rests."""
        (axial, transverse), ratio = self.pin(), self.ratio
        if ratio is None:
            return None
        rule = "needs a force along the rod alone: the second number of pin_N must be 0"
        require(transverse == 0, "forces.ratio", ratio, rule)
        rule = "must be below 1: the least force over the largest; equal ones make no cycle"
        require(ratio < 1, "forces.ratio", ratio, rule, "Exchange the forces, or leave it out.")
        rule = f"must be below 0 where pin_N ({axial:g} N) compresses, as the largest force is pin_N / ratio"
        require(axial > 0 or ratio < 0, "forces.ratio", ratio, rule, "Give the largest force as pin_N.")
        return (axial, ratio * axial) if axial > 0 else (axial / ratio, axial)


@dataclass(frozen=True)
class MeshTable(StudyTable, table="mesh"):
    """[mesh]."""

    size_mm: Positive | None = key(
        "3.0",
        "element size, smaller on fillets, bores and webs: no refinement unless a tolerance is given",
        flag="size",
    )
    element: choices.Element = choice(
        choices.Element.P2, "order of the tetrahedra: p1 (4 nodes) or p2 (10 nodes)", "element"
    )


@dataclass(frozen=True)
class AnalysisTable(StudyTable, table="analysis"):
    """[analysis]."""

    support: choices.Support = choice(
        choices.Support.INERTIA_RELIEF,
        "boundary condition: inertia-relief (nothing is clamped), or clamped at the big end, as in many "
        "published models",
        "support",
    )
    symmetry: choices.Symmetry = choice(
        choices.Symmetry.AUTO,
        "part of the rod to solve: none, half or quarter; auto: the smallest that its mirror planes allow",
        "symmetry",
    )
    pressure: str | None = key(
        '"contact"',
        "pin load on the bores: contact with the pins, a prescribed pressure (cosine-180, uniform-120, "
        "cosine-ARC, webster), or bonded: traction along the force over the whole bore, as Ansys' Force on a "
        f"face; default: contact, or {PRESCRIBED} where contact cannot be computed",
        flag="pressure",
    )
    solver: choices.SolverName = choice(
        choices.SolverName.AUTO,
        "linear solver: pardiso, cholmod or amg; auto chooses by the memory that it needs",
        "solver",
    )
    matrix_assembly: choices.MatrixAssembly = choice(
        choices.MatrixAssembly.BATCHED,
        "assembly of the stiffness matrix: batched, or scikit-fem: the same from its weak form, more slowly",
        "matrix_assembly",
        alias="assembly",
    )
    unusual: bool = switch("accept values far outside of the ranges in which engines exist", "unusual")
    cycle: bool = switch(
        "analyse the whole crank cycle, degree by degree: stress envelope, histories, fatigue", "cycle"
    )
    cycle_accuracy: choices.CycleAccuracy = choice(
        choices.CycleAccuracy.FAST,
        "stress over the cycle under contact: fast (smallest safety factors within 1e-4, other stresses "
        "within 0.5 % of the largest), or exact at every node and instant, which takes longer",
        "cycle_accuracy",
        stated=False,
    )
    fatigue: choices.Fatigue = choice(
        choices.Fatigue.GOODMAN,
        "mean-stress correction over the cycle: goodman, gerber or soderberg",
        "fatigue",
        stated=False,
    )
    fretting: bool = switch(
        "find where the parts of [assembly] rub over the crank cycle (fretting); includes the cycle",
        "fretting",
    )
    proven_ruiz_2: Positive | None = key(
        "20.0",
        "σ τδ in MPa²·mm that has served without a crack, as a run of that rod with such elements found it: "
        "what fretting is compared with",
    )
    film: bool = switch("compute the oil films of both bearings over the crank cycle, as [film] says", "film")
    elastic: bool = switch("leave out plastic flow: what exceeds the yield strength fails", "elastic")
    buckling: bool = switch("compute the buckling load factors and shapes of the solid", "buckling")
    tolerance_percent: NotNegative | None = key(
        "2",
        "refine the mesh until the error bar of the smallest safety factor is at most this; default: 5, but "
        "none with an element size or first-order elements; 0: never",
        flag="tolerance",
    )
    all_cases: bool = switch(
        "refine until the peak of every load case is within the tolerance, also of those that cannot govern",
        "all_cases",
    )
    draft: bool = switch("stop at the first mesh of a refinement, with the error bars as they are", "draft")
    min_safety: Positive | None = key(
        "1.5",
        "exit with code 6 unless every safety factor of the run, less its error bar, reaches this",
        flag="min_safety",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "cycle", self.cycle or self.fretting)
        if self.in_contact:
            clamped = self.support is choices.Support.CLAMPED
            remedy = "Use inertia-relief." if clamped else "Choose another --solver."
            require(not self._excluded, "analysis.pressure", self.pressure, self._excluded, remedy)

    @property
    def _excluded(self) -> str:
        return contact_excluded_because(self.support, self.solver)

    @property
    def pin_load(self) -> str:
        """The pressure that is asked for, or contact, or what takes its place where it cannot be."""
        return self.pressure or (PRESCRIBED if self._excluded else choices.CONTACT)

    @property
    def needs_film(self) -> bool:
        """Whether the oil film is computed: for itself, or because it loads the big end."""
        return self.film or self.pressure == FILM

    @property
    def in_contact(self) -> bool:
        """Whether the bores touch pins as [contact] says."""
        return pin_model(self.pin_load).in_contact


@dataclass(frozen=True)
class OutputTable(StudyTable, table="output"):
    """[output]."""

    screenshot: bool | None = key(
        "false",
        "save a .png picture of each load case next to its .vtu file, or none; default: if a run of one "
        "speed takes at least four times as long as its pictures do",
        flag="screenshot",
        writes=True,
    )
    report: bool = key(
        "false",
        "save report.html: the whole analysis in one file, with the rod in 3-D, for any browser, offline",
        default=False,
        stated=True,
        flag="report",
    )
    units: choices.UnitSystem = choice(
        choices.UnitSystem.SI,
        "of tables, pictures, plots and report: si, or us (in, lbf, psi, lb, °F, hp); data files are in SI "
        "units and mm all the same",
        "units",
    )
    pvd_step_deg: float | None = key(
        "10",
        "save the fields of the cycle every so many degrees, for ParaView to play; needs the cycle",
        within(1, LARGEST_STEP),
        flag="pvd_step",
        writes=True,
    )
    animate: str | None = key(
        '"cycle.gif"',
        "write an animation of the cycle to this file (.gif; .mp4 with imageio-ffmpeg); needs the cycle",
        flag="animate",
        kind=Path,
        parse=partial(absolute, "--animate"),
        writes=True,
    )
    directory: str | None = key(
        '"results/my-rod"',
        "directory of the results; default: results/STUDY-RPMrpm. Only an earlier run is ever replaced",
        flag="out",
        kind=Path,
        parse=partial(absolute, "--out"),
        writes=True,
    )


# Names of the [material.…] tables that belong to pins and not to parts of the rod.
PISTON_PIN, CRANK_PIN = "piston_pin", "crank_pin"
PINS = (PISTON_PIN, CRANK_PIN)


@dataclass(frozen=True)
class ContactTable(
    StudyTable,
    table="contact",
    intro='The pins, with pressure = "contact": what is left out is assumed from the bores, and the run says '
    "what",
):
    """[contact]: clearances are diametral, bore less pin; negative ones are press fits.

    `small_end_relief_mm` is how far from either end the small end's bore widens towards it, and by how much
    of its radius.
    """

    small_end_clearance_mm: float | None = key(
        "0.0144", "diametral, bore less pin; negative: a press fit", require_number
    )
    big_end_clearance_mm: float | None = key("0.052", "", require_number)
    piston_pin: choices.PinBody = key(
        '"elastic"',
        'or "rigid"; the crank pin is rigid unless [material.crank_pin] is given',
        default=choices.PinBody.ELASTIC,
    )
    piston_pin_bore_mm: NotNegative | None = key("14.4", "0: a solid pin")
    piston_pin_length_mm: NotNegative | None = key("64.8")
    piston_boss_gap_mm: NotNegative | None = key(
        "26.4", "distance of the piston's bosses, beyond which they carry the pin"
    )
    small_end_relief_mm: tuple[Positive, ...] | None = key(
        "[4.0, 0.02]", "length and radial depth by which the bore widens towards its ends"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        given = self.small_end_relief_mm
        rule = "must be [length, depth]"
        require(given is None or len(given) == 2, "contact.small_end_relief_mm", list(given or ()), rule)


# With fewer no direction can be compared with another; with more than a quadratic model of each figure gains.
FEWEST, MOST = 20, 10_000
_BOUNDS = "must be two lengths, from and to, in mm: [4.0, 7.0]"


@dataclass(frozen=True)
class OptimiseTable(
    StudyTable,
    table="optimise",
    intro="What fea optimise may change, and the factors that the lightest rod must meet; other commands "
    "ignore it",
    optional=True,
):
    """[optimise]: free dimensions and bounds, least wall, factors (default: `analysis.min_safety`, or 1)."""

    free: dict[str, tuple[float, ...]] = key(
        "{ web_thickness_mm = [3.0, 7.0], big_end_ring_mm = [6.0, 12.0] }",
        "dimensions with their bounds, mm; default: shank, web, flanges and rings, each from 0.6 to 1.4 "
        "times what it is",
        entries=lambda: [key_of(name) for name in dimensions()],
        default=dict,
    )
    min_yield_safety: Positive | None = key(
        "1.2", "over the whole cycle, less the error bar; default of all three: min_safety, or 1"
    )
    min_fatigue_safety: Positive | None = key("1.3", "less the error bar of the stress")
    min_buckling_safety: Positive | None = key("3.0", "against buckling as a column")
    min_hours: Positive | None = key(
        "200", "hours that it lasts at each speed, in place of min_fatigue_safety, less the error bar"
    )
    min_film_um: Positive | None = key(
        "1.0",
        "oil film of the big end, as [film] says, over the crank cycle at each speed, less its error bar",
    )
    min_rpm: Positive | None = key(
        "7500", "speed, rpm, at which they must hold too, as at the study's own speeds"
    )
    least_wall_mm: Positive | None = key(
        "3.0", "thinnest web, flange, ring or wall beside a bolt hole; default: 3, or that of the rod"
    )
    evaluations: int | None = key("150", "most meshes to be solved", within(FEWEST, MOST))

    def __post_init__(self) -> None:
        super().__post_init__()
        for dimension, bounds in self.free.items():
            name = f"optimise.free.{dimension}"
            dimension_of(dimension)
            rule = "cannot be free: crankshaft, piston pin and cylinder block decide it"
            require(dimension not in LEAST, name, None, rule, "Leave it out.")
            require(len(bounds) == 2, name, list(bounds), _BOUNDS)
            low, high = (require_positive(name, bound) for bound in bounds)
            rule = "must rise: the first bound is not below the second"
            require(low < high, name, list(bounds), rule, "Exchange them, or leave the dimension out.")


def parse_free(given: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Return bounds, mm, by dimension of ``web_thickness_mm=3:7`` or ``…=0.1in:0.3in``, or `InvalidValue`."""
    free: dict[str, list[float | str]] = {}
    for text in given:
        name, _, bounds = text.partition("=")
        ends = [bound.strip() for bound in bounds.split(":")]
        rule = "must name a dimension with its bounds in mm, as web_thickness_mm=3:7"
        require(len(ends) == 2 and all(ends), "--free", text, rule)
        require(name.strip() not in free, "--free", text, "names a dimension twice", "Leave one out.")
        free[name.strip()] = [_plain_number(end) for end in ends]
    return OptimiseTable(**read_keys(OptimiseTable, "optimise", {"free": free})).free


def _plain_number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
