"""Estimated errors of the load cases on the whole rod."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.base.material import Material
from fea.rod.meshed_rod import MeshedRod
from fea.solid.error_estimate import ErrorEstimate, ErrorEstimator
from fea.solid.parity import Parity
from fea.solid.singular import BoundaryEdges, mask_radius, masked_nodes, rim_masks
from geometry.arrays import Floats, Mask
from geometry.surfaces import Surface


@dataclass(frozen=True)
class CaseError:
    """Estimated errors of the fields of one load case."""

    #: Per part (n_nodes,) error of the von Mises stress, MPa; NaN at nodes outside the part
    part_von_mises: tuple[Floats, ...]
    #: (n_elements,) energy norm of the error in each element over that of the solution in the whole rod, in
    #: percent: the root of the sum of squares is the error of the whole
    element_percent: Floats
    masked: Mask  #: (n_nodes,) near stress singularities, where the exact stress is infinite
    #: (n_nodes,) how far flat facets in place of a curved surface may move the stress, over it
    of_facets: Floats | float = 0.0

    @property
    def energy_percent(self) -> float:
        """Error of the whole rod in the energy norm, percent (Zienkiewicz & Zhu 1987, eq. 17)."""
        return float(np.sqrt((self.element_percent**2).sum()))


# Cause of singular stress away from the rims and the edges of bores.
SHARP_EDGE = "sharp inner edge"


class CaseErrors:
    """Estimates errors on the cell, for each side of y = 0, and maps them to the whole rod.

    `masked` are the nodes of the cell near stress singularities, where the exact stress is infinite; `rims`
    those of parts that touch, near which nodes are among them. `clamped` surfaces do not move freely.
    """

    def __init__(self, mesh: MeshedRod, materials: Sequence[Material], clamped: tuple[Surface, ...]) -> None:
        self._mesh = mesh
        self._estimator = ErrorEstimator(mesh.cell, materials)
        whole = mesh.mirrored
        creases = mesh.cell_creases
        edges = BoundaryEdges(mesh.cell)
        on_edges = edges.singular_nodes((), creases)
        places = edges.singular_nodes(clamped, creases) if clamped else on_edges
        self.rims = rim_masks(mesh.cell, mask_radius(mesh.cell))
        self.masked = masked_nodes(mesh.cell, places, self.rims)
        free = mesh.cell.facets.get(Surface.FREE, np.zeros((0, 3), dtype=np.int64))
        self._causes = {rim.name: rim.nodes for rim in self.rims} | {
            f"{surface.replace('_end_', '-end ')}'s edge": np.intersect1d(mesh.cell.facets[surface], free)
            for surface in clamped
        }
        self._causes[SHARP_EDGE] = on_edges
        self._masked = self.masked[whole.source]
        # Where creases are known, the mesh follows the curved surface of a solid.
        self._of_facets = edges.facet_share()[whole.source] if creases is None else 0.0
        beyond = whole.sign[:, 1] < 0
        self._node_side = beyond.astype(int)
        self._element_side = beyond[whole.mesh.tets].any(axis=1).astype(int)

    def __call__(
        self,
        displacement: Mapping[Parity, Floats],
        stresses: Mapping[Parity, Sequence[Floats]],
        pressure: Mapping[Parity, Mapping[int, Floats]],
    ) -> list[CaseError]:
        """Estimate the error of each case on the cell, per parity.

        The displacement is (n_nodes, 3, n_cases), mm; stresses are given per part, (n_nodes, 6, n_cases),
        MPa, as recovered; pressures by the number of each part that has one, (n_nodes, n_cases), MPa.
        """
        even, odd = Parity.SYMMETRIC, Parity.ANTISYMMETRIC
        soft = pressure.get(even, {})
        if odd not in displacement:
            return self._on_whole([self._estimator(displacement[even], stresses[even], soft)])
        return self._on_whole(
            [
                self._estimator(
                    displacement[even] + sign * displacement[odd],
                    [s + sign * a for s, a in zip(stresses[even], stresses[odd], strict=True)],
                    {number: p + sign * pressure[odd][number] for number, p in soft.items()},
                )
                for sign in (1, -1)  # the side y > 0, then the side y < 0 reflected
            ]
        )

    def singular_name(self, node: int) -> str:
        """Name the cause of singular stress that is nearest to a masked node of the cell."""
        distance = np.linalg.norm(self._mesh.cell.points - self._mesh.cell.points[node], axis=1)
        return min(self._causes, key=lambda name: distance[self._causes[name]].min(initial=np.inf))

    def _on_whole(self, sides: Sequence[ErrorEstimate]) -> list[CaseError]:
        whole = self._mesh.mirrored
        side = self._element_side if len(sides) > 1 else np.zeros_like(self._element_side)
        energy = np.stack([estimate.energy for estimate in sides])[side, whole.element_source]
        solution = np.stack([estimate.solution for estimate in sides])[side, whole.element_source]
        total = (energy + solution).sum(axis=0)
        share = 100 * np.sqrt(np.divide(energy, total, out=np.zeros_like(energy), where=total > 0))
        parts = [self._nodal(stress) for stress in zip(*(estimate.stress for estimate in sides), strict=True)]
        return [
            CaseError(tuple(part[:, case] for part in parts), share[:, case], self._masked, self._of_facets)
            for case in range(share.shape[1])
        ]

    def _nodal(self, sides: Sequence[Floats]) -> Floats:
        """Map nodal errors of both sides to the whole rod; on y = 0 the larger counts."""
        values = np.stack(sides)
        if len(values) == 1:
            return np.asarray(values[0][self._mesh.mirrored.source])
        on_plane = np.unique(self._mesh.cell.facets[Surface.SYMMETRY_Y])
        values[:, on_plane] = values[:, on_plane].max(axis=0)
        return np.asarray(values[self._node_side, self._mesh.mirrored.source])
