"""Contact of separate parts by scikit-fem and penalties: the whole stiffness at once, no multipliers.

It shares with the product only the mesh. Every pressure is a penalty on the mean overlap around a vertex,
weighted by a linear function; the error falls like one over the penalty.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import pypardiso
from scipy import sparse
from skfem import Basis, BilinearForm, ElementTetP1, ElementTetP2, ElementVector, FacetBasis, LinearForm
from skfem.models.elasticity import lame_parameters, linear_elasticity

from fea.solid.scikit_fem import to_skfem
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_TURN

ROUNDS = 80
# What rounding leaves of a step of Newton's method, relative to the displacement.
SETTLED = 1e-8


@dataclass(frozen=True)
class Touching:
    """Two named surfaces whose facets match.

    `normal` leads from places (3, …) to unit vectors (3, …) out of the first part into the second; `tangents`
    are two such functions, for friction. Shear along them is odd about the mirror planes x, y or z = 0 with
    the numbers `odd`, and zero there. `overlap` is the interference of the parts as made, mm.
    """

    first: str
    second: str
    normal: object
    overlap: float = 0.0
    friction: float = 0.0
    tangents: tuple = ()
    odd: tuple = (None, None)


@dataclass(frozen=True)
class Screw:
    """A bolt: nodal forces (n_nodes, 3) of a tension of 1 N on its two seats, and its stiffness, N/mm."""

    pull: np.ndarray
    stiffness: float


@dataclass(frozen=True)
class State:
    """A solution: u (n_nodes, 3), by interface the pressures (n,) and shears (n, 2), MPa, and bolt forces, N.

    `slide` are the moments (n, 2) of the tangential displacement.
    """

    u: np.ndarray
    pressure: tuple
    shear: tuple
    slide: tuple
    tension: np.ndarray
    rounds: int = 0


@dataclass
class _Interface:
    """Moments of the displacement across an interface: rows (n, dofs) along the normal and two tangents."""

    touching: Touching
    nodes: np.ndarray  # of the first side, one a vertex
    weight: np.ndarray
    normal: sparse.csr_matrix
    tangents: list = field(default_factory=list)


class DirectContact:
    """Separate parts that touch.

    Parameters
    ----------
    mesh
        `TetMesh` of second order, its parts without common nodes.
    moduli
        (E, ν) of each part.
    touching, screws
        Interfaces and bolts.
    held
        (n_nodes, 3) fixed degrees of freedom.
    penalty
        MPa per mm of overlap.
    """

    def __init__(self, mesh, moduli, touching, held, *, screws=(), penalty=1e9):
        self.mesh, self.screws, self.penalty = mesh, screws, penalty
        skfem, nodes = to_skfem(mesh)
        assert len(nodes) == len(mesh.points)
        # Degree of freedom of scikit-fem's P2 vectors by node and axis of the mesh.
        self.dof = np.empty(mesh.points.shape, int)
        self.dof[nodes] = np.arange(3 * len(nodes)).reshape(-1, 3)
        element = ElementVector(ElementTetP2())
        part = np.zeros(len(mesh.tets), int) if mesh.part is None else mesh.part
        self.K = 0
        for number, (E, nu) in enumerate(moduli):
            basis = Basis(skfem, element, intorder=4, elements=np.flatnonzero(part == number))
            self.K = self.K + linear_elasticity(*lame_parameters(E, nu)).assemble(basis)
        self.interfaces = [_interface(mesh, skfem, nodes, element, own) for own in touching]
        self.free = np.sort(self.dof[~held])
        self.pulls = [self.flat(screw.pull) for screw in screws]

    def flat(self, by_node):
        """Vector of scikit-fem's degrees of freedom."""
        found = np.empty(by_node.size)
        found[self.dof] = by_node
        return found

    def at_rest(self):
        """Nothing moved or pressed: from here on there is friction."""
        none = [np.zeros((own.weight.size, 2)) for own in self.interfaces]
        pressure = tuple(own[:, 0] for own in none)
        return State(np.zeros(self.dof.shape), pressure, tuple(none), tuple(none), np.zeros(len(self.screws)))

    def solve(self, forces, *, state=None, tension=None, locked=None):
        """Solve for nodal forces (n_nodes, 3).

        Parameters
        ----------
        state
            From which friction goes on; without one there is no friction yet.
        tension
            Forces of the bolts, if these are given.
        locked
            The state in which the bolts were locked at their lengths.
        """
        load, u = self.flat(forces), np.zeros(self.dof.size)
        if state is not None:
            u = self.flat(state.u)
        first = not np.any(u)
        for count in range(1, ROUNDS + 1):
            residual, tangent, found = self._linearised(
                u, load, state, tension, locked, all_touch=first and count == 1
            )
            step = np.zeros_like(u)
            step[self.free] = pypardiso.spsolve(
                tangent[self.free][:, self.free].tocsr(), -residual[self.free]
            )
            u = u + step
            scale = np.abs(u).max()
            if np.abs(step).max() <= SETTLED * scale and count > 1:
                _, _, found = self._linearised(u, load, state, tension, locked, all_touch=False)
                return replace(found, rounds=count)
        raise AssertionError(f"the penalised contact did not settle: {np.abs(step).max()} of {scale}")

    def _linearised(self, u, load, state, tension, locked, *, all_touch):
        residual, tangent = self.K @ u - load, [self.K]
        pressures, shears, slides, forces = [], [], [], []
        for number, own in enumerate(self.interfaces):
            spring = self.penalty / own.weight
            gap = own.normal @ u - own.touching.overlap * own.weight
            active = (gap < 0) | all_touch
            pressure = np.where(active, -spring * gap, 0.0)
            rows = own.normal[active]
            residual = residual - own.normal.T @ pressure
            tangent.append(rows.T @ sparse.diags(spring[active]) @ rows)
            pressures.append(pressure)
            slide = (
                np.stack([row @ u for row in own.tangents], axis=1)
                if own.tangents
                else np.zeros((len(gap), 2))
            )
            shear = np.zeros_like(slide)
            if own.touching.friction and state is not None:
                shear, derivative = _coulomb(own, state, number, slide, pressure, active, spring)
                for row, part in zip(own.tangents, shear.T, strict=True):
                    residual = residual - row.T @ part
                tangent.append(derivative)
            shears.append(shear)
            slides.append(slide)
        for number, (screw, pull) in enumerate(zip(self.screws, self.pulls, strict=True)):
            if locked is None:
                force = tension[number]
            else:
                force = locked.tension[number] - screw.stiffness * (pull @ (u - self.flat(locked.u)))
                column = sparse.csr_matrix(pull[:, None])
                tangent.append(screw.stiffness * (column @ column.T))
            residual = residual - force * pull
            forces.append(force)
        found = State(u[self.dof], tuple(pressures), tuple(shears), tuple(slides), np.array(forces))
        return residual, sum(tangent[1:], tangent[0]), found


