"""Virtual strain gauges: the strain along the surface of the rod, averaged over the length of a grid.

It is that of the recovered stress, ε = ((1 + ν) t·σ·t − ν tr σ)/E along t, at Gauss points of the grid, each
of which is put on the free surface.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.summary_figures import GaugeCaseFigures, GaugeFigures
from fea.base.material import Material
from fea.judge.case_result import CaseResult
from fea.pins.model import Weights
from fea.solid.assembly import shape_functions
from fea.study.option_tables import GaugeTable
from geometry.arrays import Floats, Ints, vector
from geometry.errors import require
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants, joined
from mesh.tetmesh import TetMesh

FARTHEST, _ALONG = 5.0, 0.1  # mm from the surface; least part of a direction that must lie in it
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_MICRO, _TRACE = 1e6, np.array([1.0, 1, 1, 0, 0, 0])
# Facets that are looked at, those of the nearest middles; places (2, n) on each.
_NEAR, _PLACES = 100, np.array([(u, v) for u in range(9) for v in range(9 - u)]).T / 8


@dataclass(frozen=True)
class Gauge:
    """A strain gauge on a mesh: its strain is linear in the stress at some nodes of one part."""

    table: GaugeTable
    name: str
    place: Floats  #: (3,) on the surface, mm
    part: int
    nodes: Ints  #: (n,) of the whole rod
    strain: Floats  #: (n, 6) µm/m by each component of stress there, per MPa
    error: Floats  #: (n,) µm/m by an error of the von Mises stress there, per MPa: over E

    @classmethod
    def of(cls, table: GaugeTable, name: str, mesh: TetMesh, materials: Sequence[Material]) -> "Gauge":
        """Put a gauge on the whole rod. Raises `InvalidValue`: far from the surface, or normal to it."""
        middle, plane, facet, _ = foot(mesh, np.array(table.at_mm))
        away, at = float(np.linalg.norm(middle - table.at_mm)), np.round(middle, 2).tolist()
        rule = f"is {away:.3g} mm from the free surface of the rod, and at most {FARTHEST:g} mm are allowed"
        require(away <= FARTHEST, f"[[gauge]] {name}: at_mm", list(table.at_mm), rule, f"Near it is {at}.")
        along, given = plane @ table.direction / np.linalg.norm(table.direction), list(table.direction)
        length, where = float(np.linalg.norm(along)), f"[[gauge]] {name}: direction"
        require(length > _ALONG, where, given, f"is normal to the surface at {at}", "Give one along it.")
        along /= length
        beside = int(np.isin(mesh.tets[:, :4], facet[:3]).sum(axis=1).argmax())
        part = 0 if mesh.part is None else int(mesh.part[beside])
        E, nu = materials[part].youngs_modulus, materials[part].poissons_ratio
        parts = list[tuple[Ints, Floats, Floats]]()
        for at, weight in zip(_POINTS * table.length_mm / 2, _WEIGHTS / 2, strict=True):
            _, plane, facet, shapes = foot(mesh, middle + at * along)
            x, y, z = plane @ along / np.linalg.norm(plane @ along)
            dyad = np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z])
            parts.append(
                (facet, shapes, np.outer(weight * shapes, (1 + nu) * dyad - nu * _TRACE) * _MICRO / E)
            )
        nodes, share, strain = map(np.concatenate, zip(*parts, strict=True))
        return cls(table, name, middle, part, nodes, strain, np.abs(share) / np.abs(share).sum() * _MICRO / E)

    def figures(self, cases: Sequence[CaseResult], history: Floats | None) -> GaugeFigures:
        """Return the strain in load cases; `InvalidValue`: not as many were measured as there are cases."""
        strains = {
            str(case.load.name): GaugeCaseFigures(
                strain_um_m=float((self.strain * case.stress[self.nodes]).sum()),
                error_um_m=float(self.error @ case.von_mises_error[self.nodes]),
            )
            for case in cases
        }
        return self._beside_measured(strains, history)

    def superposed(
        self, analysis: CycleAnalysis, cases: Sequence[Instants], cycle: CrankCycle
    ) -> GaugeFigures:
        """Return the same from unit solutions alone, without the error of the mesh."""
        strains = self.history(analysis, analysis.basis.weights(joined(cases)))
        found = {
            str(case.name): GaugeCaseFigures(strain_um_m=strain, error_um_m=None)
            for case, strain in zip(cases, strains.tolist(), strict=True)
        }
        every = self.history(analysis, analysis.basis.weights(cycle.degrees, cycle))
        return self._beside_measured(found, every)

    def _beside_measured(
        self, strains: Mapping[str, GaugeCaseFigures], history: Floats | None
    ) -> GaugeFigures:
        given = self.table.measured
        name, rule = f"[[gauge]] {self.name}: measured", f"must have a value for each of {', '.join(strains)}"
        require(given is None or len(given) == len(strains), name, list(given or ()), rule)
        measured: Sequence[float | None] = given or [None] * len(strains)
        cases = {
            case: replace(found, measured_um_m=strain)
            for (case, found), strain in zip(strains.items(), measured, strict=True)
        }
        every = None if history is None else tuple(history.tolist())
        return GaugeFigures(name=self.name, at_mm=vector(self.place), cases=cases, history_um_m=every)

    def history(self, analysis: CycleAnalysis, weights: Weights) -> Floats:
        """Return the strain (n_instants,) over a cycle, µm/m, from the weights of its unit solutions."""
        places = ((int(node), self.part) for node in self.nodes)
        found = spots(places, analysis.units, weights, analysis.mesh.mirrored)
        return np.asarray(np.einsum("nc,nct->t", self.strain, np.stack([spot.stress for spot in found])))


def foot(mesh: TetMesh, place: Floats, facets: Ints | None = None) -> tuple[Floats, Floats, Ints, Floats]:
    """Nearest place (3,) on facets (default: free ones), projector, nodes of its facet, their shapes."""
    facets = mesh.facets[Surface.FREE] if facets is None else facets
    away = np.linalg.norm(mesh.points[facets[:, :3]].mean(axis=1) - place, axis=1)
    near = facets[np.argsort(away)[:_NEAR]]
    shapes, slopes = shape_functions(facets.shape[1], _PLACES)
    apart = place - np.einsum("kn,fnx->fkx", shapes, mesh.points[near])
    number, at = np.unravel_index(np.linalg.norm(apart, axis=2).argmin(), apart.shape[:2])
    facet = near[number]
    tangents = slopes[at].T @ mesh.points[facet]
    # From the nearest of some places on along both tangents, within the facet.
    local = _PLACES[:, at] + np.linalg.lstsq(tangents.T, apart[number, at])[0]
    local = np.maximum(local, 0) / max(np.maximum(local, 0).sum(), 1)
    ((shape,), _), normal = shape_functions(facets.shape[1], local[:, None]), np.cross(*tangents)
    plane = np.eye(3) - np.outer(normal, normal) / (normal @ normal)
    return shape @ mesh.points[facet], plane, facet, shape
