"""Fatigue: safety factors of Goodman, Gerber, Soderberg and Crossland; the S–N line and Miner's sum.

n is the factor by which mean and amplitude may grow together until the line of the criterion is reached
(Budynas & Nisbett, Shigley's Mechanical Engineering Design, 9th ed., section 6-12). A compressive mean
stress gives no benefit: then n = S_e/σ_a.

Crossland (1956), for histories that need not be proportional: √J₂,a + α σ_H,max ≤ β, with the amplitude of
the deviatoric stress, which is the radius of the smallest ball that encloses its path, and the largest
hydrostatic stress. From the endurance limits f (fully reversed tension) and t (fully reversed torsion):
β = t, α = 3t/f − √3.

*S–N line.* Of Marin's factors, those of loading and reliability lower all of Basquin's line of specimens;
those of size and surface lower the endurance limit, at the knee, and not the strength at 10³ cycles, with a
straight line between them on logarithmic scales (Budynas & Nisbett, section 6-8). The knee is where the line
of specimens meets their endurance limit.

Steel whose cycles all stay below its endurance limit has unlimited life. Once larger cycles have damaged it,
the smaller ones damage it too: below the knee the line then falls with the slope 2k − 1 instead of k
(Haibach, LBF TM 50/70, 1970). Other metals have no endurance limit (Sonsino, Int. J. Fatigue 29, 2007, 2246):
for them that slope always holds. Nor have steels of 1250 MPa and more: their line falls by 5 % a decade below
the knee (ibid.) while nothing exceeds it.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.base.checks import MEANINGS, Check
from fea.base.choices import Fatigue, Finish
from fea.base.material import MEDIAN, Basquin, Material, is_steel
from fea.base.note import Note, assumptions, doubt, warning
from fea.base.units import with_power
from fea.judge.verdict import CAP
from geometry.arrays import Floats, Ints
from geometry.errors import require


def goodman(mean: Floats, amplitude: Floats, endurance: Floats | float, ultimate: float) -> Floats:
    """Return n of σ_a/S_e + σ_m/S_u = 1/n (modified Goodman; Soderberg with S_y in place of S_u)."""
    return _inverse(amplitude / endurance + np.maximum(mean, 0) / ultimate)


def gerber(mean: Floats, amplitude: Floats, endurance: Floats | float, ultimate: float) -> Floats:
    """Return n of n σ_a/S_e + (n σ_m/S_u)² = 1."""
    a, m = amplitude / endurance, np.maximum(mean, 0) / ultimate
    # The positive root, in the form without cancellation at zero mean stress.
    return _inverse((a + np.sqrt(a**2 + 4 * m**2)) / 2)


def fatigue_factor(
    criterion: Fatigue, mean: Floats, amplitude: Floats, material: Material, surface: Floats | float = 1.0
) -> Floats | None:
    """Safety factor against fatigue, at most `CAP`; None if the material's strengths are not known.

    Mean and amplitude of the signed equivalent stress, MPa, have one shape; so has the factor k_a of the
    surface on S_e, or it is one for all.
    """
    line = gerber if criterion is Fatigue.GERBER else goodman
    strength, endurance = criterion_strength(criterion, material), material.endurance_limit
    if strength is None or endurance is None:
        return None
    # In the precision of the stresses.
    return line(mean, amplitude, np.asarray(surface, amplitude.dtype) * endurance, strength)


def criterion_strength(criterion: Fatigue, material: Material) -> float | None:
    """Return the strength, MPa, that a mean stress is compared with; None if it is not known."""
    soderberg = criterion is Fatigue.SODERBERG
    return material.yield_strength if soderberg else material.ultimate_strength


def reversed_amplitude(criterion: Fatigue, mean: Floats, amplitude: Floats, material: Material) -> Floats:
    """Amplitude, MPa, of the fully reversed stress that does the same damage; strengths must be known.

    σ_ar of σ_a/σ_ar + σ_m/S = 1 (Goodman, Soderberg) or σ_a/σ_ar + (σ_m/S)² = 1 (Gerber). It exceeds S_e
    where the factor of `fatigue_factor` is below 1, and is infinite where σ_m ≥ S. A compressive mean stress
    gives no benefit.
    """
    share = np.maximum(mean, 0) / (criterion_strength(criterion, material) or np.nan)
    remaining = 1 - (share**2 if criterion is Fatigue.GERBER else share)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(remaining > 0, amplitude / remaining, np.inf))


def _inverse(used: Floats) -> Floats:
    return np.asarray(1 / np.maximum(used, 1 / CAP))


_NO_LIMIT = (
    "the metal has no endurance limit: a factor of 1 means {} cycles, {} revolutions of a "
    "{}-stroke engine, and less stress breaks it later (material.endurance_cycles)"
)


def fatigue_notes(materials: Sequence[Material], criterion: Fatigue, strokes: int = 4) -> tuple[Note, ...]:
    """Name the strengths needed by a criterion that were estimated or are missing."""
    needed = {"endurance_MPa": [material.endurance_limit for material in materials]}
    if criterion is not Fatigue.SODERBERG:  # which uses the yield strength
        needed["ultimate_MPa"] = [material.ultimate_strength for material in materials]
    notes = []
    if any(None in strengths for strengths in needed.values()):
        notes.append(warning(f"fatigue is not assessed for materials without {' or '.join(needed)}"))
    limited = dict.fromkeys(material.endurance_cycles or 0.0 for material in materials)
    words = "two" if strokes == 2 else "four"
    counts = [
        (with_power(f"{cycles:.3g}"), with_power(f"{cycles * strokes / 2:.3g}"))
        for cycles in limited
        if cycles
    ]
    said = [_NO_LIMIT.format(*count, words) for count in counts]
    notes += [warning(text, "fatigue") for text in said]
    return (*notes, *assumptions("fatigue", _assumed_strength(materials)))


def _assumed_strength(materials: Sequence[Material]) -> Iterator[str]:
    limited = [material for material in materials if material.endurance_limit is not None]
    estimated = [material for material in limited if material.endurance_estimated]
    if estimated:
        axial = any(material.marin.load < 1 for material in estimated)
        under = " in bending, and 0.85 of it under axial load" if axial else ""
        yield f"half the ultimate strength as endurance limit{under}"
    regions = [item for material in limited for item in material.marin.surfaces.items()]
    assumed = {(region, (skin.finish, skin.of_steel)): None for region, skin in regions if skin.assumed}
    for finish, of_steel in dict.fromkeys(made for _, made in assumed):
        where = " and ".join(region for region, made in assumed if made == (finish, of_steel))
        why = " (its factors are not known)" if finish == Finish.POLISHED else ""
        why = " (with the factor of a steel of the same strength)" if of_steel else why
        yield f"a {finish} surface of {where}{why}"
    if any(material.marin.reliability_percent == MEDIAN for material in limited):
        yield "the median strength (reliability 50 %)"


def check_notes(checks: Mapping[str, Check]) -> tuple[Note, ...]:
    """Explain what failed checks of the model's assumptions mean."""
    return tuple(doubt(why) for name, why in MEANINGS.items() if name in checks and not checks[name].passed)


