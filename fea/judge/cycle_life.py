"""How many crank cycles a place lasts at one speed: on its S–N line, or on one assumed from its strengths.

*Assumed line.* Under axial load, 0.75 S_u at 10³ cycles (Juvinall 1967, as Shigley's Mechanical Engineering
Design quotes it: 0.9 S_u holds for bending), and the endurance limit at 10⁶ cycles, or at those that it is
known for. What such an estimate may err by is no scatter between rods: half the ultimate strength of a steel
is its endurance limit within a standard deviation of 13.8 % (Mischke 1987).

*Unlimited life* is stated of steels whose ultimate strength is below 1250 MPa, at constant amplitude.
Elsewhere the line goes on below the knee (`fea.judge.fatigue.LifeLine`), and what is stated is that no
failure is expected by 10⁸ cycles.

*Below 10⁴ cycles* stress is not elastic: a notch yields in every cycle, and life follows from the local
strain (Coffin and Manson), at most 10⁴.

*Local stress.* Where flow is followed (`fea.plastic`), stress and strain are its own. Else they follow
from the elastic stress at a notch, where yielding stays local: σ ε = σ_e²/E (Neuber, J. Appl. Mech. 28, 1961,
544) and ε = σ/E + (σ/K′)^(1/n′), the cyclic curve with the constants of compatible lines: n′ = b/c,
K′ = σ_f′/ε_f′^n′. Where a whole section yields, strain is larger and life shorter.

*Life.* σ_max ε_a = σ_f′²/E (2N)^(2b) + σ_f′ ε_f′ (2N)^(b + c) (Smith, Watson & Topper, J. Materials 5, 1970,
767) with a tensile mean stress; a compressive one gives no benefit. The factors of surface and size make b
steeper, so that they hold at the knee and have no effect on the first reversal.

*Constants that are not known* are those of the uniform material law (`fea.base.material.estimated_lines`).
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from fea.base.choices import Fatigue
from fea.base.material import SCATTER, Basquin, CoffinManson, Material, estimated_lines
from fea.judge.fatigue import SHORT, LifeLine, criterion_strength, reversed_amplitude
from fea.judge.history import rainflow
from fea.judge.safety_factor import CycleLife
from geometry.arrays import Floats
from geometry.errors import InvalidValue

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


# Strength at 10³ cycles over the ultimate one, and cycles at the endurance limit of steels.
_AT_SHORT, _KNEE = 0.75, 1e6
# Standard deviation of an assumed endurance limit, and standard deviations of the band of a known line.
_ASSUMED, _BAND = 0.138, 2.0
LONGEST = 1e8  # cycles: beyond, only that no failure is expected by them is stated
LOW_CYCLE = 1e4  # cycles below which the stress of a notch is not elastic
# Standard deviations of the pressure of a single cycle that must do no damage where life is unlimited.
TAIL = 3.0
_PRESSURES = 5  # normal pressures of cycles that stand for all of them


def assumed_line(material: Material) -> Basquin | None:
    """Return the S–N line of specimens that strengths imply; None where they are not known or do not fit."""
    if material.ultimate_strength is None or material.endurance_limit is None:
        return None
    marin, knee = material.marin, material.endurance_cycles or _KNEE
    polished = material.endurance_limit / (marin.load * marin.reliability * marin.size)
    short = _AT_SHORT * material.ultimate_strength / marin.load
    if polished >= short:
        return None
    exponent = math.log(polished / short) / math.log(knee / SHORT)
    return Basquin(short / (2 * SHORT) ** exponent, exponent)


def life_line(material: Material, surface: Floats | float) -> LifeLine | None:
    """Return the line of places of surface factors k_a (n,), its own or an assumed one.

    None where neither is known, or where the assumed one does not fit. Raises `InvalidValue`: its own S–N
    line does not fit its endurance limit.
    """
    if material.basquin is not None:
        return LifeLine.of(material, surface)
    with suppress(InvalidValue):
        return LifeLine.of(replace(material, basquin=assumed_line(material)), surface)
    return None


def band_of(*, assumed: bool) -> float:
    """Return by which share strengths may be lower and higher: of an assumed S–N line, or of a known one."""
    return _ASSUMED if assumed else _BAND * SCATTER


def varied_pressure(scatter: float) -> list[tuple[float, float]]:
    """Return shares of cycles, and the relative change of their gas load, by its coefficient of variation.

    Normal by Gauss and Hermite; of share 0 are cycles of `TAIL` standard deviations, which any long life has.
    """
    if not scatter:
        return [(1.0, 0.0)]
    deviations, weights = np.polynomial.hermite_e.hermegauss(_PRESSURES)
    shares = [*(weights / weights.sum()).tolist(), 0.0, 0.0]
    factors = np.maximum(scatter * np.append(deviations, [-TAIL, TAIL]), -1.0)
    return list(zip(shares, factors.tolist(), strict=True))


def strength_share(material: Material, surface: Floats, cycles: float) -> Floats | None:
    """Amplitude (n,) that places of surface factors k_a bear for so many cycles, over the endurance limit.

    In place of k_a it gives the factors by which stress may grow until places last so long and no longer.
    None where no S–N line is known or can be assumed.
    """
    line = life_line(material, surface)
    return None if line is None else line.amplitude(cycles) / (material.endurance_limit or math.nan)


def cycle_life(
    history: Floats,
    material: Material,
    surface: float = 1.0,
    criterion: Fatigue = Fatigue.GOODMAN,
    varied: Sequence[tuple[float, Floats]] = (),
) -> CycleLife | None:
    """Return the life of a place of surface factor k_a under a periodic signed stress (n,), MPa.

    `varied`: where cycles differ, as in pressure, their shares and histories. One of share 0 does no damage,
    but where it exceeds the endurance limit, life is not unlimited. Of lives by strain, `history` counts.

    None where neither its S–N line nor the strengths for one are known, or where these do not fit. Raises
    `InvalidValue`: its own S–N line does not fit its endurance limit.
    """
    assumed, line = material.basquin is None, life_line(material, np.array([surface]))
    if line is None or criterion_strength(criterion, material) is None:
        return None
    mean, amplitude = rainflow(history)
    shares, histories = zip(*(varied or [(1.0, history)]), strict=True)
    counted = [reversed_amplitude(criterion, *rainflow(own), material) for own in histories]
    reversed_, rate = np.concatenate(counted)[:, None], np.repeat(shares, [len(own) for own in counted])
    strain, band = StrainLine.of(material, line.knee, surface), band_of(assumed=assumed)

    def cycles(strength: float) -> float:
        damage = float(line.stronger(strength).damage(reversed_, rate).sum())
        found = 1 / damage if damage else math.inf
        if strain is None or found >= LOW_CYCLE:
            return found
        return min(strain.cycles(mean / strength, amplitude / strength), LOW_CYCLE)

    median = cycles(1.0)
    by_strain = strain is not None and median <= LOW_CYCLE
    if by_strain and strain is not None:
        assumed = strain.assumed
    return CycleLife(median, cycles(1 - band), cycles(1 + band), 100 * band, assumed, line.endless, by_strain)
