"""Materials: linear elastic and isotropic, their strengths, and Marin's factors from specimens to a part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log10
from statistics import NormalDist

import numpy as np
import numpy.typing as npt

from fea.base.choices import Finish, Loading, Region
from geometry.errors import require, require_number, require_positive

MEDIAN = 50.0  # reliability in per cent


@dataclass(frozen=True)
class SurfaceFinish:
    """How a region of a part's surface was made."""

    factor: float = 1.0  #: k_a, the endurance limit over that of a polished surface
    finish: str = "polished"  #: in words
    assumed: bool = False  #: whether the study does not give it
    of_steel: bool = False  #: whether the factor is that of a steel of the same strength, and this is none


@dataclass(frozen=True)
class Marin:
    """Factors from the endurance limit of polished specimens to that of a part (Marin 1962)."""

    #: size, load: k_b and k_c, contained in the limits of `Material`
    size: float = 1.0
    load: float = 1.0
    #: The part of the rods that bear the limit; k_e is contained in the limits of `Material`, too
    reliability_percent: float = MEDIAN
    #: bores, faces, rest: k_a by region, not contained there
    bores: SurfaceFinish = SurfaceFinish()
    faces: SurfaceFinish = SurfaceFinish()
    rest: SurfaceFinish = SurfaceFinish()

    @property
    def reliability(self) -> float:
        """k_e."""
        return reliability_factor(self.reliability_percent)

    @property
    def surfaces(self) -> dict[Region, SurfaceFinish]:
        """How each region was made."""
        return {Region.BORES: self.bores, Region.FACES: self.faces, Region.REST: self.rest}


@dataclass(frozen=True)
class Basquin:
    """S–N line of polished specimens under fully reversed stress: σ_a = σ_f′ (2N)^b (Basquin 1910)."""

    coefficient: float  #: σ_f′, MPa
    exponent: float  #: b, negative

    def amplitude(self, cycles: float) -> float:
        """Stress amplitude, MPa, that breaks a specimen after N cycles."""
        return float(self.coefficient * (2 * cycles) ** self.exponent)

    def cycles(self, amplitude: float) -> float:
        """Cycles N that a specimen lasts at a stress amplitude, MPa."""
        return float((amplitude / self.coefficient) ** (1 / self.exponent) / 2)


@dataclass(frozen=True)
class CoffinManson:
    """Plastic strain of specimens, fully reversed: ε_p = ε_f′ (2N)^c (Coffin 1954, Manson 1953)."""

    coefficient: float  #: ε_f′
    exponent: float  #: c, negative