# Relative: a radius is never too small, and at most this fraction too large.
TOLERANCE = 1e-3
# Few paths need more than ten; a radius that is not converged then is still an upper bound.
_MOST_CARRIERS = 40
_MOST_STEPS = 500
_TINY = 1e-300


def enclosing_balls(paths: Floats) -> tuple[Floats, Floats]:
    """Radius (n,) and centre (n, d) of the smallest enclosing ball of each path (n, d, n_points).

    The ball is determined by a few points of the path on its surface, the carriers. The point farthest from
    the centre of the carriers' ball is added to them (Bădoiu & Clarkson 2003) until it is not farther away
    than the carriers. The farthest distance is never below the true radius and the radius of the carriers'
    ball is never above it, so that both enclose it within `TOLERANCE`.
    """
    radius, centers = np.empty(len(paths)), np.empty(paths.shape[:2])
    open_ = np.arange(len(paths))
    squares = np.einsum("ndt,ndt->nt", paths, paths)
    carriers = _farthest(paths, squares, paths[:, :, 0], open_)[1][:, None]
    weights = np.ones((len(paths), 1))
    while len(open_):
        center, inner = _carried(carriers, weights)
        outer, point = _farthest(paths, squares, center, open_)
        radius[open_], centers[open_] = np.sqrt(np.maximum(outer, 0)), center
        more = (outer > inner * (1 + TOLERANCE) ** 2 + _TINY) & (carriers.shape[1] < _MOST_CARRIERS)
        open_ = open_[more]
        carriers = np.concatenate([carriers, point[:, None]], axis=1)[more]
        weights = np.pad(weights, ((0, 0), (0, 1)))[more]
    return radius, centers


def _farthest(paths: Floats, squares: Floats, center: Floats, rows: Ints) -> tuple[Floats, Floats]:
    """Square of the largest distance from centres (n, d) to the paths of some rows, and that point (n, d)."""
    if len(rows) < len(paths):
        paths, squares = paths[rows], squares[rows]
    distance = squares - 2 * (center[:, None] @ paths)[:, 0]
    which = distance.argmax(axis=1)
    point = paths[np.arange(len(paths)), :, which]
    return ((point - center) ** 2).sum(axis=1), point


