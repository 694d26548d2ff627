"""Virtual strain gauges: the strain along the surface of the rod, averaged over the length of a grid.

It is that of the recovered stress, ε = ((1 + ν) t·σ·t − ν tr σ)/E along t, at Gauss points of the grid, each
of which is put on the free surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.unit_solutions import UnitSolutions, spots
from fea.analysis.figures import GaugeCaseFigures, GaugeFigures
from fea.base.material import Material
from fea.judge.case_result import CaseResult
from fea.pins.model import Weights
from fea.solid.element import shape_functions
from fea.study.gauge_table import GaugeTable
from geometry.arrays import Floats, Ints, vector
from geometry.errors import require
from geometry.surfaces import Surface
from mesh.mirror import MirroredMesh
from mesh.tetmesh import TetMesh

FARTHEST = 5.0  # mm from the surface
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_ALONG = 0.1  # least part of a direction that must lie in the surface
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
    error: Floats  #: (n,) µm/m by an error of the von Mises stress there, per MPa

    @classmethod
    def of(cls, table: GaugeTable, name: str, mesh: TetMesh, materials: Sequence[Material]) -> "Gauge":
        """Put a gauge on the whole rod. Raises `InvalidValue`: far from the surface, or normal to it."""
        middle, normal, facet, _ = _foot(mesh, np.array(table.at_mm))
        away, at = float(np.linalg.norm(middle - table.at_mm)), np.round(middle, 2).tolist()
        rule = f"is {away:.3g} mm from the free surface of the rod, and at most {FARTHEST:g} mm are allowed"
        require(away <= FARTHEST, f"[[gauge]] {name}: at_mm", list(table.at_mm), rule, f"Near it is {at}.")
        along = _within(np.array(table.direction) / np.linalg.norm(table.direction), normal)
        rule = f"is normal to the surface, whose normal there is {np.round(normal, 3).tolist()}"
        given = list(table.direction)
        require(float(np.linalg.norm(along)) > _ALONG, f"[[gauge]] {name}: direction", given, rule)
        along /= np.linalg.norm(along)
        beside = int(np.isin(mesh.tets[:, :4], facet[:3]).sum(axis=1).argmax())
        part = 0 if mesh.part is None else int(mesh.part[beside])
        E, nu = materials[part].youngs_modulus, materials[part].poissons_ratio
        nodes, strains, shares = list[Ints](), list[Floats](), list[Floats]()
        for at, weight in zip(_POINTS * table.length_mm / 2, _WEIGHTS / 2, strict=True):
            _, normal, facet, shapes = _foot(mesh, middle + at * along)
            t = _within(along, normal)
            x, y, z = t / np.linalg.norm(t)
            dyad = np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z])
            nodes.append(facet)
            shares.append(weight * shapes)
            strains.append(np.outer(weight * shapes, (1 + nu) * dyad - nu * _TRACE))
        share = np.abs(np.concatenate(shares))
        strain, error = _MICRO / E * np.concatenate(strains), _MICRO / E * share / share.sum()
        return cls(table, name, middle, part, np.concatenate(nodes), strain, error)

    def figures(self, cases: Sequence[CaseResult], history: Floats | None) -> GaugeFigures:
        """Return the strain in load cases, with the error of the von Mises stress over E, and its history.

        Raises `InvalidValue`: more or fewer strains were measured than there are load cases.
        """
        names, given = [str(case.load.name) for case in cases], self.table.measured
        name, rule = f"[[gauge]] {self.name}: measured", f"must have a value for each of {', '.join(names)}"
        require(given is None or len(given) == len(names), name, list(given or ()), rule)
        measured: Sequence[float | None] = given or [None] * len(names)
        strains = {
            name: GaugeCaseFigures(
                strain_um_m=float((self.strain * case.stress[self.nodes]).sum()),
                error_um_m=float(self.error @ case.von_mises_error[self.nodes]),
                measured_um_m=strain,
            )
            for name, case, strain in zip(names, cases, measured, strict=True)
        }
        every = None if history is None else tuple(history.tolist())
        return GaugeFigures(name=self.name, at_mm=vector(self.place), cases=strains, history_um_m=every)

    def history(self, units: UnitSolutions, weights: Weights, whole: MirroredMesh) -> Floats:
        """Return the strain (n_instants,) over a cycle, µm/m, from the weights of its unit solutions."""
        places = [(int(node), self.part) for node in self.nodes]
        stress = np.stack([spot.stress for spot in spots(places, units, weights, whole)])
        return np.asarray(np.einsum("nc,nct->t", self.strain, stress))


def _within(direction: Floats, normal: Floats) -> Floats:
    return np.asarray(direction - (direction @ normal) * normal)


def _foot(mesh: TetMesh, place: Floats) -> tuple[Floats, Floats, Ints, Floats]:
    """Nearest place (3,) on the free surface, normal, nodes of its facet, and their shape functions."""
    facets = mesh.facets[Surface.FREE]
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
    return shape @ mesh.points[facet], normal / np.linalg.norm(normal), facet, shape