def _coulomb(own, state, number, slide, pressure, active, spring):  # noqa: PLR0917
    """Shears (n, 2), returned to Coulomb's cone from those of the state before, and minus their slope."""
    trial = state.shear[number] - spring[:, None] * (slide - state.slide[number])
    size, most = np.linalg.norm(trial, axis=1), own.touching.friction * pressure
    slips = size > most
    size = np.where(size > 0, size, 1.0)
    towards = trial / size[:, None]
    shear = np.where(slips[:, None], most[:, None] * towards, trial)
    slope = 0
    share = np.where(slips, most / size, 1.0)
    for i, row in enumerate(own.tangents):
        for j, other in enumerate(own.tangents):
            within = share * spring * ((i == j) - np.where(slips, towards[:, i] * towards[:, j], 0.0))
            slope = slope + row.T @ sparse.diags(within) @ other
        # A slipping vertex follows its pressure.
        follows = np.where(slips & active, own.touching.friction * spring * towards[:, i], 0.0)
        slope = slope + row.T @ sparse.diags(follows) @ own.normal
    return shear, slope


def _interface(mesh, skfem, nodes, element, touching):
    """Moments of both sides, vertex by vertex of the first."""
    sides = [_side(skfem, element, name, touching) for name in (touching.first, touching.second)]
    (own, weight, first), (other, _, second) = sides
    ahead, opposite = (mesh.facets[Surface(name)] for name in (touching.first, touching.second))
    # Row k of the second side is the facet of row k of the first, turned over.
    twin = np.empty(len(mesh.points), int)
    twin[ahead] = opposite[:, FACET_TURN[opposite.shape[1]]]
    place = np.empty(len(mesh.points), int)
    place[nodes[other]] = np.arange(len(other))
    order = place[twin[nodes[own]]]
    rows = [there[order] - here for here, there in zip(first, second, strict=True)]
    for number, axis in enumerate(touching.odd[: len(rows) - 1], 1):
        if axis is not None:
            rows[number] = sparse.diags((np.abs(skfem.p[axis, own]) > 1e-9).astype(float)) @ rows[number]
    return _Interface(touching, nodes[own], weight, rows[0], rows[1:])


def _side(mesh, element, name, touching):
    """Vertices of one side, their weights ∫ φ dA, and the moments ∫ φ u·d dA along each direction."""
    u = FacetBasis(mesh, element, facets=mesh.boundaries[name], intorder=8)
    p = FacetBasis(mesh, ElementTetP1(), facets=mesh.boundaries[name], intorder=8)
    vertices = np.unique(mesh.facets[:, mesh.boundaries[name]])

    def moments(direction):
        form = BilinearForm(lambda v, q, w: q * (v * direction(w.x)).sum(axis=0))
        return sparse.csr_matrix(form.assemble(u, p))[vertices]

    weight = LinearForm(lambda q, w: q).assemble(p)[vertices]
    return vertices, weight, [moments(d) for d in (touching.normal, *touching.tangents)]