@dataclass(frozen=True)
class Material:
    """An isotropic linear elastic material."""

    youngs_modulus: float  #: E, MPa
    poissons_ratio: float  #: ν, −1 < ν < 0.5
    density: float  #: ρ, t/mm³
    yield_strength: float  #: S_y, MPa
    #: ultimate_strength, endurance_limit: S_u, and S_e, the endurance limit of the part under fully reversed
    #: tension, MPa, if known. S_e is that of a polished surface: `marin` has the factors of other finishes.
    ultimate_strength: float | None = None
    endurance_limit: float | None = None
    torsion_limit: float | None = None  #: likewise, under fully reversed torsion, MPa
    endurance_estimated: bool = False  #: whether S_e was estimated from S_u instead of tests
    endurance_cycles: float | None = None  #: for which S_e holds, of a metal without a true limit
    marin: Marin = Marin()  #: the factors between the limits of specimens and those of the part
    #: the S–N line of polished specimens, if known: none of the factors is contained in it
    basquin: Basquin | None = None
    coffin_manson: CoffinManson | None = None  #: its plastic strain over life, if known
    #: cyclic_yield, cyclic_estimated: 0.2 % yield strength in repeated loading, MPa, if known; whether it was
    #: estimated from S_u instead of tests
    cyclic_yield: float | None = None
    cyclic_estimated: bool = False
    #: Whether it lines a bore: where a bushing or a bearing shell yields it settles, which does not end a rod
    lining: bool = False
    support: bool = False  #: whether the gradient of stress raises the endurance limit at the surface
    hardness: float | None = None  #: HV of a steel, if known
    hardness_estimated: bool = False  #: whether it follows from S_u

    def __post_init__(self) -> None:
        require_positive("material.E_GPa", self.youngs_modulus / 1e3)
        nu = require_number("material.nu", self.poissons_ratio)
        require(-1 < nu < 0.5, "material.nu", nu, "must be above −1 and below 0.5")
        require_positive("material.density_kg_m3", self.density * 1e12)
        require_positive("material.yield_MPa", self.yield_strength)
        strengths = {
            "ultimate_MPa": self.ultimate_strength,
            "endurance_MPa": self.endurance_limit,
            "endurance_torsion_MPa": self.torsion_limit,
        }
        for name, value in strengths.items():
            if value is not None:
                require_positive(f"material.{name}", value)

    def of(self, elements: slice) -> "Material":  # noqa: ARG002 - as `Materials.of`
        """Return the material of some elements, which is this one for all."""
        return self

    def without_lambda(self) -> "Material":
        """Return the material with the same μ and λ = 0: its stress is 2 μ ε."""
        return replace(self, youngs_modulus=2 * self.shear_modulus, poissons_ratio=0.0)

    @property
    def flow_strength(self) -> float:
        """The smaller of yield and cyclic yield strength, MPa: that of metals which soften is the latter."""
        return min(self.yield_strength, self.cyclic_yield or self.yield_strength)

    @property
    def lame_lambda(self) -> float:
        """First Lamé constant λ, MPa."""
        E, nu = self.youngs_modulus, self.poissons_ratio
        return E * nu / ((1 + nu) * (1 - 2 * nu))

    @property
    def shear_modulus(self) -> float:
        """Shear modulus μ, MPa."""
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))


@dataclass(frozen=True)
class Constants:
    """Elastic constants of elements of several materials, each (n_elements,), MPa."""

    lame_lambda: npt.NDArray[np.float64]
    shear_modulus: npt.NDArray[np.float64]


@dataclass(frozen=True)
class Materials:
    """The materials of a mesh of several parts."""

    materials: tuple[Material, ...]  #: one per part
    part: npt.NDArray[np.int64]  #: (n_elements,) the part that each element belongs to

    def of(self, elements: slice) -> Constants:
        """Elastic constants of some elements."""
        part = self.part[elements]
        lame = np.array([material.lame_lambda for material in self.materials])
        shear = np.array([material.shear_modulus for material in self.materials])
        return Constants(lame[part], shear[part])

    @property
    def density(self) -> npt.NDArray[np.float64]:
        """Density (n_elements,) of each element, t/mm³."""
        return np.array([material.density for material in self.materials])[self.part]


def of_parts(materials: Sequence[Material], part: npt.NDArray[np.int64] | None) -> Material | Materials:
    """Return the materials by the part (n_elements,) of each element; without parts, the first material."""
    return materials[0] if part is None else Materials(tuple(materials), part)


