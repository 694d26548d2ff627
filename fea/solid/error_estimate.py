"""Estimate the error of a solution: in the energy norm, and in the stress at a node.

The exact stress is not known, but the recovered stress is closer to it than the stress of the elements, so
that the difference of the two estimates the error (Zienkiewicz & Zhu 1987, eqs. 13-16).

*Energy.* ‖e‖² = ∫ (σ* − σ_h) : C⁻¹ (σ* − σ_h) dV. If σ* is interpolated quadratically, the error of
second-order elements is underestimated (effectivity, estimated over true error, 0.6 on a smooth manufactured
solution, 0.9 to 1.2 on Lamé, Kirsch, Goodier and a rod); if it is interpolated linearly from the vertices, it
is overestimated (1.0, 1.4 to 2.5). With the mean of both, times `ENERGY_FACTOR`, the effectivity is 0.93 to
1.97 on all of them, and 0.93 to 1.24 on first-order elements. If singular edges cause most of the error, it
goes down to 0.75 on second-order elements (results/effectivity.md).

*Stress at a node.* Two differences indicate the error, both in the von Mises norm. The first is the root mean
square of σ* − σ_h over the elements of the node: the disagreement between the elements. The second is the
largest sagitta of σ* along an edge of the node, which is the value at the middle of the edge minus the mean
of the ends: it is large if the elements are too large for the gradient of the stress. At a single node both
may be small or large by chance, so q² is the mean of the sum of their squares over the elements around it.
With s the von Mises stress, n the pressure on the surface, c `STRESS_FACTOR` and p `STRESS_POWER`, the error
is c (s + n) (q / s)^p: second-order elements recover σ* better than σ_h, hence p > 1; less so where a pin
presses, whose pressure is linear on the facets, hence n. The constants are fitted: see
`fea.judge.case_error`. Inside the body, where σ* is the mean over the elements, the sagitta counts for more:
see `INSIDE_FACTOR`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.base.material import Material
from fea.solid.assembly import blocks, gauss_blocks, reference_nodes, shape_functions, tabulate
from fea.solid.boundary import facet_normals
from fea.solid.recovery import ElementStress, dyads, extrapolation
from fea.solid.stress import von_mises
from geometry.arrays import Floats, Ints
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import EDGES, TetMesh

# Elements per block, to limit memory.
_BLOCK = 4096
# Degree of the quadrature: the integrand is the squared difference of two linear fields; a higher degree
# changes the result by 1 %.
_DEGREE = 2
# How often each component occurs in the tensor.
_TWICE = np.array([1.0, 1, 1, 2, 2, 2])
# Weight of the quadratic interpolation of the recovered stress; the rest is linear.
_QUADRATIC = 0.5
# Constants of the error of the stress, by element order: with them the error bars of `fea.judge.case_error`
# contain 95 of 100 true errors of the random rods used to choose them (tests/benchmarks/error_bars.py);
# results/error-bars.md has the coverage on other rods.
STRESS_FACTOR, STRESS_POWER = {1: 1.4, 2: 0.93}, {1: 1.0, 2: 1.2}
# Inside the body the error is at least this times the sagitta. At an extreme all elements around it err to
# the same side, so that their disagreement does not show the error: the line through the Gauss points of a
# parabola is off at its ends by 2/3 of its sagitta (Barlow 1976), and curvature in two directions adds up to
# twice that. On a surface, quadratics are fitted instead.
INSIDE_FACTOR = 4 / 3
# Factor on the energy norm, to be on the safe side.
ENERGY_FACTOR = 1.2


@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated errors of the load cases."""

    energy: Floats  #: (n_elements, n_cases) square of the energy norm of the error, N·mm
    solution: Floats  #: (n_elements, n_cases) square of the energy norm of the solution, N·mm
    #: Per part (n_nodes, n_cases) error of the von Mises stress, MPa; NaN at nodes outside the part
    stress: tuple[Floats, ...]


