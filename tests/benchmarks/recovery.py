"""Compare ways to recover nodal stress on bodies with exact solutions.

    python tests/benchmarks/recovery.py [--bodies lame goodier] [--seeds 3] [--order 1]

prints, per body, mesh size and candidate, in percent: the error of the largest stress (the peak a
user reads), its mean and worst error over the hot nodes, the worst and root-mean-square error of any
component over the inner surface (all of the exact peak), the error at the pole of the cavity or
hole, the root-mean-square error inside, Zienkiewicz & Zhu's effectivity (estimated over true error in
the energy norm) with the nodal stress interpolated by order and by vertices alone, and seconds.
Several seeds give the worst peak and the mean of the rest. The candidates work on the whole body, four
times the cell that `fea` works on; so compare their seconds with a quarter in mind.

The candidates that are not the product's live here only.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from exact_bodies import HEIGHT, INNER, MATERIAL, PLANES, PROBLEMS, Problem, solve, tetrahedralise

from fea.solid.assembly import (
    gauss_block,
    gauss_places,
    reference_nodes,
    shape_functions,
    stress_from_gradient,
    tabulate,
)
from fea.solid.boundary import facet_normals
from fea.solid.recovery import ElementStress, Recovery, extrapolation
from mesh.tetmesh import EDGES, TetMesh, reflect, unmirrored

SIZES = {
    "lame": (0.5, 0.33, 0.22, 0.15, 0.11),
    "lame-open": (0.5, 0.33, 0.22, 0.15),
    "kirsch": (0.5, 0.3, 0.2, 0.15),
    "goodier": (0.5, 0.35, 0.25, 0.18, 0.13),
}
PEAK = {
    "lame": 5 / 3,
    "lame-open": 5 / 3,
    "kirsch": 3.0,
    "goodier": (27 - 15 * MATERIAL.poissons_ratio) / (2 * (7 - 5 * MATERIAL.poissons_ratio)),
}
FULL = [[0, 3, 5], [3, 1, 4], [5, 4, 2]]


@dataclass(frozen=True)
class Sample:
    """A solved body: the cell that was meshed, and the whole body that it stands for."""

    problem: Problem
    cell: TetMesh
    cell_u: np.ndarray

    @cached_property
    def whole(self):
        """The cell reflected at its planes."""
        whole = unmirrored(self.cell)
        for plane in PLANES:
            whole = reflect(whole, plane)
        return whole

    @cached_property
    def cell_nodes(self) -> np.ndarray:
        """Node of the whole at the place of each node of the cell."""
        own = np.flatnonzero((self.whole.sign > 0).all(axis=1))
        return own[self.whole.source[own].argsort()]

    @property
    def mesh(self) -> TetMesh:
        return self.whole.mesh

    @cached_property
    def u(self) -> np.ndarray:
        return self.whole.vector(self.cell_u)

    @cached_property
    def gauss(self) -> np.ndarray:
        return ElementStress(self.mesh)(self.u, MATERIAL)[..., 0]

    @cached_property
    def vertices(self) -> np.ndarray:
        return np.unique(self.mesh.tets[:, :4])

    @cached_property
    def skin(self) -> np.ndarray:
        return np.unique(np.concatenate([facets.ravel() for facets in self.mesh.facets.values()]))


# -- candidates: Sample -> (n, 6) on the whole body --


def mean(sample: Sample, values: np.ndarray, weights: np.ndarray | float = 1.0) -> np.ndarray:
    """Mean at each node of the values (n_elements, n_nodes, 6) of its elements."""
    tets = sample.mesh.tets
    weights = np.broadcast_to(weights, tets.shape).ravel()
    shape = (len(sample.mesh.points), tets.size)
    sums = sparse.csr_array((weights, (tets.ravel(), np.arange(tets.size))), shape=shape)
    return (sums @ values.reshape(-1, 6)) / sums.sum(axis=1)[:, None]


def at_nodes(sample: Sample) -> np.ndarray:
    return ElementStress(sample.mesh, reference_nodes(sample.mesh.tets.shape[1]))(sample.u, MATERIAL)[..., 0]


def mean_at_nodes(sample: Sample) -> np.ndarray:
    return mean(sample, at_nodes(sample))


def mean_by_volume(sample: Sample) -> np.ndarray:
    corners = sample.mesh.points[sample.mesh.tets[:, :4]]
    volume = abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    return mean(sample, at_nodes(sample), volume[:, None])


def mean_of_gauss(sample: Sample) -> np.ndarray:
    return mean(sample, extrapolation(sample.mesh.tets.shape[1]) @ sample.gauss)


def sharpened(sample: Sample) -> np.ndarray:
    """The mean, corrected by what the same mean would lose of it (defect correction)."""
    n_nodes = sample.mesh.tets.shape[1]
    first, E = mean_of_gauss(sample), extrapolation(n_nodes)
    values, _ = shape_functions(n_nodes, gauss_places(n_nodes).T)
    return 2 * first - mean(sample, E @ (values @ first[sample.mesh.tets]))


def projected(sample: Sample) -> np.ndarray:
    """L2 projection to continuous P2 (or P1), consistent mass."""
    mesh, n = sample.mesh, len(sample.mesh.points)
    n_nodes = mesh.tets.shape[1]
    table = tabulate(n_nodes, 4)
    places = table.values @ reference_nodes(n_nodes)
    stress = ElementStress(mesh, places)(sample.u, MATERIAL)[..., 0]
    weight = gauss_block(mesh.points[mesh.tets], table).volumes
    local = np.einsum("eq,qa,qb->eab", weight, table.values, table.values)
    rows, columns = np.repeat(mesh.tets, n_nodes, 1).ravel(), np.tile(mesh.tets, (1, n_nodes)).ravel()
    mass = sparse.csr_array((local.ravel(), (rows, columns)), shape=(n, n))
    right = np.zeros((n, 6))
    np.add.at(right, mesh.tets, np.einsum("eq,qa,eqs->eas", weight, table.values, stress))
    scale = 1 / np.sqrt(mass.diagonal())
    scaled = sparse.diags_array(scale) @ mass @ sparse.diags_array(scale)
    return np.stack([scale * cg(scaled, scale * right[:, k], rtol=1e-10)[0] for k in range(6)], axis=1)


def monomials(x: np.ndarray, degree: int) -> np.ndarray:
    exponents = [
        (i, j, d - i - j) for d in range(degree + 1) for i in range(d, -1, -1) for j in range(d - i, -1, -1)
    ]
    return np.stack([x[:, 0] ** i * x[:, 1] ** j * x[:, 2] ** k for i, j, k in exponents], axis=1)


def slopes(x: np.ndarray, degree: int) -> np.ndarray:
    return np.stack([monomials(x + 1e-30j * np.eye(3)[k], degree).imag / 1e-30 for k in range(3)], axis=-1)


def patches(sample: Sample, *, two_rings_at_skin: bool) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Each vertex, the elements of its patch, and the nodes it serves (itself, mid-edge nodes next to it)."""
    tets, n = sample.mesh.tets, len(sample.mesh.points)
    corners = tets[:, :4]
    around = sparse.csr_array(
        (np.ones(corners.size), (corners.ravel(), np.repeat(np.arange(len(tets)), 4))), shape=(n, len(tets))
    )
    wide = sparse.csr_array(around @ around.T @ around) if two_rings_at_skin else around
    on_skin = np.isin(sample.vertices, sample.skin)
    for vertex, outside in zip(sample.vertices, on_skin, strict=True):
        source = wide if outside else around
        own = tets[around.indices[around.indptr[vertex] : around.indptr[vertex + 1]]]
        edges = EDGES[: own.shape[1] - 4]
        middle = [own[(own[:, a] == vertex) | (own[:, b] == vertex), 4 + k] for k, (a, b) in enumerate(edges)]
        served = np.unique(np.concatenate([[vertex], *middle]))
        yield vertex, source.indices[source.indptr[vertex] : source.indptr[vertex + 1]], served


