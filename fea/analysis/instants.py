"""Fields of the whole rod at instants of the crank cycle, worked out as they are asked for."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.analysis.prepare import PreparedRod
from fea.base.units import DEG
from fea.judge.verdict import safety_factor
from fea.pins.model import Weights
from fea.stress.stress import principal, von_mises
from geometry.arrays import Floats

# Instants computed together: each takes some 200 bytes per node of the whole rod.
_BLOCK = 8
_CYCLE = 720.0


@dataclass(frozen=True)
class InstantFields:
    """The rod at every so many degrees of a cycle."""

    rod: PreparedRod  #: with its unit solutions
    rpm: float  #: engine speed
    step: float  #: degrees from one instant to the next

    @property
    def degrees(self) -> list[float]:
        """The crank angles: the last is before the cycle begins anew."""
        return [self.step * k for k in range(int(np.ceil(_CYCLE / self.step - 1e-9)))]

    def fields(self) -> Iterator[dict[str, npt.NDArray[Any]]]:
        """Yield the nodal arrays of each instant, named as in a load case, in single precision.

        Displacement is solved for, stress is superposed; where parts meet, it is that of the part that is
        closer to yielding.
        """
        angles = np.array(self.degrees) * DEG
        weights = self.rod.cycle.weights(self.rod.crank_cycle(self.rpm), angles)
        for start in range(0, len(angles), _BLOCK):
            block = slice(start, start + _BLOCK)
            moved = self.rod.displacement(self.rpm, angles[block])
            stress, factor = self._stress(weights.at(block))
            for k in range(moved.shape[-1]):
                yield _arrays(moved[..., k], stress[..., k], factor[..., k])

    def _stress(self, weights: Weights) -> tuple[Floats, Floats]:
        """Stress (n_nodes, 6, n_instants) and safety factor (n_nodes, n_instants)."""
        units, whole = self.rod.cycle.units, self.rod.mesh.mirrored
        count = weights.even.shape[1]
        stress = np.full((len(whole.source), 6, count), np.nan)
        factor = np.full((len(whole.source), count), np.inf)
        for number, material in enumerate(self.rod.materials):
            own = units.tensor(number, weights, whole)
            its = safety_factor(von_mises(np.moveaxis(own, 1, -1)), material.yield_strength)
            worse = its < factor
            stress = np.where(worse[:, None], own, stress)
            factor = np.where(worse, its, factor)
        return stress, factor


def _arrays(moved: Floats, stress: Floats, factor: Floats) -> dict[str, npt.NDArray[Any]]:
    principals = principal(stress)
    found = {
        "displacement": moved,
        "stress": stress,
        "von_mises": von_mises(stress),
        **{f"principal_{k + 1}": principals[:, k] for k in range(3)},
        "safety_factor": factor,
    }
    return {name: np.ascontiguousarray(values, np.float32) for name, values in found.items()}
