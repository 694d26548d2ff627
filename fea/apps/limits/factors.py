"""Safety factors against every mode of failure at an operating point, from superposed unit solutions.

The cycles that are surveyed lie on a few rays from rest through speed squared and gas load; every row is
evaluated again where a limit is stated in words (see `fea.analysis.cycle.candidates`).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from fea.analysis.buckling import columns, compression
from fea.analysis.collapse import weaker_in_turns
from fea.analysis.cycle.candidates import Candidates, RowHistories
from fea.analysis.cycle.operation import gas_along_rod, gas_cases
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.life import COUNTED
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.scatter import scatter_of
from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.judge.cycle_life import cycle_life, life_line, varied_pressure
from fea.judge.fatigue import LifeLine, criterion_strength, reversed_amplitude
from fea.judge.history import rainflow, signed_equivalent
from fea.judge.safety_factor import CycleLife
from geometry.arrays import Floats
from loads.crank_cycle import CrankCycle
from loads.instants import Instants


class FailureMode(StrEnum):
    """A mode of failure."""

    YIELD = "yield"
    FATIGUE = "fatigue"
    BUCKLING = "buckling"
    COLLAPSE = "collapse"
    SET = "permanent set"
    BOLT_YIELD = "bolt yield"
    BOLT_FATIGUE = "bolt fatigue"
    OPENING = "joint opening"
    SLIP = "joint slip"
    BUSHING = "bushing lifting"
    SHELLS = "shell lifting"
    FILM = "oil film"
    LINING = "lining yield"


# Modes that do not end the rod, whose onset is reported: parts lift off their seats at an edge first,
# surfaces in contact wear, and a bushing or a shell that yields settles in its bore.
ONSETS = frozenset({FailureMode.BUSHING, FailureMode.SHELLS, FailureMode.FILM, FailureMode.LINING})
# Modes that the force along the shank decides, and modes that need not begin while all else is elastic.
BY_FORCE = (FailureMode.BUCKLING, FailureMode.COLLAPSE)
PLASTIC = (FailureMode.COLLAPSE, FailureMode.SET)
# Modes that stress decides, in the order of utilisations (3, n).
STRESSED = (FailureMode.YIELD, FailureMode.FATIGUE, FailureMode.LINING)


@dataclass(frozen=True)
class ModeFactor:
    """The least safety factor against one mode."""

    factor: float
    at: tuple[float, float, float] | None = None  #: mm; None where the mode has no place
    crank_angle: float | None = None  #: rad
    what: str = ""  #: exceeds its limit, of a permanent set


Factors = Mapping[FailureMode, ModeFactor]
#: Rows of parts with their stress, and the crank angles of the instants, rad
StressHistories = tuple[Sequence[RowHistories], Floats]

_TINY = 1e-12


class FatiguedPlace(NamedTuple):
    """A place near its endurance limit, with its stress over cycles of any pressure."""

    signed: Floats  #: (n_instants,) at the mean pressure, MPa
    material: Material
    surface: float  #: factor k_a
    line: LifeLine
    varied: Sequence[tuple[float, Floats]]  #: shares of cycles, and their signed stress

    def counted(self, criterion: Fatigue) -> tuple[Floats, Floats]:
        """Return fully reversed amplitudes (n_cycles,), MPa, and how many there are of each in a cycle."""
        amplitudes = [reversed_amplitude(criterion, *rainflow(own), self.material) for _, own in self.varied]
        shares = [share for share, _ in self.varied]
        return np.concatenate(amplitudes), np.repeat(shares, [len(own) for own in amplitudes])


class RodFactors(ABC):
    """The safety factors of a rod over any crank cycle."""

    costly: ClassVar[bool] = False  #: whether one evaluation takes as long as several static runs
    unsettled: int = 0  #: number of evaluations that are estimates, because friction did not settle

    def __init__(self, rod: PreparedRod) -> None:
        buckles = min(formulas.least for formulas in columns(rod).values())
        self._bears = dict(zip(BY_FORCE, (buckles, weaker_in_turns(rod).limit), strict=True))  # N
        self._criterion, self._materials = rod.options.fatigue, rod.materials
        self._scatter = scatter_of(rod.study.scatter, rod.engine, self._criterion).cycle_pressure

    @property
    def rest(self) -> Factors:
        """Factors under the preload of bolts and press fits alone."""
        return {}

    @abstractmethod
    def at(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle, with their places."""

    def survey(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle for a first map."""
        return self.estimate(cycle)

    def estimate(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle for a search."""
        return self.at(cycle)

    def certify(self, cycle: CrankCycle, factors: Factors) -> bool:  # noqa: ARG002
        """Check that no row is worse than `factors`; any that is becomes a candidate."""
        return True

    @abstractmethod
    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> StressHistories:
        """Return the stress of the most stressed rows at the decisive instants."""

    @cached_property
    def endurance(self) -> bool | None:
        """Whether stress below the endurance limit does no damage; None where no S–N line is known."""
        lines = [self._life_line(material, np.ones(1)) for material in self._materials]
        known = [line.endless for line in lines if line is not None]
        return all(known) if known else None

    @property
    def assumed(self) -> bool:
        """Whether an S–N line is assumed."""
        own = [each for each in self._materials if life_line(each, np.ones(1)) is not None]
        return any(material.basquin is None for material in own)

    def smooth_life(self, cycle: CrankCycle) -> float:
        """Return the crank cycles to failure as if every range did damage: an estimate for the map."""
        damage = _TINY
        for place in self._worst_places(cycle, estimated=True):
            line = replace(place.line, gentle=None) if place.line.endless else place.line
            amplitude, rate = place.counted(self._criterion)
            damage = max(damage, float(line.damage(amplitude[:, None], rate).sum()))
        return 1 / damage

    def life(self, cycle: CrankCycle) -> CycleLife | None:
        """Return the life of the place that fails first; None where no S–N line is known."""
        lives = [
            life
            for signed, material, surface, _, varied in self._worst_places(cycle)
            if (life := cycle_life(signed, material, surface, self._criterion, varied)) is not None
        ]
        if not lives:
            return None
        low, high = min(life.low for life in lives), min(life.high for life in lives)
        return replace(min(lives, key=lambda life: (life.cycles, life.low)), low=low, high=high)

    def tail(self, cycle: CrankCycle) -> float:
        """Return the largest amplitude of single cycles of any pressure over that at the mean pressure."""
        usual, largest = 0.0, 0.0
        for place in self._worst_places(cycle):
            amplitude, rate = place.counted(self._criterion)
            share = amplitude / place.line.limit
            usual = max(usual, float(share[rate == rate.max()].max()))
            largest = max(largest, float(share.max()))
        return largest / usual

    def _worst_places(self, cycle: CrankCycle, *, estimated: bool = False) -> Iterator[FatiguedPlace]:
        """Yield the places nearest to their endurance limit."""
        rows_of_parts, angles = self.histories(cycle, estimated=estimated)
        order, gas = np.argsort(angles), gas_cases(cycle) if self._scatter else None
        shares, factors = zip(*varied_pressure(0.0 if gas is None else self._scatter), strict=True)
        alone, course = [np.zeros((len(each.rows), 6, 2)) for each in rows_of_parts], np.zeros(len(angles))
        if gas is not None:
            alone, course = self.under(gas, rows_of_parts), gas_along_rod(cycle.at(angles)) / gas[0].gas
        for (part, rows, history), pressed in zip(rows_of_parts, alone, strict=True):
            surface = part.surface(rows)
            line = self._life_line(part.material, surface)
            if line is None:
                continue
            change = (pressed[..., :1] - pressed[..., 1:]) * course
            varied = [signed_equivalent(history + factor * change)[:, order] for factor in factors]
            usual = varied[int(np.argmax(shares))]
            high, low = usual.max(axis=1), usual.min(axis=1)
            largest = reversed_amplitude(self._criterion, (high + low) / 2, (high - low) / 2, part.material)
            for row in np.argsort(-largest / line.limit)[:COUNTED]:
                of_row = replace(line, limit=line.limit[[row]])
                every = [(share, signed[row]) for share, signed in zip(shares, varied, strict=True)]
                yield FatiguedPlace(usual[row], part.material, float(surface[row]), of_row, every)

    @abstractmethod
    def under(self, instants: Instants, rows_of_parts: Sequence[RowHistories]) -> list[Floats]:
        """Return the stress (n, 6, n_instants) of rows at instants that belong to no cycle."""

    def _life_line(self, material: Material, surface: Floats) -> LifeLine | None:
        """S–N line with surface factors; None where it or the effect of mean stress is not known."""
        known = criterion_strength(self._criterion, material) is not None
        return life_line(material, surface) if known else None

    def by_force(self, cycle: CrankCycle) -> dict[FailureMode, ModeFactor]:
        """Return the factors against buckling and collapse, which depend on the forces alone."""
        pushed = compression(cycle.degrees)
        worst = int(pushed.argmax())
        force, angle = max(float(pushed[worst]), _TINY), float(cycle.degrees.crank_angle[worst])
        return {mode: ModeFactor(most / force, None, angle) for mode, most in self._bears.items()}


class SuperposedFactors(RodFactors):
    """The safety factors of a rod of one piece."""

    def __init__(self, rod: PreparedRod, analysis: CycleAnalysis) -> None:
        super().__init__(rod)
        self._candidates, self._basis = Candidates(analysis), analysis.basis
        # Decisive crank angles of the last evaluation, rad: they often decide the next one.
        self._decisive = np.zeros(0)

    def survey(self, cycle: CrankCycle) -> Factors:
        """Evaluate every row, and remember it to choose candidates."""
        largest = self._candidates.survey(cycle)
        found = {mode: ModeFactor(1 / used) for mode, used in zip(STRESSED, largest, strict=True) if used > 0}
        return found | self.by_force(cycle)

    def certify(self, cycle: CrankCycle, factors: Factors) -> bool:
        """Check that no row is worse than `factors`; any that is becomes a candidate."""
        known = [1 / factors[mode].factor if mode in factors else np.nan for mode in STRESSED]
        return self._candidates.confirm(cycle, np.array(known))

    def at(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle, with their places."""
        return worst_of_histories(*self.histories(cycle)) | self.by_force(cycle)

    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> StressHistories:  # noqa: ARG002
        """Return the stress of the candidates that are worst: see `RodFactors.histories`."""
        found = self._candidates.histories(cycle, self._decisive)
        self._decisive = found.decisive
        return found.parts, found.angles

    def under(self, instants: Instants, rows_of_parts: Sequence[RowHistories]) -> list[Floats]:
        """Superpose instants: see `RodFactors.under`."""
        weights = self._basis.weights(instants)
        return [part.stress(weights, rows) for part, rows, _ in rows_of_parts]


def worst_of_histories(
    rows_of_parts: Sequence[RowHistories], angles: Floats
) -> dict[FailureMode, ModeFactor]:
    """Return the least factors among rows of parts with their histories (n, 6, n_instants)."""
    found = dict[FailureMode, ModeFactor]()
    for of_part in rows_of_parts:
        part, rows, history = of_part
        for mode, used in zip(STRESSED, of_part.utilisation, strict=True):
            row = int(used.argmax())
            factor = 1 / max(float(used[row]), _TINY)
            if used[row] > 0 and (mode not in found or factor < found[mode].factor):
                signed = signed_equivalent(history[row : row + 1])[0]
                x, y, z = part.points[rows[row]].tolist()
                found[mode] = ModeFactor(factor, (x, y, z), float(angles[np.abs(signed).argmax()]))
    return found
