"""Materials: linear elastic and isotropic, with their strengths."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fea.base.choices import Region
from geometry.errors import require, require_number, require_positive


@dataclass(frozen=True)
class SurfaceFinish:
    """How a region of a part's surface was made.

    Attributes
    ----------
    factor
        k_a, the endurance limit over that of a polished surface.
    finish
        In words.
    assumed
        Whether the finish follows from that of the rest of the part.
    """

    factor: float = 1.0
    finish: str = "polished"
    assumed: bool = False


@dataclass(frozen=True)
class Marin:
    """Factors from the endurance limit of polished specimens to that of a part (Marin 1962).

    Attributes
    ----------
    size, load, reliability
        k_b, k_c and k_e: they are contained in the limits of `Material`.
    bores, faces, rest
        k_a by region: it is not contained there.
    """

    size: float = 1.0
    load: float = 1.0
    reliability: float = 1.0
    bores: SurfaceFinish = SurfaceFinish()
    faces: SurfaceFinish = SurfaceFinish()
    rest: SurfaceFinish = SurfaceFinish()

    @property
    def surfaces(self) -> dict[Region, SurfaceFinish]:
        """How each region was made."""
        return {Region.BORES: self.bores, Region.FACES: self.faces, Region.REST: self.rest}


@dataclass(frozen=True)
class Basquin:
    """S–N line of polished specimens under fully reversed stress: σ_a = σ_f′ (2N)^b (Basquin 1910).

    Attributes
    ----------
    coefficient
        σ_f′, MPa.
    exponent
        b, negative.
    """

    coefficient: float
    exponent: float

    def amplitude(self, cycles: float) -> float:
        """Stress amplitude, MPa, that breaks a specimen after N cycles."""
        return float(self.coefficient * (2 * cycles) ** self.exponent)

    def cycles(self, amplitude: float) -> float:
        """Cycles N that a specimen lasts at a stress amplitude, MPa."""
        return float((amplitude / self.coefficient) ** (1 / self.exponent) / 2)


@dataclass(frozen=True)
class Material:
    """An isotropic linear elastic material.

    Attributes
    ----------
    youngs_modulus
        E, MPa.
    poissons_ratio
        ν, −1 < ν < 0.5.
    density
        ρ, t/mm³.
    yield_strength
        S_y, MPa.
    ultimate_strength, endurance_limit
        S_u, and S_e, the endurance limit of the part under fully reversed tension, MPa, if known. S_e is that
        of a polished surface: `marin` has the factors of other finishes.
    torsion_limit
        The endurance limit of the part under fully reversed torsion, MPa, if known, likewise.
    endurance_estimated
        Whether S_e was estimated from S_u instead of tests.
    marin
        The factors between the limits of specimens and those of the part.
    basquin
        The S–N line of polished specimens, if known: none of the factors is contained in it.
    """

    youngs_modulus: float
    poissons_ratio: float
    density: float
    yield_strength: float
    ultimate_strength: float | None = None
    endurance_limit: float | None = None
    torsion_limit: float | None = None
    endurance_estimated: bool = False
    marin: Marin = Marin()
    basquin: Basquin | None = None

    def __post_init__(self) -> None:
        """Refuse constants that no isotropic solid can have."""
        require_positive("material.E_GPa", self.youngs_modulus / 1e3)
        nu = require_number("material.nu", self.poissons_ratio)
        require(-1 < nu < 0.5, "material.nu", nu, "must be above −1 and below 0.5")
        require_positive("material.density_kg_m3", self.density * 1e12)
        require_positive("material.yield_MPa", self.yield_strength)
        known = {
            "ultimate_MPa": self.ultimate_strength,
            "endurance_MPa": self.endurance_limit,
            "endurance_torsion_MPa": self.torsion_limit,
        }
        for name, value in known.items():
            if value is not None:
                require_positive(f"material.{name}", value)

    def of(self, elements: slice) -> "Material":  # noqa: ARG002 - as `Materials.of`
        """Return the material of some elements, which is this one for all."""
        return self

    def without_lambda(self) -> "Material":
        """Return the material with the same μ and λ = 0: its stress is 2 μ ε."""
        return replace(self, youngs_modulus=2 * self.shear_modulus, poissons_ratio=0.0)

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
    """The materials of a mesh of several parts.

    Attributes
    ----------
    materials
        One per part.
    part
        (n_elements,) the part that each element belongs to.
    """

    materials: tuple[Material, ...]
    part: npt.NDArray[np.int64]

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
