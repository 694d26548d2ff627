"""The figures of a run, as `summary.json` holds them: names carry the unit.

A field that is None is written as ``null``; one declared as `WhereKnown` is left out then.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.base.checks import Check
from fea.base.note import Note
from fea.run.assembly_figures import AssemblyFigures
from fea.run.cycle_figures import (
    CycleFigures,
    EnvelopeFigures,
    LifeFigures,
)
from fea.run.figure_types import Vector, WhereKnown
from fea.run.summary_file import SCHEMA


@dataclass(frozen=True, kw_only=True)
class RodFigures:
    """``rod``: mass properties of the meshed rod; the inertia is I_z about the centre of gravity."""

    mass_kg: float
    center_of_gravity_mm: Vector
    inertia_kg_m2: float
    length_mm: float


@dataclass(frozen=True, kw_only=True)
class EngineFigures:
    """``engine``."""

    crank_radius_mm: float
    rod_length_mm: float
    bore_mm: float
    piston_mass_kg: float


@dataclass(frozen=True, kw_only=True)
class LoadFigures:
    """``loads``: what acts in a load case; None where it does not apply, as a crank angle to given forces."""

    crank_deg: float | None
    gas_N: float | None
    pin_axial_N: float
    pin_transverse_N: float
    crank_axial_N: float
    crank_transverse_N: float
    wall_N: float | None
    torque_Nm: float | None


@dataclass(frozen=True, kw_only=True)
class QualityFigures:
    """Quality of the elements, and what was done about bad ones."""

    least_scaled_jacobian: float
    least_shape: float
    median_shape: float
    worst_at_mm: Vector
    straightened_elements: int
    repairs: tuple[str, ...]
    repaired_size_mm: float | None


@dataclass(frozen=True, kw_only=True)
class ModelFigures:
    """``model``: nodes, elements and dofs of the whole rod as written; `solved_dofs` were factorised.

    `mesh_from_file` is true where the study gives the mesh, which cannot be refined.
    """

    nodes: int
    elements: int
    dofs: int
    solved_dofs: int
    element: str
    formulation: str
    size_mm: float
    symmetry: str
    support: str
    pressure: str
    solver: str
    assembly: str
    quality: QualityFigures
    mesh_from_file: WhereKnown[bool] = None


@dataclass(frozen=True, kw_only=True)
class BoreFigures:
    """Contact on a bore, and how its diameter changes: directions are from rod +x, the length is along z."""

    max_pressure_MPa: float
    at_deg: float
    at_z_mm: float
    arc_deg: float
    ovality_mm: float
    widest_mm: float
    widest_deg: float
    narrowest_mm: float
    narrowest_deg: float


@dataclass(frozen=True, kw_only=True)
class SharpEdgeFigures:
    """A sharp re-entrant edge that matters: the elastic stress at it is infinite, what follows is not.

    Attributes
    ----------
    name
        A letter, the same in every load case.
    at_mm, between, opening_deg, length_mm
        Where its structural stress is largest, the faces that meet there, the angle of the notch outside the
        material, and the length of the edge.
    thickness_mm
        The measure t of the extrapolation, which reads the stress 0.4 t and 1.0 t beside the edge.
    structural_stress_MPa, structural_von_mises_MPa, error_percent
        Structural (hot-spot) stress across the edge, of all its components, and the error bar of the latter.
    safety_factor
        Against yielding, by the structural stress.
    notch_intensity, notch_exponent
        K, MPa·mm^(exponent), of the stress K/√(2π) r^(−exponent) across the bisector of the notch; None where
        the flanks are too short or the notch too narrow to tell.
    required_safety_factor, fillet_radius_mm
        What is asked (``--min-safety``, or 1), and the fillet radius whose peak would have it; None where no
        fillet up to `largest_fillet_mm` would.
    largest_fillet_mm
        Beyond it the relation between notch and fillet does not hold.
    """

    name: str
    at_mm: Vector
    between: tuple[str, str]
    opening_deg: float
    length_mm: float
    thickness_mm: float
    structural_stress_MPa: float
    structural_von_mises_MPa: float
    error_percent: float
    safety_factor: float
    notch_intensity: float | None
    notch_exponent: float
    required_safety_factor: float
    fillet_radius_mm: float | None
    largest_fillet_mm: float | None


@dataclass(frozen=True, kw_only=True)
class CaseFigures:
    """``results``: extremes of a load case away from singular places; None where they were not computed."""

    max_von_mises_MPa: float
    at_mm: Vector
    max_principal_MPa: float
    min_principal_MPa: float
    max_displacement_mm: float | None
    min_safety_factor: float
    error_percent: float | None
    energy_error_percent: WhereKnown[float] = None
    verdict: str | None
    unmasked_max_von_mises_MPa: WhereKnown[float] = None
    unmasked_min_safety_factor: WhereKnown[float] = None
    unmasked_verdict: WhereKnown[str] = None
    singular_max_von_mises_MPa: WhereKnown[float] = None
    singular_verdict: WhereKnown[str] = None
    sharp_edges: WhereKnown[tuple[SharpEdgeFigures, ...]] = None
    contact: WhereKnown[Mapping[str, BoreFigures]] = None


@dataclass(frozen=True, kw_only=True)
class PlaneFigures:
    """The column formulas for bending in one plane; the factor is None where nothing compresses the rod."""

    slenderness: float
    euler_N: float
    johnson_N: float
    rankine_N: float
    safety_factor: float | None


@dataclass(frozen=True, kw_only=True)
class ColumnFigures:
    """The rod as a column under the load case that compresses it most."""

    force_N: float
    case: str | None
    least_area_mm2: float
    planes: Mapping[str, PlaneFigures]

    @property
    def min_safety_factor(self) -> float | None:
        """The least factor of both planes."""
        factors = [plane.safety_factor for plane in self.planes.values() if plane.safety_factor is not None]
        return min(factors, default=None)


@dataclass(frozen=True, kw_only=True)
class BucklingModeFigures:
    """A buckling mode: factor on the load of its case, and which way the rod moves."""

    factor: float
    moves: str


@dataclass(frozen=True, kw_only=True)
class BucklingFigures:
    """``buckling``: column formulas always; with `--buckling` the modes of the solid, by load case."""

    column: ColumnFigures
    modes: WhereKnown[Mapping[str, tuple[BucklingModeFigures, ...]]] = None
    shapes_of: WhereKnown[str] = None
    min_safety_factor: float | None

    @property
    def min_mode_factor(self) -> float | None:
        """The least factor of all modes."""
        return min((mode.factor for found in (self.modes or {}).values() for mode in found), default=None)

    def of_case(self, case: str) -> tuple[float | None, float | None]:
        """Return the least factors of a load case: by the column formulas, and of the solid's modes."""
        column = self.column.min_safety_factor if self.column.case == case else None
        modes = (self.modes or {}).get(case, ())
        return column, min((mode.factor for mode in modes), default=None)