def fitted(
    sample: Sample,
    degree: int,
    data: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    evaluate: Callable[[np.ndarray, np.ndarray, float], np.ndarray],
    *,
    two_rings_at_skin: bool,
) -> np.ndarray:
    """Fit polynomials to patches; nodes that no patch of full rank serves keep the mean."""
    total, count = np.zeros((len(sample.mesh.points), 6)), np.zeros(len(sample.mesh.points))
    for vertex, elements, served in patches(sample, two_rings_at_skin=two_rings_at_skin):
        places, values = data(elements)
        origin = sample.mesh.points[vertex]
        size = abs(places - origin).max()
        matrix = monomials((places - origin) / size, degree)
        if len(matrix) < matrix.shape[1]:
            continue
        left, singular, right = np.linalg.svd(matrix, full_matrices=False)
        if singular[-1] < 1e-6 * singular[0]:
            continue
        terms = right.T @ ((left.T @ values) / singular[:, None])
        total[served] += evaluate((sample.mesh.points[served] - origin) / size, terms, size)
        count[served] += 1
    with np.errstate(invalid="ignore"):
        return np.where(count[:, None] > 0, total / count[:, None], mean_of_gauss(sample))


def spr(degree: int, *, wide: bool) -> Callable[[Sample], np.ndarray]:
    """Superconvergent patch recovery (Zienkiewicz & Zhu 1992) from Gauss values."""

    def recovered(sample: Sample) -> np.ndarray:
        values, _ = shape_functions(10, gauss_places(10).T)
        places = values @ sample.mesh.points[sample.mesh.tets]
        return fitted(
            sample,
            degree,
            lambda elements: (places[elements].reshape(-1, 3), sample.gauss[elements].reshape(-1, 6)),
            lambda x, terms, _: monomials(x, degree) @ terms,
            two_rings_at_skin=wide,
        )

    return recovered


