"""The figures of `summary.json`, units in names; None is ``null``, or left out where `WhereKnown`."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from enum import Enum
from math import isnan
from typing import Annotated, Any, ClassVar, TypeVar, dataclass_transform, get_args

from fea.base.units import DEG, KG, KG_M2, N_M, UM
from fea.judge.safety_factor import SafetyFactor, without_bar
from geometry.arrays import Vector

SCHEMA = "fea/summary/1"

Known = TypeVar("Known")
ONLY_WHERE_KNOWN = "only where known"
_ROUNDING = 1e-9
WhereKnown = Annotated[Known | None, ONLY_WHERE_KNOWN]

# Units at the end of a name, longer ones first, in the units of the program.
_UNITS = {
    "_kg_m2": KG_M2, "_deg": DEG, "_kg": KG, "_um": UM, "_Nm": N_M, "_mm": 1.0, "_mm2": 1.0,
    "_mm4": 1.0, "_MPa": 1.0, "_N": 1.0,
}  # fmt: skip


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Figures:
    """Figures for JSON: every subclass is a frozen dataclass, whose fields are given by name.

    Safety factors that are given as plain numbers have no error bar. Forces, stresses and lengths below
    10⁻⁹ N, MPa or mm are what rounding leaves of nothing, and become 0.
    """

    factor_names: ClassVar[tuple[str, ...]] = ()  #: names of the fields that are safety factors
    rounded_names: ClassVar[tuple[str, ...]] = ()  #: names of forces, stresses and lengths

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)
        every = fields(cls)  # type: ignore[arg-type]
        cls.factor_names = tuple(field.name for field in every if _is_factor(field.type))
        cls.rounded_names = tuple(field.name for field in every if field.name.endswith(("_N", "_MPa", "_mm")))

    def __post_init__(self) -> None:
        for name in self.factor_names:
            object.__setattr__(self, name, without_bar(getattr(self, name)))
        for name in self.rounded_names:
            if isinstance(value := getattr(self, name), float) and abs(value) < _ROUNDING:
                object.__setattr__(self, name, 0.0)


def _is_factor(hint: Any) -> bool:
    return hint is SafetyFactor or any(_is_factor(part) for part in get_args(hint))


Kind = TypeVar("Kind", bound=Figures)


def figures(kind: type[Kind], source: object, **given: Any) -> Kind:
    """Fill fields from the attributes of `source`, but for those that are given or have a default.

    The units are those of the names: ``length_mm`` is `length`, ``opening_deg`` is `opening`, rad, and
    ``open_percent`` is `open_share`.
    """
    required = [field.name for field in fields(kind) if field.default is MISSING]  # type: ignore[arg-type]
    return kind(**{name: _read(source, name) for name in required if name not in given}, **given)


def _read(source: object, name: str) -> Any:
    if hasattr(source, name):
        return plain(getattr(source, name))
    if name.endswith("_percent"):
        return 100 * plain(getattr(source, f"{name.removesuffix('_percent')}_share"))
    suffix, unit = next(item for item in _UNITS.items() if name.endswith(item[0]))
    value = plain(getattr(source, name.removesuffix(suffix)))
    return value if value is None or unit == 1 else value / unit


def plain(value: Any) -> Any:
    """Return a value in Python's own types; None for a number that does not apply (NaN)."""
    if isinstance(value, Enum):
        return value.value
    if hasattr(value, "tolist"):  # arrays and scalars of NumPy
        value = value.tolist()
    if isinstance(value, float) and isnan(value):
        return None
    return tuple(map(plain, value)) if isinstance(value, list | tuple) else value


class RodFigures(Figures):
    """``rod``: mass properties of the meshed rod; the inertia is I_z about the centre of gravity."""

    mass_kg: float
    center_of_gravity_mm: Vector
    inertia_kg_m2: float
    length_mm: float


class EngineFigures(Figures):
    """``engine``."""

    crank_radius_mm: float
    rod_length_mm: float
    bore_mm: float
    piston_mass_kg: float
    strokes: int = 4