@dataclass(frozen=True, kw_only=True)
class SurvivalFigures:
    """``survival``: whether the rod survives, with the error bar taken off the safety factor.

    Attributes
    ----------
    answer
        ``survives``, ``fails`` or, where the error bar includes the required factor, ``undecided``.
    text
        In a line.
    required_safety_factor
        1, or ``--min-safety``.
    mode, case, place
        Of the governing factor: ``yielding``, ``fatigue`` or ``buckling``, of the rod or, by name, of its
        bolts, or slip or separation of the joint; the load case, None for the cycle;
        ``sharp edge A`` where the factor is that of the structural stress there.
    safety_factor, assured_safety_factor
        The governing factor, and what remains of it if the stress is higher by its error bar.
    """

    answer: str
    text: str
    required_safety_factor: float
    mode: str
    case: str | None
    place: WhereKnown[str] = None
    safety_factor: float
    assured_safety_factor: float


@dataclass(frozen=True, kw_only=True)
class PassFigures:
    """One mesh of a refinement.

    Attributes
    ----------
    elements, nodes
        Of the whole rod.
    error_percent
        The largest error bar of any load case.
    seconds
        Wall time of the pass.
    """

    elements: int
    nodes: int
    error_percent: float
    seconds: float

    def text(self, number: int) -> str:
        """Return a line for who waits."""
        return f"pass {number}: {self.elements} elements, ±{self.error_percent:.1f} %, {self.seconds:.1f} s"