def _carried(carriers: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Centre (n, d) and lower bound of the squared radius (n,) of the balls of carriers (n, m, d).

    The centre is the weighted mean with the weights that maximise the weighted mean square distance; for any
    weights this is at most the square of the radius (Yildirim 2008). `weights` (n, m) are the starting values
    and are improved in place, by steps of optimal length towards the farthest carrier or away from the
    nearest one with a positive weight.
    """
    rows = np.arange(len(carriers))
    center = (weights[:, None] @ carriers)[:, 0]
    for _ in range(_MOST_STEPS):
        square = ((carriers - center[:, None]) ** 2).sum(axis=2)
        mean = (weights * square).sum(axis=1)
        far, near = square.argmax(axis=1), np.where(weights > 0, square, np.inf).argmin(axis=1)
        above = square[rows, far] - mean
        below = mean - square[rows, near]
        if (above <= TOLERANCE / 4 * mean + _TINY).all():
            break
        out = above >= below
        chosen = np.where(out, far, near)
        # Along the line to a point at square distance s the mean square distance is a parabola with its
        # top at (s − mean)/2s; weights must not become negative.
        reach = square[rows, chosen]
        best = np.divide(reach - mean, 2 * reach, out=np.full_like(reach, -np.inf), where=reach > _TINY)
        weight = weights[rows, chosen]
        least = -np.divide(weight, 1 - weight, out=np.full_like(weight, np.inf), where=weight < 1)
        step = np.maximum(best, least)
        weights *= (1 - step)[:, None]
        weights[rows, chosen] = np.maximum(weights[rows, chosen] + step, 0)
        center += step[:, None] * (carriers[rows, chosen] - center)
    return center, mean


# t/f of 31 wrought steels: 0.60 ± 0.03, all within 0.52…0.69 (Forrest 1962, as table 6-14 of Budynas &
# Nisbett, Shigley's Mechanical Engineering Design, 9th ed.). Aluminium has 0.55 there and titanium 0.48, both
# below 1/√3, where the criterion is not valid.
TORSION_RATIO = 0.60


def crossland_factors(histories: Floats, material: Material, surface: Floats | float = 1.0) -> Floats | None:
    """Factor (n,) by which histories may grow until Crossland's criterion is met, at most `CAP`.

    It is never too large, and too small by at most `TOLERANCE`; None if the material's endurance limit is not
    known. Histories (n, 6, n_instants), MPa, are as `fea.judge.history.deviatoric` gives them; the factor k_a
    of the surface on f and t is (n,) or one for all. Raises `InvalidValue`: t/f is below 1/√3, where tensile
    mean stress would increase the factor.
    """
    if material.endurance_limit is None:
        return None
    radius, _ = enclosing_balls(histories[:, :5])
    return crossland_bound(radius, histories[:, 5].max(axis=1), material, surface)


def crossland_bound(
    radius: Floats, mean: Floats, material: Material, surface: Floats | float = 1.0
) -> Floats | None:
    """Return a lower bound of `crossland_factors` from upper bounds (n,) of radius and mean stress, MPa.

    The ball about the origin with the largest von Mises stress as radius encloses the path, and the mean
    stress is never above the largest principal stress. A place whose bound exceeds the factor of another
    place cannot be the worst.
    """
    tension, torsion = material.endurance_limit, material.torsion_limit
    if tension is None:
        return None
    torsion = TORSION_RATIO * tension if torsion is None else torsion
    ratio = torsion / tension
    valid = ratio >= 3**-0.5 * (1 - 1e-9)
    rule = "must be at least 0.577 times the endurance limit in tension for Crossland's criterion"
    require(valid, "material.endurance_torsion_MPa", torsion, rule, "Check both limits.")
    used = radius / 3**0.5 + (3 * ratio - 3**0.5) * mean
    limit = np.asarray(surface, radius.dtype) * torsion  # in the precision of the stresses
    return np.asarray(limit / np.maximum(used, limit / CAP))


# Where the factors of size and surface have no effect, and below which stress is not elastic.
SHORT = 1e3
# From which ultimate strength, MPa, a steel has no endurance limit, and the slope of 5 % a decade.
_HARD, _GENTLE = 1250.0, math.log(10) / -math.log(0.95)


@dataclass(frozen=True)
class LifeLine:
    """The S–N line of places of a part."""

    basquin: Basquin  #: of specimens, with the factors that lower all of it
    knee: float  #: cycles at the endurance limit
    limit: Floats  #: endurance limit of the places, MPa, (n,) or one for all
    #: Slope below the knee where nothing exceeds the limit: infinite without damage; None as after damage
    gentle: float | None

    @property
    def endless(self) -> bool:
        """Whether cycles below the limit alone do no damage."""
        return self.gentle == math.inf

    @classmethod
    def of(cls, material: Material, surface: Floats | float = 1.0) -> "LifeLine | None":
        """Return the line of a material at places of surface factors k_a (n,); None where it is not known.

        Raises `InvalidValue`: the endurance limit does not lie on the line beyond 10³ cycles, or surface and
        size raise it above the strength there.
        """
        specimen, limit, marin = material.basquin, material.endurance_limit, material.marin
        if specimen is None or limit is None:
            return None
        whole = marin.load * marin.reliability  # lowers all of the line
        polished = limit / (whole * marin.size)
        knee, most = specimen.cycles(polished), specimen.amplitude(SHORT)
        rule = f"must be below {most:.4g} MPa, which the S–N line gives at {SHORT:g} cycles"
        require(polished < most, "material.endurance_MPa", polished, rule, "Check the line and the limit.")
        limits = limit * np.asarray(surface, np.float64)
        best = float(limits.max(initial=0.0))
        rule = f"raises the endurance limit above the {most * whole:.4g} MPa borne for {SHORT:g} cycles"
        require(best < most * whole, "material.surface", best / limit, rule, "Give a smaller factor.")
        lowered = Basquin(specimen.coefficient * whole, specimen.exponent)
        gentle = _GENTLE if (material.ultimate_strength or 0.0) >= _HARD else math.inf
        return cls(lowered, knee, limits, gentle if is_steel(material.youngs_modulus) else None)

    def stronger(self, factor: float) -> "LifeLine":
        """Return the line of a part whose every strength is multiplied by a factor."""
        basquin = replace(self.basquin, coefficient=self.basquin.coefficient * factor)
        return replace(self, basquin=basquin, limit=self.limit * factor)

    def cycles(self, amplitude: Floats) -> Floats:
        """Cycles (…, n) to failure at fully reversed amplitudes, MPa, after damage; at least 1."""
        short = self.basquin.amplitude(SHORT)
        slope = np.log(self.knee / SHORT) / np.log(short / self.limit)
        with np.errstate(over="ignore", divide="ignore"):  # no stress: unlimited life
            exponent = np.where(amplitude > self.limit, slope, 2 * slope - 1)
            high_cycle = self.knee * (self.limit / amplitude) ** exponent
            low_cycle = SHORT * (amplitude / short) ** (1 / self.basquin.exponent)
        return np.asarray(np.maximum(np.where(amplitude > short, low_cycle, high_cycle), 1.0))

    def amplitude(self, cycles: float) -> Floats:
        """Fully reversed amplitude (n,), MPa, that places bear for so many cycles; from 10³ cycles on."""
        slope = np.log(self.knee / SHORT) / np.log(self.basquin.amplitude(SHORT) / self.limit)
        if cycles > self.knee:
            slope = 2 * slope - 1 if self.gentle is None else self.gentle
        return np.asarray(self.limit * (self.knee / max(cycles, SHORT)) ** (1 / slope))

    def damage(self, amplitude: Floats, rate: Floats) -> Floats:
        """Damage per hour (k, n) of cycles that a place sees together: its life is 1 over their sum.

        The amplitudes (k, n) are of fully reversed stress, MPa; the rate (k,) is in cycles per hour.
        """
        cycles = self.cycles(amplitude)
        if self.gentle is not None:
            with np.errstate(over="ignore", divide="ignore"):
                further = self.knee * (self.limit / amplitude) ** self.gentle
            alone = np.inf if self.endless else further
            cycles = np.where((amplitude > self.limit).any(axis=0), cycles, alone)
        return np.asarray(rate[:, None] / cycles)


def require_lines(materials: Iterable[Material]) -> None:
    """Refuse S–N lines that do not fit their material. Raises `InvalidValue` as `LifeLine.of`."""
    for material in materials:
        LifeLine.of(material, np.array([surface.factor for surface in material.marin.surfaces.values()]))


@dataclass(frozen=True)
class FatigueField:
    """Stress and strength at the places (n,) of a rod, MPa."""

    criterion: Fatigue
    mean: Floats
    amplitude: Floats
    endurance: Floats  #: of the part, with the factor of the surface
    strength: float  #: with which a mean stress is compared

    def factors(self, share: Floats | float = 1.0) -> Floats:
        """Safety factors (n,) with the endurance limit multiplied by a share, (n,) or one for all."""
        line = gerber if self.criterion is Fatigue.GERBER else goodman
        return line(self.mean, self.amplitude, np.asarray(share) * self.endurance, self.strength)

    def least(self, share: Floats | float = 1.0) -> float:
        """The smallest of them."""
        return float(self.factors(share).min())

    def needed(self, factor: float) -> float:
        """Multiple of the endurance limit with which every place has a safety factor; infinite: none has."""
        used = factor * np.maximum(self.mean, 0) / self.strength
        left = 1 - (used**2 if self.criterion is Fatigue.GERBER else used)
        with np.errstate(divide="ignore"):
            shares = np.where(left > 0, factor * self.amplitude / self.endurance / left, np.inf)
        return float(shares.max())
