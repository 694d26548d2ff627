"""Lives below 10⁴ cycles, where a notch yields in every cycle: from the local strain, by Coffin and Manson.

*Local stress.* Where flow is followed (`fea.plastic`), stress and strain are its own. Else they follow
from the elastic stress at a notch, where yielding stays local: σ ε = σ_e²/E (Neuber, J. Appl. Mech. 28, 1961,
544) and ε = σ/E + (σ/K′)^(1/n′), the cyclic curve with the constants of compatible lines: n′ = b/c,
K′ = σ_f′/ε_f′^n′. Where a whole section yields, strain is larger and life shorter.

*Life.* σ_max ε_a = σ_f′²/E (2N)^(2b) + σ_f′ ε_f′ (2N)^(b + c) (Smith, Watson & Topper, J. Materials 5, 1970,
767) with a tensile mean stress; a compressive one gives no benefit. The factors of surface and size make b
steeper, so that they hold at the knee and have no effect on the first reversal.

*Constants that are not known* are those of the uniform material law (`fea.base.uniform_law`).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from fea.base.material import Basquin, CoffinManson, Material
from fea.base.uniform_law import estimated_lines
from geometry.arrays import Floats

_LONGEST = 1e12  # reversals


@dataclass(frozen=True)
class StrainLine:
    """Strain over life at a place of a part, and the cyclic curve of its material."""

    modulus: float  #: E, MPa
    #: elastic, plastic: shares of the strain amplitude; the elastic one with the factors of the place
    elastic: Basquin
    plastic: CoffinManson
    hardening: float  #: n′
    assumed: bool  #: whether a constant is
    whole: float  #: factor on all strengths: reliability, and loading where the S–N line is known

    @classmethod
    def of(cls, material: Material, knee: float, surface: float = 1.0) -> "StrainLine | None":
        """Return the line of a place of surface factor k_a; None where no constants are known or estimated.

        `knee`: cycles at the endurance limit, where k_a and the factor of size hold.
        """
        marin, (estimated, ductile) = material.marin, estimated_lines(material) or (None, None)
        elastic, plastic = material.basquin or estimated, material.coffin_manson or ductile
        if elastic is None or plastic is None:
            return None
        exponent = elastic.exponent + math.log(surface * marin.size) / math.log(2 * knee)
        assumed = material.basquin is None or material.coffin_manson is None
        whole = marin.reliability * (1.0 if material.basquin is None else marin.load)
        hardening = elastic.exponent / plastic.exponent
        return cls(
            material.youngs_modulus, replace(elastic, exponent=exponent), plastic, hardening, assumed, whole
        )

    def local(self, elastic_stress: float) -> tuple[float, float]:
        """Return stress, MPa, and strain of the cyclic curve by Neuber's rule."""
        strength = float(self.elastic.coefficient / self.plastic.coefficient**self.hardening)  # K′

        def beyond(stress: float) -> float:
            plastic = float((stress / strength) ** (1 / self.hardening))
            return stress**2 + self.modulus * stress * plastic - elastic_stress**2

        stress = float(brentq(beyond, 0.0, elastic_stress))
        return stress, elastic_stress**2 / (self.modulus * stress)

    def cycles(self, mean: Floats, amplitude: Floats) -> float:
        """Periods until Palmgren and Miner's sum of cycles of elastic stress (n,), MPa, is 1; at least ½."""
        pairs = zip((np.maximum(mean, 0) + amplitude).tolist(), amplitude.tolist(), strict=True)
        damage = sum(1 / self._of(high / self.whole, half / self.whole) for high, half in pairs if half > 0)
        return 1 / damage if damage else math.inf

    def _of(self, highest: float, amplitude: float) -> float:
        """Cycles of one size, by their largest elastic stress and its amplitude, MPa."""
        (most, _), (_, strain) = self.local(highest), self.local(amplitude)
        return self._until(most * strain)

    def of_strain(self, highest: float, amplitude: float) -> float:
        """Return the cycles of one size by a largest stress, MPa, and a strain amplitude that are known."""
        return self._until(highest * amplitude / self.whole**2)

    def _until(self, product: float) -> float:
        """Cycles of one size, by the product of largest stress, MPa, and strain amplitude; at least ½."""
        b, c = self.elastic.exponent, self.plastic.exponent

        def above(log_reversals: float) -> float:
            elastic = self.elastic.coefficient**2 / self.modulus * math.exp(2 * b * log_reversals)
            plastic = self.elastic.coefficient * self.plastic.coefficient * math.exp((b + c) * log_reversals)
            return math.log((elastic + plastic) / product)

        longest = math.log(_LONGEST)
        if above(0.0) <= 0:
            return 0.5
        return math.inf if above(longest) >= 0 else math.exp(float(brentq(above, 0.0, longest))) / 2