# Marin's factors, S_e = k_a k_b k_c k_e S_e′, are those of Budynas & Nisbett, Shigley's Mechanical
# Engineering Design, 9th ed., sections 6-8 and 6-9; k_a of shot-peened forgings is that of the FKM guideline
# (Rennert et al., Analytical Strength Assessment of Components, 6th ed. 2012, section 4.3).
# k_a = a S_u^b, S_u in MPa: table 6-2, after Noll & Lipson (1946).
_FINISHES = {
    Finish.POLISHED: (1.0, 0.0),
    Finish.GROUND: (1.58, -0.085),
    Finish.MACHINED: (4.51, -0.265),
    Finish.HOT_ROLLED: (57.7, -0.718),
    Finish.AS_FORGED: (272.0, -0.995),
}
# FKM: K_R = 1 − a_R lg(R_z) lg(2 R_m / R_m,N,min) of steel, with R_z in µm of a rolled or forged skin, and
# K_V of shot peening, the lower end of its range both for smooth and for notched parts.
_ROUGHNESS_CONSTANT, _LEAST_STRENGTH, _SKIN_ROUGHNESS, PEENING = 0.22, 400.0, 200.0, 1.1
# k_c against rotating bending (equation 6-26).
_LOADS = {Loading.BENDING: 1.0, Loading.AXIAL: 0.85}
# Standard deviation of the endurance limit, relative to its mean (section 6-9, after Stulen, Cummings &
# Schulte 1961).
SCATTER = 0.08
# Of steels: S_e′ = S_u/2, at most 700 MPa (equation 6-8).
_STEEL_RATIO, _STEEL_LIMIT = 0.5, 700.0
_STEEL_MODULI = (185e3, 225e3)


def finish_factor(finish: Finish, ultimate: float) -> float:
    """k_a of a surface finish on a steel of ultimate strength in MPa (equation 6-19), at most 1.

    That of shot-peened forgings is K_R K_V of the FKM guideline, that of machined and peened surfaces K_V
    times the factor of machined ones; both may exceed 1.
    """
    if finish is Finish.MACHINED_PEENED:
        return PEENING * finish_factor(Finish.MACHINED, ultimate)
    if finish is Finish.SHOT_PEENED:
        return PEENING * roughness_factor(_SKIN_ROUGHNESS, ultimate)
    a, b = _FINISHES[finish]
    return float(min(1.0, a * ultimate**b))


def roughness_factor(roughness: float, ultimate: float) -> float:
    """K_R of a steel surface of mean roughness depth R_z in µm, ultimate strength in MPa; at most 1."""
    steeper = log10(max(2 * ultimate / _LEAST_STRENGTH, 1.0))
    return 1 - _ROUGHNESS_CONSTANT * log10(max(roughness, 1.0)) * steeper


def load_factor(loading: Loading) -> float:
    """k_c of a limit measured in rotating bending (equation 6-26); that in torsion is a limit of its own."""
    return _LOADS[loading]


def is_steel(youngs_modulus: float) -> bool:
    """Whether Young's modulus, MPa, is that of a steel."""
    low, high = _STEEL_MODULI
    return low <= youngs_modulus <= high


def size_factor(diameter: float) -> float:
    """k_b of a round section, mm, in bending (6-20); 1 axially (6-21). Raises `InvalidValue`: > 254 mm."""
    require_positive("material.size_mm", diameter)
    require(diameter <= 254, "material.size_mm", diameter, "must not exceed 254 mm, the largest size tested")
    if diameter <= 51:
        return float(min(1.0, (diameter / 7.62) ** -0.107))
    return float(1.51 * diameter**-0.157)


# FKM (ibid., section 4.3): a_G and b_G of steel, in MPa.
_SUPPORT, _SUPPORT_STRENGTH = 0.5, 2700.0


def support_factor(gradient: npt.NDArray[np.float64], ultimate: float) -> npt.NDArray[np.float64]:
    """n_σ (n,) of a steel of ultimate strength in MPa at relative gradients G (n,) of the amplitude, 1/mm.

    n = 1 + f(G) 10^−(a_G + S_u/b_G), with f = √10 G up to 0.1, √G up to 1 and the fourth root of G up to 100
    (FKM, 6th ed. 2012; the constants could not be checked against the guideline).
    """
    size = np.clip(gradient, 0.0, 100.0)
    shape = np.where(size <= 0.1, 10**0.5 * size, np.where(size <= 1, size**0.5, size**0.25))
    return np.asarray(1 + shape * 10 ** -(_SUPPORT + ultimate / _SUPPORT_STRENGTH))