def ppr(sample: Sample) -> np.ndarray:
    """Polynomial-preserving recovery (Zhang & Naga 2005): cubic displacement, two rings at the skin."""

    def data(elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        nodes = np.unique(sample.mesh.tets[elements])
        return sample.mesh.points[nodes], sample.u[nodes, :, 0]

    def evaluate(x: np.ndarray, terms: np.ndarray, size: float) -> np.ndarray:
        return stress_from_gradient(np.einsum("nmj,mi->nij", slopes(x, 3), terms) / size, MATERIAL)

    return fitted(sample, 3, data, evaluate, two_rings_at_skin=True)


def with_traction(recovered: Callable[[Sample], np.ndarray]) -> Callable[[Sample], np.ndarray]:
    """Put the traction on the inner surface right, keeping the strain within the surface."""

    def corrected(sample: Sample) -> np.ndarray:
        mesh, nu, stress = sample.mesh, MATERIAL.poissons_ratio, recovered(sample)
        facets = mesh.facets[INNER]
        normal = np.zeros_like(mesh.points)
        np.add.at(normal, facets, facet_normals(mesh.points, facets))
        nodes = np.unique(facets)
        n = normal[nodes] / np.linalg.norm(normal[nodes], axis=1, keepdims=True)
        tensor = stress[nodes][:, FULL]
        miss = -sample.problem.pressure * n - np.einsum("nij,nj->ni", tensor, n)
        across = (miss * n).sum(axis=1)[:, None, None]
        dyad = n[:, :, None] * n[:, None, :]
        mixed = miss[:, :, None] * n[:, None, :]
        tensor += (
            mixed + mixed.transpose(0, 2, 1) - across * dyad + nu / (1 - nu) * across * (np.eye(3) - dyad)
        )
        stress[nodes] = tensor.reshape(-1, 9)[:, [0, 4, 8, 1, 5, 2]]
        return stress

    return corrected


def product(*, surfaces: bool) -> Callable[[Sample], np.ndarray]:
    """Recovery of `fea`, on the cell."""

    def recovered(sample: Sample) -> np.ndarray:
        known = sample.problem.known if surfaces else ()
        traction = sample.problem.traction(sample.cell) if surfaces else None
        return Recovery(sample.cell, PLANES, known).nodal_stress(sample.cell_u, MATERIAL, traction=traction)[
            ..., 0
        ]

    return recovered


CANDIDATES = {
    "mean at nodes": mean_at_nodes,
    "mean by volume": mean_by_volume,
    "mean of Gauss": mean_of_gauss,
    "mean of Gauss, traction": with_traction(mean_of_gauss),
    "mean, sharpened": sharpened,
    "L2 projection": projected,
    "SPR linear": spr(1, wide=False),
    "SPR linear, traction": with_traction(spr(1, wide=False)),
    "SPR quadratic": spr(2, wide=False),
    "SPR quadratic, 2 rings": spr(2, wide=True),
    "PPR cubic": ppr,
    "fea, no traction": product(surfaces=False),
    "fea": product(surfaces=True),
}
ON_P1 = ("mean of Gauss", "mean of Gauss, traction", "L2 projection", "fea")


# -- measures --


def hot_component(name: str, points: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Hoop stress of the cylinder under pressure, stress along the tension of the others."""
    if not name.startswith("lame"):
        return stress[:, 0]
    angle = np.arctan2(points[:, 1], points[:, 0])
    s, c = np.sin(angle), np.cos(angle)
    return stress[:, 0] * s**2 + stress[:, 1] * c**2 - 2 * stress[:, 3] * s * c


def measures(name: str, sample: Sample, stress: np.ndarray) -> dict[str, float]:
    points, peak = sample.cell.points, PEAK[name]
    exact = sample.problem.stress(points)
    error = stress - exact
    inner = np.unique(sample.cell.facets[INNER])
    if name in {"lame", "kirsch"}:  # away from the end that is only held flat
        inner = inner[points[inner, 2] < 0.6 * HEIGHT]
    surface = points[inner]
    hot = inner if name.startswith("lame") else inner[abs(surface[:, 0]) < 0.3]
    off = hot_component(name, points[hot], error[hot])
    inside = np.setdiff1d(
        np.arange(len(points)), np.unique(np.concatenate([f.ravel() for f in sample.cell.facets.values()]))
    )
    result = {
        "peak": hot_component(name, surface, stress[inner]).max() / peak - 1,
        "hot mean": off.mean() / peak,
        "hot worst": off[abs(off).argmax()] / peak,
        "worst": abs(error[inner]).max() / peak,
        "rms": np.sqrt((error[inner] ** 2).sum(axis=1).mean()) / peak,
        "pole": np.nan,
        "inside rms": np.sqrt((error[inside] ** 2).sum(axis=1).mean()) / peak if inside.size else np.nan,
    }
    if not name.startswith("lame"):
        pole = inner[np.linalg.norm(surface - [1, 0, 0], axis=1).argmin()]
        result["pole"] = error[pole, 1] / abs(exact[pole, 1])
    return result


def effectivities(sample: Sample, stress: np.ndarray) -> tuple[float, float]:
    """Estimated over true error in the energy norm, recovered stress interpolated by order and linearly."""
    mesh = sample.cell
    n_nodes = mesh.tets.shape[1]
    table = tabulate(n_nodes, 4)
    volumes = gauss_block(mesh.points[mesh.tets], table).volumes
    raw = ElementStress(mesh, table.values @ reference_nodes(n_nodes))(sample.cell_u, MATERIAL)[..., 0]
    places = table.values @ mesh.points[mesh.tets]
    exact = sample.problem.stress(places.reshape(-1, 3)).reshape(raw.shape)
    linear, _ = shape_functions(4, (table.values @ reference_nodes(n_nodes)).T)
    nodal = stress[mesh.tets]

    def norm(difference: np.ndarray) -> float:
        E, nu = MATERIAL.youngs_modulus, MATERIAL.poissons_ratio
        trace = difference[..., :3].sum(axis=-1)
        square = (difference[..., :3] ** 2).sum(axis=-1) + 2 * (difference[..., 3:] ** 2).sum(axis=-1)
        return float(np.sqrt((volumes * ((1 + nu) * square - nu * trace**2) / E).sum()))

    true = norm(exact - raw)
    return norm(table.values @ nodal - raw) / true, norm(linear @ nodal[:, :4] - raw) / true


COLUMNS = (
    *("body", "dofs", "candidate", "peak", "hot mean", "hot worst", "worst", "rms", "pole", "inside rms"),
    *("ZZ", "ZZ linear", "seconds"),
)


def rows(body: str, size: float, order: int, seeds: int, chosen: list[str]) -> Iterator[list[str]]:
    """Measure the candidates on one body and mesh size."""
    found: dict[str, list[list[float]]] = {candidate: [] for candidate in chosen}
    for seed in range(1, seeds + 1):
        cell = tetrahedralise(PROBLEMS[body], size, order=order, seed=seed)
        sample = Sample(PROBLEMS[body], cell, solve(PROBLEMS[body], cell))
        _ = sample.gauss  # shared by the candidates, worked out before the clock starts
        for candidate in chosen:
            start = time.perf_counter()
            stress = CANDIDATES[candidate](sample)
            seconds = time.perf_counter() - start
            if len(stress) == len(sample.mesh.points):
                stress = stress[sample.cell_nodes]
            zz = effectivities(sample, stress)
            found[candidate].append([*measures(body, sample, stress).values(), *zz, seconds])
    for candidate, numbers in found.items():
        table = np.array(numbers)
        mean_of_all = table.mean(axis=0)
        worst_peak = table[abs(table[:, 0]).argmax(), 0]
        percent = [f"{100 * value:+.2f}" for value in (worst_peak, *mean_of_all[1:7])]
        rest = [f"{value:.2f}" for value in mean_of_all[7:9]]
        yield [body, str(cell.points.size), candidate, *percent, *rest, f"{mean_of_all[9]:.3f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bodies", nargs="+", choices=list(SIZES), default=list(SIZES))
    parser.add_argument("--candidates", nargs="+", choices=list(CANDIDATES))
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--order", type=int, choices=(1, 2), default=2)
    asked = parser.parse_args()
    chosen = asked.candidates or list(CANDIDATES if asked.order == 2 else ON_P1)
    sys.stdout.write(f"| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}\n")
    for body in asked.bodies:
        for size in SIZES[body]:
            for row in rows(body, size, asked.order, asked.seeds, chosen):
                sys.stdout.write(f"| {' | '.join(row)} |\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