# Relative difference below which safety factors are the same: the place that governs is far from the bores.
SAME_FACTOR = 0.01


@dataclass(frozen=True, kw_only=True)
class PinModelFigures:
    """``pin_model``: the smallest safety factor against yielding with other pressures on the bores.

    Attributes
    ----------
    min_safety_factors
        By the name of the pressure, the one that was asked for first; contact is among them only where the
        prescribed ones differ.
    """

    min_safety_factors: Mapping[str, float]

    @property
    def matters(self) -> bool:
        """Whether the pressures make a difference that is worth mentioning."""
        return self.spread > SAME_FACTOR

    @property
    def spread(self) -> float:
        """The largest relative difference from the factor of the pressure that was asked for."""
        asked, *others = self.min_safety_factors.values()
        return max(abs(other / asked - 1) for other in others)


@dataclass(frozen=True, kw_only=True)
class EnvironmentFigures:
    """``environment``."""

    versions: Mapping[str, str]
    platform: str
    threads: int | None


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What `summary.json` holds.

    Attributes
    ----------
    rpm, engine
        None where forces are given.
    loads, results
        By load case.
    passes
        Where the mesh was refined.
    assembly
        Of a rod of separate parts: bolts, joint and fits.
    envelope
        With the whole crank cycle.
    life
        Over the duty of the study, the same at each of its speeds; None if it has none, or no S–N line.
    critical_speeds_rpm
        Of several speeds: with their cycles the lowest speed from which each safety factor is below 1; of an
        assembled rod that from which its joint opens at the bore (``joint_opening``).
    pin_model
        Where the pins' pressure is prescribed: how far the answer depends on it.
    files
        The names of all files that the run wrote into its folder.
    shared_files
        Of several speeds, those beside the folders of the speeds.
    """

    schema: str = SCHEMA
    study: str
    rpm: float | None
    trusted: bool
    survival: SurvivalFigures
    rod: RodFigures
    engine: EngineFigures | None
    loads: Mapping[str, LoadFigures]
    model: ModelFigures
    results: Mapping[str, CaseFigures]
    passes: WhereKnown[tuple[PassFigures, ...]] = None
    assembly: WhereKnown[AssemblyFigures] = None
    envelope: WhereKnown[CycleFigures | EnvelopeFigures] = None
    life: WhereKnown[LifeFigures] = None
    buckling: BucklingFigures
    pin_model: WhereKnown[PinModelFigures] = None
    checks: Mapping[str, Check]
    notes: tuple[Note, ...]
    timings_s: dict[str, float]
    total_s: float
    peak_memory_MiB: float
    left_out: tuple[Note, ...]
    environment: EnvironmentFigures
    critical_speeds_rpm: WhereKnown[Mapping[str, float | None]] = None
    files: WhereKnown[tuple[str, ...]] = None
    shared_files: WhereKnown[tuple[str, ...]] = None

    @property
    def title(self) -> str:
        """The study and its speed."""
        return self.study if self.rpm is None else f"{self.study} at {self.rpm:g} rpm"

    @property
    def worst_case(self) -> str:
        """The load case with the smallest safety factor."""
        return min(self.results, key=lambda case: self.results[case].min_safety_factor)

    @property
    def min_safety_factor(self) -> float:
        """The smallest safety factor of the load cases."""
        return self.results[self.worst_case].min_safety_factor