def reliability_factor(percent: float) -> float:
    """k_e = 1 − 0.08 z (equation 6-29). Raises `InvalidValue`: per cent below 50, or 100 and above."""
    require(50 <= percent < 100, "material.reliability_percent", percent, "must be at least 50 and below 100")
    return 1 - SCATTER * NormalDist().inv_cdf(percent / 100)


def estimated_endurance(ultimate: float, youngs_modulus: float) -> float | None:
    """S_e′ of a steel from its ultimate strength, MPa; None for other metals, which may have no limit."""
    if not is_steel(youngs_modulus):
        return None
    return min(_STEEL_RATIO * ultimate, _STEEL_LIMIT)


# Vickers hardness and ultimate strength, MPa, of unalloyed and low-alloy steel: DIN 50150, now ISO 18265, as
# a supplier's table prints it (51tongren.cn).
_HARDNESS = (80.0, 100, 150, 200, 250, 300, 350, 400, 450, 470)
_STRENGTH = (250.0, 320, 480, 640, 800, 965, 1125, 1290, 1455, 1520)


def hardness_of(ultimate: float) -> float:
    """Vickers hardness of a low-alloy steel of ultimate strength in MPa: 80 to 470."""
    return float(np.interp(ultimate, _STRENGTH, _HARDNESS))


@dataclass(frozen=True)
class CrackMetal:
    """How cracks grow in a metal: da/dN = C ΔK^m, mm; stress intensities in MPa √m."""

    coefficient: float  #: C
    exponent: float  #: m
    threshold: float  #: ΔK of long cracks at R = 0 and, as the highest K, below
    toughness: float  #: K at which the rest breaks
    slope: float = 0.0  #: by which the threshold falls with R
    least: float = 0.0  #: threshold at any R
    assumed: tuple[str, ...] = ()  #: keys that a study does not give, with their values

    def threshold_at(self, ratio: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Threshold (n,) at stress ratios (n,)."""
        return np.asarray(np.maximum(self.threshold - self.slope * np.clip(ratio, 0, 1), self.least))


YIELD_STRAIN = 0.002  # plastic strain at the cyclic yield strength
_LIGHT = 5e-9  # t/mm³: aluminium and titanium are below, bronze is above
_BRITTLE = 0.1  # ψ below which the law of steels is not valid


def estimated_lines(material: Material) -> tuple[Basquin, CoffinManson] | None:
    """Estimate the lines of elastic and plastic strain over life; None where the law is not valid.

    The uniform material law (Bäumel & Seeger, Materials Data for Cyclic Loading, Supplement 1, 1990); the
    constants were read in programs that implement it, not in the book. Steel: σ_f′ = 1.5 S_u, b = −0.087,
    ε_f′ = 0.59 ψ, c = −0.58 with ψ = 1.375 − 125 S_u/E, at most 1. Aluminium and titanium: σ_f′ = 1.67 S_u,
    b = −0.095, ε_f′ = 0.35, c = −0.69.
    """
    ultimate = material.ultimate_strength
    if ultimate is None:
        return None
    if is_steel(material.youngs_modulus):
        ductile = min(1.375 - 125 * ultimate / material.youngs_modulus, 1.0)
        if ductile < _BRITTLE:
            return None
        return Basquin(1.5 * ultimate, -0.087), CoffinManson(0.59 * ductile, -0.58)
    if material.density < _LIGHT:
        return Basquin(1.67 * ultimate, -0.095), CoffinManson(0.35, -0.69)
    return None


def estimated_cyclic_yield(ultimate: float, youngs_modulus: float) -> float:
    """0.2 % yield strength K′ 0.002^n′, MPa, in repeated loading; of a metal of S_u and E in MPa.

    The uniform material law: K′ = 1.65 S_u, n′ = 0.15 of steel, K′ = 1.61 S_u, n′ = 0.11 of aluminium.
    """
    ratio, exponent = (1.65, 0.15) if is_steel(youngs_modulus) else (1.61, 0.11)
    return float(ratio * ultimate * YIELD_STRAIN**exponent)