class LoadFigures(Figures):
    """``loads``: what acts in a load case; None where it does not apply, as a crank angle to given forces."""

    crank_deg: float | None
    gas_N: float | None
    pin_axial_N: float
    pin_transverse_N: float
    crank_axial_N: float
    crank_transverse_N: float
    wall_N: float | None
    torque_Nm: float | None


class QualityFigures(Figures):
    """Quality of the elements, and what was done about bad ones."""

    least_scaled_jacobian: float
    least_shape: float
    median_shape: float
    worst_at_mm: Vector
    straightened_elements: int
    repairs: tuple[str, ...]
    repaired_size_mm: float | None


class ModelFigures(Figures):
    """``model``: nodes, elements and dofs of the whole rod as written; `solved_dofs` were factorised."""

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
    mesh_from_file: WhereKnown[bool] = None  #: such a mesh cannot be refined


class OvalityFigures(Figures):
    """The shape of a bore beside the round one that was made: directions are from rod +x."""

    ovality_mm: float
    widest_mm: float
    widest_deg: float
    narrowest_mm: float
    narrowest_deg: float


class BoreFigures(OvalityFigures):
    """Contact on a bore, and how its diameter changes."""

    max_pressure_MPa: float
    at_deg: float  #: where it is largest
    at_z_mm: float
    arc_deg: float  #: on which it presses; the length is along z


class SharpEdgeFigures(Figures):
    """A sharp re-entrant edge that matters: the elastic stress at it is infinite, what follows is not."""

    name: str  #: a letter, the same in every load case
    at_mm: Vector  #: where its structural stress is largest
    between: tuple[str, str]  #: the faces that meet there
    opening_deg: float  #: of the notch, outside the material
    length_mm: float
    thickness_mm: float  #: t of the extrapolation, which reads the stress 0.4 t and 1.0 t beside the edge
    structural_stress_MPa: float  #: hot-spot stress across the edge
    structural_von_mises_MPa: float  #: of all its components
    error_percent: float  #: error bar of the latter
    safety_factor: SafetyFactor  #: against yielding, by the structural stress
    #: K, MPa·mm^(exponent), of the stress K/√(2π) r^(−exponent) across the bisector of the notch; None where
    #: the flanks are too short or the notch too narrow
    notch_intensity: float | None
    notch_exponent: float
    required_safety_factor: float  #: ``--min-safety``, or 1
    fillet_radius_mm: float | None  #: whose peak has that factor; None where no fillet up to the largest has
    largest_fillet_mm: float | None  #: beyond it the relation between notch and fillet does not hold


class WeakestFigures(Figures):
    """Where the smallest safety factor is: in words, its part, and the yield strength there."""

    at_mm: Vector
    where: str
    part: str
    yield_MPa: float


class LiningFigures(Figures):
    """The lining of a bore in a load case: where it yields it settles, which does not end the rod."""

    safety_factor: SafetyFactor  #: against yielding
    specific_load_MPa: float  #: force of the pin over diameter times width of its bore


class CaseFigures(Figures):
    """``results``: extremes of a load case away from singular places; None where they were not computed."""

    max_von_mises_MPa: float
    at_mm: Vector
    max_principal_MPa: float
    min_principal_MPa: float
    max_displacement_mm: float | None
    min_safety_factor: SafetyFactor
    weakest: WhereKnown[WeakestFigures] = None
    error_percent: float | None
    energy_error_percent: WhereKnown[float] = None
    verdict: str | None
    unmasked_max_von_mises_MPa: WhereKnown[float] = None
    unmasked_min_safety_factor: WhereKnown[SafetyFactor] = None
    unmasked_verdict: WhereKnown[str] = None
    singular_max_von_mises_MPa: WhereKnown[float] = None
    singular_verdict: WhereKnown[str] = None
    singular_where: WhereKnown[str] = None  #: the place of the largest stress among those, in words
    sharp_edges: WhereKnown[tuple[SharpEdgeFigures, ...]] = None
    contact: WhereKnown[Mapping[str, BoreFigures]] = None
    linings: WhereKnown[Mapping[str, LiningFigures]] = None  #: bushing and shells, by part