class ErrorEstimator:
    """Estimates the errors of solutions on one mesh, with one material per part."""

    def __init__(self, mesh: TetMesh, materials: Sequence[Material]) -> None:
        n_nodes = mesh.tets.shape[1]
        table = tabulate(n_nodes, _DEGREE)
        self._mesh, self._materials = mesh, materials
        self._gauss_stress = ElementStress(mesh)
        self._volumes = np.concatenate([block.volumes for _, block in gauss_blocks(mesh, _DEGREE)])
        linear, _ = shape_functions(4, (table.values @ reference_nodes(n_nodes)).T)
        self._interpolation = _QUADRATIC * table.values
        self._interpolation[:, :4] += (1 - _QUADRATIC) * linear
        self._to_nodes = extrapolation(n_nodes)
        self._to_places = table.values @ self._to_nodes  # from the Gauss points to those of the quadrature
        self._inside, normal = np.ones((len(mesh.points), 1), dtype=bool), np.zeros_like(mesh.points)
        for surface, facets in mesh.facets.items():
            self._inside[facets] &= surface in PLANE_AXIS
            if surface not in (*PLANE_AXIS, Surface.FREE):
                normal[facets] = facet_normals(mesh.points, facets)
        self._across = dyads(normal, normal)

    def __call__(
        self, displacement: Floats, stresses: Sequence[Floats], pressure: Mapping[int, Floats] | None = None
    ) -> ErrorEstimate:
        """Compare each part's recovered stress (n_nodes, 6, n_cases) with that of its elements, MPa.

        The displacement is (n_nodes, 3, n_cases), mm; pressures of parts, by number, (n_nodes, n_cases), MPa.
        """
        n_elements, n_cases = len(self._mesh.tets), displacement.shape[2]
        energy, solution = np.zeros((2, n_elements, n_cases))
        errors = []
        for number, (stress, material) in enumerate(zip(stresses, self._materials, strict=True)):
            part = self._mesh.part
            of_part = np.arange(len(self._mesh.tets)) if part is None else np.flatnonzero(part == number)
            element_stress = self._gauss_stress(displacement, material, (pressure or {}).get(number))
            spread = np.empty((of_part.size, self._mesh.tets.shape[1], n_cases))
            for block in blocks(of_part.size, _BLOCK):
                elements = of_part[block]
                raw, nodal = element_stress[elements], stress[self._mesh.tets[elements]]
                inside = _along_places(self._to_places, raw)
                away = ENERGY_FACTOR * (_along_places(self._interpolation, nodal) - inside)
                energy[elements] = _energy(away, self._volumes[elements], material)
                solution[elements] = _energy(inside, self._volumes[elements], material)
                away = _along_places(self._to_nodes, raw) - nodal
                spread[block] = von_mises(np.moveaxis(away, 2, -1)) ** 2
            tets, n_nodes = self._mesh.tets[of_part], len(stress)
            bow = sagitta(tets, stress)
            square = (_nodal_mean(tets, spread, n_nodes) + bow**2)[tets].mean(axis=1, keepdims=True)
            q = np.sqrt(_nodal_mean(tets, np.broadcast_to(square, spread.shape), n_nodes))
            s = von_mises(np.moveaxis(stress, 1, -1))
            pressed = np.maximum(-np.einsum("nk,nkc->nc", self._across, stress), 0)
            size = np.maximum(s, q)
            share = np.divide(q, size, out=np.zeros_like(s), where=size > 0)
            error = STRESS_FACTOR[self._mesh.order] * share ** STRESS_POWER[self._mesh.order]
            error *= size + pressed
            errors.append(np.where(self._inside, np.maximum(error, INSIDE_FACTOR * bow), error))
        return ErrorEstimate(energy, solution, tuple(errors))


def _nodal_mean(tets: Ints, values: Floats, n_nodes: int) -> Floats:
    """Means (n_nodes, n_cases) of values (n_elements, n_local, n_cases) of elements; NaN without elements."""
    nodes = tets.ravel()
    columns = values.reshape(nodes.size, -1).T
    sums = np.stack([np.bincount(nodes, column, minlength=n_nodes) for column in columns], axis=1)
    with np.errstate(invalid="ignore"):
        return np.asarray(sums / np.bincount(nodes, minlength=n_nodes)[:, None])


def _along_places(matrix: Floats, values: Floats) -> Floats:
    """Values (n, n_to, 6, n_cases) of fields given at other places (n, n_from, 6, n_cases)."""
    n, n_from, *rest = values.shape
    return np.asarray((matrix @ values.reshape(n, n_from, -1)).reshape(n, len(matrix), *rest))


def _energy(stress: Floats, weights: Floats, material: Material) -> Floats:
    """Integrals (n, n_cases) of σ : C⁻¹ σ, stress at places (n, n_places, 6, n_cases)."""
    E, nu = material.youngs_modulus, material.poissons_ratio
    trace = stress[:, :, 0] + stress[:, :, 1] + stress[:, :, 2]
    square = np.einsum("epkc,epkc,k->epc", stress, stress, _TWICE)
    density = ((1 + nu) * square - nu * trace**2) / E
    return np.asarray(np.einsum("ep,epc->ec", weights, density))


def sagitta(tets: Ints, stress: Floats) -> Floats:
    """Deviation of the nodal stress from linear along the edges, in the von Mises norm: (n_nodes, n_cases).

    At each node the largest value over its edges; of first-order elements half the difference between the
    ends is used. The stress is (n_nodes, 6, n_cases).
    """
    ends = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    key, first = np.unique(ends[:, 0] * len(stress) + ends[:, 1], return_index=True)
    a, b = np.divmod(key, len(stress))
    nodes, away = [a, b], (stress[a] - stress[b]) / 2
    if tets.shape[1] == len(EDGES) + 4:
        middle = tets[:, 4:].ravel()[first]
        nodes, away = [a, b, middle], stress[middle] - (stress[a] + stress[b]) / 2
    bow = von_mises(np.moveaxis(away, 1, -1))
    largest = np.zeros((len(stress), stress.shape[2]))
    for places in nodes:
        np.maximum.at(largest, places, bow)
    return largest
