"""Designs of a rod that a search tries: the mesh of one, moved to the next."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from fea.analysis.adapt import Adapted, adapt_mesh
from fea.analysis.prepare import prepare
from fea.apps.optimise.limits import Limit, limits, required
from fea.apps.optimise.variables import Variables
from fea.base.choices import CONVERGED_PERCENT
from fea.base.units import KG
from fea.machine.clock import Clock
from fea.rod.discretise import moved
from fea.rod.meshed_rod import MeshedRod
from geometry.arrays import Floats
from geometry.errors import GeometryError
from mesh.tetmesh import MeshError

# Of the way from a rod that can be meshed to one that cannot, after which a search goes less far.
_SHORTER = 0.5
_TRIES = 3
# Meshes that others are moved from.
_KEPT = 8


@dataclass(frozen=True)
class Design:
    """A rod that was tried."""

    x: Floats  #: (n,) its free dimensions, scaled to 0 … 1 between their bounds
    mass_kg: float
    limits: tuple[Limit, ...]
    #: scaled distance from the rod that was asked for, which cannot be drawn, to this one; 0 where it can
    infeasibility: float = 0.0
    remeshed: bool = False  #: whether its mesh was made for it, rather than moved from another rod's
    mesh: int = 0  #: number of the mesh that was made for it or that its own was moved from

    @property
    def margin(self) -> float:
        """The least margin of all limits."""
        return min(limit.margin for limit in self.limits)

    @property
    def governing(self) -> Limit:
        """The limit with the least margin."""
        return min(self.limits, key=lambda limit: limit.margin)


class Designs:
    """Computes designs: `tried` holds all, in order; `count` is the number of meshes that were solved.

    The listener is called with each design and the count. With `morphing`, the mesh of one rod is moved to
    the next, where it can be.
    """

    def __init__(
        self,
        variables: Variables,
        listener: Callable[[Design, int], None] = lambda _design, _count: None,
        *,
        morphing: bool = True,
    ) -> None:
        self.variables = variables
        self.tried: list[Design] = []
        self.count = 0
        self._listener, self._morphing = listener, morphing
        self._required = required(variables.study)
        self._made: deque[tuple[Floats, MeshedRod, int]] = deque(maxlen=_KEPT)
        self._meshes = 0
        self._feasible = variables.start
        self._coarsest = CONVERGED_PERCENT

    def begin(self, x: Floats) -> Design:
        """Compute a design on a mesh of its own, refined as its study asks for; others follow from that mesh.

        The first mesh, with which the search covers most of the way, need only be converged.

        Raises
        ------
        GeometryError, MeshError
            The rod cannot be drawn or meshed.
        """
        if self._made:
            self._coarsest = 0.0
        self._made.clear()
        self._feasible = x
        adapted, mesh = self._meshed(x)
        return self._computed(adapted, x, x, mesh=mesh, remeshed=True)

    def at(self, x: Floats) -> Design:
        """Compute a design on the mesh of another, moved; of a rod that cannot be drawn, the nearest one.

        Raises
        ------
        GeometryError, MeshError
            Not even rods much closer to the last one begun can be drawn or meshed.
        """
        near = self.variables.nearest_feasible(x, self._feasible)
        for tries in count(1):
            try:
                adapted, mesh, remeshed = self._rod(near)
            except (GeometryError, MeshError):
                if tries == _TRIES:
                    raise
                near = near + _SHORTER * (self._feasible - near)
            else:
                return self._computed(adapted, near, x, mesh=mesh, remeshed=remeshed)
        raise AssertionError  # the loop has no end

    def nearest(self, x: Floats, sound: Floats) -> Floats:
        """Return the last design (n,) that can be drawn on the way to `x` from another that can."""
        return self.variables.nearest_feasible(x, sound)

    def _rod(self, x: Floats) -> tuple[Adapted, int, bool]:
        """The rod on the mesh of the nearest one meshed, moved; where that cannot follow, on its own.

        Also the number of the mesh, and whether it is the rod's own.
        """
        if self._morphing:
            study = self.variables.study_at(x)
            _, base, number = min(self._made, key=lambda made: float(np.linalg.norm(made[0] - x)))
            mesh = moved(base, study.rod)
            if mesh is not None:
                return Adapted(prepare(study, mesh=mesh)), number, False
        return *self._meshed(x), True

    def _meshed(self, x: Floats) -> tuple[Adapted, int]:
        """The rod on a mesh of its own, to which others may be moved, and the number of the mesh."""
        study = self.variables.study_at(x)
        tolerance = study.tolerance_percent
        if tolerance is not None:
            tolerance = max(tolerance, self._coarsest)
            study = replace(study, analysis=replace(study.analysis, tolerance_percent=tolerance))
        adapted = adapt_mesh(study, study.speeds(), Clock(), movable=self._morphing)
        self._meshes += 1
        self._made.append((x, adapted.rod.mesh, self._meshes))
        self.count += max(1, len(adapted.passes)) - 1  # the last one counts with its design
        return adapted, self._meshes

    def _computed(self, adapted: Adapted, x: Floats, asked: Floats, *, mesh: int, remeshed: bool) -> Design:
        results = [adapted.at(rpm) for rpm in self.variables.study.speeds()]
        margins = limits(adapted.rod, results, self._required)
        infeasibility = float(np.linalg.norm(asked - x))
        design = Design(x, adapted.rod.mass.mass / KG, margins, infeasibility, remeshed, mesh)
        self.tried.append(replace(design, infeasibility=0.0))
        self.count += 1
        self._listener(design, self.count)
        return design
