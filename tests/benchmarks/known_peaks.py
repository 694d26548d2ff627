"""Peaks that are known: bodies with exact solutions, and benchmark problems."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from exact_bodies import HEIGHT, MATERIAL, PLANES, PROBLEMS, solve, tetrahedralise

from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import Recovery
from fea.solid.stress import von_mises
from fea.verify.body import STEEL, LoadedBody, SolvedBody
from fea.verify.cases import dynamics, elasticity, nafems
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

SIZES = (0.6, 0.42, 0.3, 0.2, 0.15)


@dataclass(frozen=True)
class KnownPeak:
    """A largest von Mises stress, computed and true.

    Attributes
    ----------
    case
        What, and on which mesh.
    order
        Of the elements.
    value, error
        (n_nodes,) von Mises stress and its estimated error, MPa.
    masked
        (n_nodes,) nodes where the peak is not looked for; None for none.
    truth, uncertainty
        The true peak, and how far it may be off, MPa.
    """

    case: str
    order: int
    value: np.ndarray
    error: np.ndarray
    masked: np.ndarray | None
    truth: float
    uncertainty: float = 0.0


@dataclass(frozen=True)
class Problem:
    """A benchmark problem whose peak is known on the inner surface.

    Attributes
    ----------
    solved
        From the element size.
    sizes
        Element sizes.
    truth
        (σ, σ') the principal stresses that are not zero, MPa, or one more on a pressed surface.
    uncertainty_percent
        Of the target.
    inner
        Whether the peak is looked for on `Surface.INNER` alone.
    """

    solved: Callable[[float], SolvedBody]
    sizes: tuple[float, ...]
    truth: tuple[float, float, float]
    uncertainty_percent: float
    inner: bool = True


def _solved(
    meshed: Callable[[float], TetMesh], loaded: Callable[[TetMesh], LoadedBody]
) -> Callable[[float], SolvedBody]:
    return lambda size: loaded(meshed(size)).solved()


_NU = STEEL.poissons_ratio
_HOLE = nafems.PLATE_FACTOR * nafems.TENSION
_CAVITY = elasticity.EQUATOR
# Along the equator of the cavity: Timoshenko & Goodier 1970, chapter 12.
_AROUND = elasticity.TENSION * (15 * _NU - 3) / (2 * (7 - 5 * _NU))
BENCHMARKS = {
    # In plane strain the stress across the plane is ν times that in it.
    "NAFEMS LE1": Problem(
        _solved(nafems.le1_mesh, nafems.le1_body), (600, 400, 280, 200), (92.7, _NU * 92.7, 0), 0.1
    ),
    "NAFEMS LE10": Problem(_solved(nafems.le10_mesh, nafems.le10_body), (400, 280, 200), (-5.38, 0, -1), 0.1),
    "plate with a hole": Problem(
        _solved(nafems.plate_mesh, nafems.plate_body), (3, 2, 1.4), (_HOLE, _NU * _HOLE, 0), 0.1
    ),
    "Goodier, verify": Problem(
        lambda size: elasticity.goodier_body(size).solved(), (0.2, 0.14, 0.1), (_CAVITY, _AROUND, 0), 0.0
    ),
    "rotating disc": Problem(
        lambda size: dynamics.spun_disc(dynamics.disc_mesh(size)),
        (20, 14, 10),
        (dynamics.DISC_CENTRE, dynamics.DISC_CENTRE, 0),
        0.0,
        inner=False,
    ),
}


def benchmark_peaks() -> Iterator[KnownPeak]:
    """Peaks of the benchmark problems."""
    for name, problem in BENCHMARKS.items():
        tensor = np.array([[*problem.truth, 0.0, 0.0, 0.0]])
        truth = float(von_mises(tensor)[0])
        for size in problem.sizes:
            found = problem.solved(size)
            error = ErrorEstimator(found.mesh, (found.material,))(
                found.displacement, [found.stress[:, :, None]]
            ).stress[0][:, 0]
            masked = np.full(len(error), problem.inner)
            if problem.inner:
                masked[found.mesh.facets[Surface.INNER]] = False
            uncertainty = truth * problem.uncertainty_percent / 100
            value = von_mises(found.stress)
            yield KnownPeak(f"{name}, {size:g} mm", 2, value, error, masked, truth, uncertainty)


def exact_peak(name: str) -> float:
    """Largest von Mises stress of an exact solution, on the inner surface of all these bodies."""
    problem = PROBLEMS[name]
    angle = np.linspace(0, np.pi / 2, 721)
    rings = [0.0] if problem.cylinder else np.linspace(0, np.pi / 2, 7)
    c, s = np.cos(angle), np.sin(angle)
    places = np.concatenate([np.stack([c, s * np.cos(t), s * np.sin(t)], axis=1) for t in rings])
    return float(von_mises(problem.stress(places)).max())


def exact_peaks(order: int, sizes: tuple[float, ...] = SIZES) -> Iterator[KnownPeak]:
    """Peaks of the bodies with exact solutions."""
    for name, problem in PROBLEMS.items():
        for size in sizes:
            for seed in (1, 2):
                mesh = tetrahedralise(problem, size, order=order, seed=seed)
                u = solve(problem, mesh)
                recovery = Recovery(mesh, PLANES, problem.known)
                stress = recovery.nodal_stress(u, MATERIAL, traction=problem.traction(mesh))
                error = ErrorEstimator(mesh, (MATERIAL,))(u, [stress]).stress[0][:, 0]
                # An end that is only held flat is a mirror plane that recovery is not told of.
                away = (mesh.points[:, 2] > 0.6 * HEIGHT) if problem.flat_end else None
                case = f"{name}, {size:g}, seed {seed}"
                yield KnownPeak(case, order, von_mises(stress[..., 0]), error, away, exact_peak(name))
