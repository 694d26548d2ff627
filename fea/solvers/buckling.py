"""Linear buckling: (K + λ K_σ) φ = 0, where K_σ belongs to the stress of a reference load and λ scales it.

The mean motions of the ends are constrained, as pins constrain bores, so that no rigid motion is left. The
parities about y = 0 are coupled if the reference load has both; those about z = 0 never are, because the load
is symmetric about it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial, reduce
from itertools import product

import numpy as np
from scipy import sparse

from fea.base.choices import SolverName
from fea.solid.assembly import GeometricStiffness
from fea.solid.errors import UnderconstrainedError
from fea.solid.parity import Parity
from fea.solid.supports import (
    BENDING,
    TURN_Z,
    ConstrainedSurface,
    isostatic_restraints,
    mean_motions,
    motions_with,
    rigid_motions,
    rigid_with,
)
from fea.solvers.choice import linear_solver
from fea.solvers.direct import Operator
from fea.solvers.static import Model
from geometry.arrays import Floats, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Number of additional pairs that are improved too, so that none is overlooked, and their accuracy.
_GUARDS = 2
_GUARDED = 0.1
_ROUNDS = 40
_PATIENCE = 5
# Size of the space, in blocks of vectors, at which it is reduced to two blocks.
_BLOCKS = 5
# A vector shorter than this fraction of its original length after orthogonalisation is only rounding.
_DEPENDENT = 1e-10


@dataclass(frozen=True)
class Space:
    """Vectors and the forces that cause them."""

    vectors: Floats  #: Z (n, m), ZᵀKZ = 1
    forces: Floats  #: F (n, m) with K⁻¹F = Z

    def __matmul__(self, weights: Floats) -> "Space":
        return Space(self.vectors @ weights, self.forces @ weights)

    def without(self, other: "Space") -> "Space":
        """Return a K-orthonormal basis of the part of this space that is not in another."""
        vectors, forces = self.vectors, self.forces
        for _ in range(2):  # twice is enough (Parlett 1980)
            share = other.forces.T @ vectors
            vectors, forces = vectors - other.vectors @ share, forces - other.forces @ share
        return orthonormal(vectors, forces)

    def joined(self, other: "Space") -> "Space":
        """Return the sum of two spaces that are orthogonal to each other."""
        return Space(np.hstack([self.vectors, other.vectors]), np.hstack([self.forces, other.forces]))


@dataclass(frozen=True)
class Pairs:
    """Eigenvalues and vectors."""

    values: Floats  #: θ (k,), in decreasing order
    vectors: Floats  #: φ (n, k)
    residuals: Floats  #: ‖φ − K⁻¹A φ/θ‖ / ‖φ‖ (k,), maximum norms
    space: Space  #: the space to start from for a similar A


def largest(
    solve: Operator,
    push: Operator,
    start: Space,
    count: int,
    *,
    least: float,
    accuracy: float,
    enough: float = 0.0,
) -> Pairs:
    """Find the `count` largest positive eigenvalues, from a space with a component of every wanted vector.

    `solve` and `push` multiply blocks (n, k) by K⁻¹ and A. Eigenvalues below the fraction `least` of the
    largest magnitude are ignored, those below `enough` are not needed. `accuracy` is the largest accepted
    residual; the error of θ is of the order of its square.
    """
    space, pushed, block = start, push(start.vectors), count + _GUARDS
    for turn in range(_ROUNDS):
        values, weights = np.linalg.eigh(_symmetric(space.vectors.T @ pushed))
        values, weights = values[::-1], weights[:, ::-1]
        theta, best = values[:block], weights[:, :block]
        ritz, images = space @ best, pushed @ best
        change = Space(solve(images) - theta * ritz.vectors, images - theta * ritz.forces)
        residuals = _lengths(change.vectors) / (np.abs(theta) * _lengths(ritz.vectors))
        counted = theta > least * np.abs(values).max()
        useful = theta * (1 + residuals) > enough  # the residual bounds the error of the eigenvalue
        limits = np.where((np.arange(len(theta)) < count) & useful, accuracy, _GUARDED)
        late = ~counted | (residuals > limits)
        # If too few eigenvalues count yet, more may still appear.
        patient = turn >= _PATIENCE or counted[:count].all()
        if turn == _ROUNDS - 1 or (patient and not (late & counted).any()):
            break
        if len(values) >= _BLOCKS * block:
            space, pushed = space @ weights[:, : 2 * block], pushed @ weights[:, : 2 * block]
        new = (change @ np.eye(len(theta))[:, late]).without(space)
        space, pushed = space.joined(new), np.hstack([pushed, push(new.vectors)])
    chosen = np.flatnonzero((counted & (theta > enough))[:count])
    kept = space @ weights[:, : 2 * block]
    return Pairs(theta[chosen], ritz.vectors[:, chosen], residuals[chosen], kept)


def orthonormal(vectors: Floats, forces: Floats) -> Space:
    """Return a basis with ZᵀKZ = 1 of the span of vectors, given with the forces that cause them."""
    space = Space(vectors, forces)
    for _ in range(2):
        values, weights = np.linalg.eigh(_symmetric(space.vectors.T @ space.forces))
        kept = values > _DEPENDENT * values.max(initial=0.0)
        space = space @ (weights[:, kept] / np.sqrt(values[kept]))
    return space


def _symmetric(matrix: Floats) -> Floats:
    return (matrix + matrix.T) / 2


def _lengths(vectors: Floats) -> Floats:
    return np.asarray(np.abs(vectors).max(axis=0))


@dataclass(frozen=True)
class _Constrained:
    """The body of one parity about each mirror plane, C u = 0.

    With the rigid motions R that the planes leave, u = K_c⁻¹(f − Cᵀμ) + R q, where K_c holds a few degrees
    of freedom that stop R, Rᵀ(f − Cᵀμ) = 0 and C u = 0 (Farhat & Roux 1991).
    """

    inverse: Operator  #: K_c⁻¹ times (n, k) forces that are zero at the fixed degrees of freedom of K_c
    fixed: Mask  #: (n,) degrees of freedom that the mirror planes or K_c hold
    rigid: Floats  #: R (n, n_rigid)
    rows: Floats  #: C (n_rows, n)
    answers: Floats  #: K_c⁻¹Cᵀ (n, n_rows)
    small: Floats  #: inverse of the matrix that gives μ and q

    def solve(self, forces: Floats) -> Floats:
        """Displacements (n, k) under forces (n, k); the constraints react forces that are not balanced."""
        u = _solved(self.inverse, self.fixed, forces)
        unknowns = self.small @ np.concatenate([self.rows @ u, self.rigid.T @ forces])
        n_rows = len(self.rows)
        return np.asarray(u - self.answers @ unknowns[:n_rows] + self.rigid @ unknowns[n_rows:])


def _constrained(
    mesh: TetMesh,
    surfaces: tuple[ConstrainedSurface, ...],
    parities: tuple[Parity, Parity],
    fixed: Mask,
    inverse: Operator,
) -> _Constrained:
    """Constrain the mean motions of surfaces of a body, for given parities about y = 0 and z = 0.

    `fixed` (n,) are the `isostatic_restraints` with which `inverse` is K_c⁻¹. Raises
    `UnderconstrainedError`: the surfaces leave a rigid motion free.
    """
    rigid, free = rigid_with(mesh, parities), motions_with(mesh, *parities)
    held = [(end, motion) for end in surfaces for motion in end.motions if motion in free]
    rows = [mean_motions(mesh, end.surface, end.center)[motion].ravel() for end, motion in held]
    C = np.stack(rows) if rows else np.zeros((0, mesh.points.size))
    if np.linalg.matrix_rank(C @ rigid) < rigid.shape[1]:
        raise UnderconstrainedError(
            "the constraints at the two ends leave a rigid motion of the body free. Constrain more motions"
        )
    answers = _solved(inverse, fixed, C.T)
    small = np.block([[C @ answers, -C @ rigid], [rigid.T @ C.T, np.zeros((rigid.shape[1],) * 2)]])
    return _Constrained(inverse, fixed, rigid, C, answers, np.linalg.inv(small))


def _solved(inverse: Operator, fixed: Mask, forces: Floats) -> Floats:
    if not forces.shape[1]:
        return forces
    u = inverse(np.where(fixed[:, None], 0.0, forces))
    u[fixed] = 0.0
    return u


class _ReferenceLoad:
    """K_σ of a reference load from the `GeometricStiffness` of its parts, with constrained ends.

    If an end may rotate about z, the direction of a pressure on it stays fixed.
    """

    def __init__(
        self, mesh: TetMesh, ends: tuple[ConstrainedSurface, ...], parts: Mapping[Parity, sparse.csr_array]
    ) -> None:
        self._parts = parts
        self._pins: list[tuple[float, Floats]] = []
        forces = parts[Parity.SYMMETRIC] @ mesh.points
        for end in ends:
            if TURN_Z not in end.motions:
                nodes = np.unique(mesh.facets[end.surface])
                arm = rigid_motions(mesh.points[nodes], np.array([end.center, 0.0, 0.0]))[TURN_Z]
                turned = np.cross([0.0, 0.0, 1.0], forces[nodes])
                row = mean_motions(mesh, end.surface, end.center)[TURN_Z]
                self._pins.append((float((arm * turned).sum()), row))

    def times(self, shape: Mapping[Parity, Floats], parity_z: Parity) -> dict[Parity, Floats]:
        """K_σ φ of shapes given by their parts (n_nodes, 3, k)."""
        product_of = {side: np.zeros_like(part) for side, part in shape.items()}
        for (of_load, matrix), (side, part) in product(self._parts.items(), shape.items()):
            product_of[Parity(of_load * side)] += (matrix @ part.reshape(len(part), -1)).reshape(part.shape)
        # The stress term alone describes forces that rotate with the bore; the pressure of a pin does not.
        turning = Parity.ANTISYMMETRIC if Parity.ANTISYMMETRIC in shape else Parity.SYMMETRIC
        for moment, row in self._pins if parity_z is Parity.SYMMETRIC else ():
            turn = np.einsum("ni,nik->k", row, shape[turning])
            product_of[turning] -= moment * row[:, :, None] * turn
        return product_of


# Largest accepted residual; the error of λ is of the order of its square.
_ACCURACY = 1e-4
# A load without compression still has eigenvalues 1/λ just above zero: those below this fraction of the
# largest (of either sign) are ignored.
_NOTHING = 1e-3
# Degree of the polynomials along the body whose forces bend and twist it into the initial shapes.
_DEGREE = 3


@dataclass(frozen=True)
class BucklingMode:
    """A buckling mode."""

    factor: float  #: λ > 0: the reference load times λ is critical
    shape: dict[Parity, Floats]  #: per parity about y = 0, (n_nodes, 3)
    parity_z: Parity  #: about z = 0
    residual: float  #: ‖φ + λ K⁻¹K_σ φ‖ / ‖φ‖, maximum norms


class Buckling:
    """A cell under inertia relief, constrained at its ends, factorised once for all reference loads.

    A pressure on an end that may rotate about z is that of a pin: its direction stays fixed. Raises
    `UnderconstrainedError`: the ends leave a rigid motion free; `SingularMatrixError`: a breakdown.
    """

    def __init__(self, model: Model, ends: tuple[ConstrainedSurface, ...]) -> None:
        mesh = model.mesh
        self._mesh, self._ends = mesh, ends
        self._sides = tuple(Parity) if Surface.SYMMETRY_Y in mesh.facets else (Parity.SYMMETRIC,)
        self._geometric = GeometricStiffness(mesh, model.material)
        symmetric = {}
        for side in self._sides:  # about z = 0 symmetric as well, with the model's factor
            fixed, inverse = model.restrained(side)
            symmetric[side] = _constrained(mesh, ends, (side, Parity.SYMMETRIC), fixed, inverse)
        self._bodies = {Parity.SYMMETRIC: symmetric}
        if Surface.SYMMETRY_Z in mesh.facets:
            self._bodies[Parity.ANTISYMMETRIC] = self._leaving(model)
        self._spaces = {parity_z: self._first(parity_z) for parity_z in self._bodies}

    def modes(self, displacement: Mapping[Parity, Floats], count: int) -> list[list[BucklingMode]]:
        """Find the `count` lowest positive factors of each reference load, in increasing order, or fewer.

        The displacement under the loads is given per parity about y = 0, (n_nodes, 3, n_loads), mm.
        """
        parts = {side: self._geometric(u) for side, u in displacement.items()}
        of_loads = []
        for matrices in zip(*parts.values(), strict=True):
            load = _ReferenceLoad(self._mesh, self._ends, dict(zip(parts, matrices, strict=True)))
            enough = self._enough(load, count)
            modes = [mode for parity_z in self._bodies for mode in self._modes(load, parity_z, count, enough)]
            of_loads.append(sorted(modes, key=lambda mode: mode.factor)[:count])
        return of_loads

    def _modes(self, load: _ReferenceLoad, parity_z: Parity, count: int, enough: float) -> list[BucklingMode]:
        """Modes of one parity about z = 0 with 1/λ not below `enough`."""
        pairs = largest(
            lambda f: self._solved(parity_z, f),
            lambda v: self._pushed(load, parity_z, v),
            self._spaces[parity_z],
            count,
            least=_NOTHING,
            accuracy=_ACCURACY,
            enough=enough,
        )
        # The next load starts from these shapes: similar loads have similar buckling modes.
        self._spaces[parity_z] = pairs.space
        return [
            BucklingMode(float(1 / value), self._parts(vector), parity_z, float(residual))
            for value, vector, residual in zip(pairs.values, pairs.vectors.T, pairs.residuals, strict=True)
        ]

    def _enough(self, load: _ReferenceLoad, count: int) -> float:
        """Lower bound of the `count` largest values of 1/λ: Ritz values are bounds from below."""
        values = [
            np.linalg.eigvalsh(_symmetric(each.vectors.T @ self._pushed(load, parity_z, each.vectors)))
            for parity_z, each in self._spaces.items()
        ]
        ranked = np.sort(np.concatenate(values))[::-1]
        return max(0.0, float(ranked[:count][-1]) * (1 - _ACCURACY))

    def _pushed(self, load: _ReferenceLoad, parity_z: Parity, vectors: Floats) -> Floats:
        """−K_σ times vectors (n, k)."""
        parts = load.times(self._parts(vectors), parity_z)
        stacked = np.stack([parts[side] for side in self._sides])
        return -stacked.reshape(-1, stacked.shape[-1])

    def _leaving(self, model: Model) -> dict[Parity, _Constrained]:
        solver = linear_solver(SolverName(model.solver), self._mesh, model.material, slots=len(self._sides))
        bodies = {}
        for slot, side in enumerate(self._sides):
            parities = side, Parity.ANTISYMMETRIC
            fixed = isostatic_restraints(self._mesh, parities)
            solver.factorise(slot, model.stiffness.constrained(fixed))
            bodies[side] = _constrained(self._mesh, self._ends, parities, fixed, partial(solver.solve, slot))
        return bodies

    def _first(self, parity_z: Parity) -> Space:
        """Displacements under forces that bend and twist the body, and under one irregular force."""
        points = self._mesh.points
        x = points[:, 0]
        along = np.polynomial.chebyshev.chebvander(2 * (x - x.min()) / np.ptp(x) - 1, _DEGREE)
        shapes = rigid_motions(points, np.zeros(3))[..., None] * along[:, None]
        spaces = []
        for place, (side, body) in enumerate(self._bodies[parity_z].items()):
            bending = BENDING.intersection(motions_with(self._mesh, side, parity_z))
            bent = [shapes[motion] for motion in sorted(bending)]
            odd = np.sin(np.arange(1.0, points.size + 1)).reshape(-1, 3, 1)
            forces = np.concatenate([*bent, odd], axis=2).reshape(points.size, -1)
            rows = slice(place * points.size, (place + 1) * points.size)
            vectors, pushes = np.zeros((2, len(self._sides) * points.size, forces.shape[1]))
            vectors[rows], pushes[rows] = body.solve(forces), forces
            spaces.append(orthonormal(vectors, pushes))
        return reduce(Space.joined, spaces)

    def _parts(self, v: Floats) -> dict[Parity, Floats]:
        parts = v.reshape(len(self._sides), len(self._mesh.points), 3, *v.shape[1:])
        return dict(zip(self._sides, parts, strict=True))

    def _solved(self, parity_z: Parity, f: Floats) -> Floats:
        parts, bodies = f.reshape(len(self._sides), -1, f.shape[1]), self._bodies[parity_z]
        pairs = zip(self._sides, parts, strict=True)
        return np.concatenate([bodies[side].solve(part) for side, part in pairs])
