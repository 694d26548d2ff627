"""The weak forms of the problem as they stand on paper, and meshes and stiffnesses as scikit-fem's objects.

In the forms u is the displacement, v its variation, x places (3, n_elements, n_points) and n unit outward
normals; mm, N, MPa, t, s, K. Most of what a computation runs are batched kernels of the same integrals
(`fea.solid.assembly` and its neighbours): the tests hold them to these forms, and
``matrix_assembly = "scikit-fem"`` solves with that of elasticity.

What scikit-fem assembles adds to what is assembled here:

    foundation = BilinearForm(lambda u, v, w: 50.0 * dot(u, v))
    bore = basis(mesh).boundary("small_end_bore")
    K = (stiffness_coo(mesh, material) + foundation.coo_data(bore)).tocsr()
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from skfem import BilinearForm, CellBasis, ElementVector, LinearForm, MeshTet, MeshTet2
from skfem.assembly.form.coo_data import COOData
from skfem.generic_utils import hash_args
from skfem.helpers import ddot, div, dot, sym_grad
from skfem.mapping import MappingIsoparametric

from fea.base.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, element_stiffness, stiffness_degree
from geometry.arrays import Floats, Ints
from geometry.errors import require
from mesh.tetmesh import TetMesh, face_keys, scikit_fem_order

# From places (3, n_elements, n_points), mm, to a vector (3, …) or a number (…) at each of them.
Field = Callable[[Floats], Floats]


def elasticity(material: Material | Materials) -> BilinearForm:
    """∫ σ(u) : ε(v) dV = ∫ λ ∇·u ∇·v + 2 μ ε(u) : ε(v) dV by Hooke's law, N/mm."""
    lam, mu = _lame(material)
    return BilinearForm(lambda u, v, _: lam * div(u) * div(v) + 2 * mu * ddot(sym_grad(u), sym_grad(v)))


def traction(t: Callable[[Floats, Floats], Floats]) -> LinearForm:
    """∫ t · v dA, N, of a traction t(x, n), MPa, on a basis of facets."""
    return LinearForm(lambda v, w: dot(t(w.x, w.n), v))


def body_force(b: Field) -> LinearForm:
    """∫ b · v dV, N, of a force per volume b(x), N/mm³; that of inertia is −ρ a (D'Alembert)."""
    return LinearForm(lambda v, w: dot(b(w.x), v))


def mass(density: float | Floats) -> BilinearForm:
    """∫ ρ u · v dV, t, of a density, t/mm³: of every element, or (n_elements,) of each."""
    rho = _of_each(density)
    return BilinearForm(lambda u, v, _: rho * dot(u, v))


def moment(density: float | Floats, f: Field) -> LinearForm:
    """∫ ρ f v dV of a number f(x) on a basis of scalar functions: with f = 1 the mass at each node, t."""
    rho = _of_each(density)
    return LinearForm(lambda v, w: rho * f(w.x) * v)


def thermal_strain(material: Material | Materials, expansion: float, rise: Field) -> LinearForm:
    """∫ σ(α ΔT I) : ε(v) dV = ∫ (3 λ + 2 μ) α ΔT ∇·v dV, N, of a temperature rise ΔT(x), K."""
    lam, mu = _lame(material)
    return LinearForm(lambda v, w: (3 * lam + 2 * mu) * expansion * rise(w.x) * div(v))


def _lame(material: Material | Materials) -> tuple[Floats, Floats]:
    constants = material.of(slice(None))
    return _of_each(constants.lame_lambda), _of_each(constants.shear_modulus)


def _of_each(values: float | Floats) -> Floats:
    """Values of every element, or of each, in a shape that goes with (n_elements, n_points)."""
    return np.reshape(values, (-1, 1))


_MESHES = {1: MeshTet, 2: MeshTet2}
_AXES = 3
# A reference coordinate cannot be found more exactly than to a few roundings of the place.
_ROUNDINGS = 16 * np.finfo(float).eps


class SkfemMesh(NamedTuple):
    """A mesh of scikit-fem, and whose nodes its nodes are."""

    #: `skfem.MeshTet2`, as curved as the `TetMesh`, or `skfem.MeshTet` of first order. Its boundaries have
    #: the names of the surfaces, its subdomains those of the parts.
    mesh: Any
    #: (n_nodes,) the node of the `TetMesh` behind each node: 0, 1, 2, … where `mesh.tetmesh` numbered it, as
    #: it does for all meshes that `fea` makes
    nodes: Ints


def to_skfem(mesh: TetMesh, parts: Sequence[str] = ()) -> SkfemMesh:
    """Return a mesh as one of scikit-fem, with its surfaces and parts by name.

    Parameters
    ----------
    mesh
        Numbered in any way; nodes that no element has are left out.
    parts
        Names of the parts; by default ``part 0``, ``part 1``, …

    Raises
    ------
    InvalidValue
        A part has no name.
    ValueError
        Several edges join the same two vertices, which scikit-fem would take for one; or facets are of no
        element.

    Examples
    --------
    >>> from fea import prepare, to_skfem
    >>> mesh, nodes = to_skfem(prepare("leon-2001", size=14).mesh.cell)
    >>> sorted(mesh.boundaries)
    ['big_end_bore', 'free', 'small_end_bore', 'symmetry_y', 'symmetry_z']
    >>> (nodes == range(len(nodes))).all()
    np.True_
    """
    order, count = scikit_fem_order(mesh.tets, len(mesh.points)), np.unique(mesh.tets).size
    number, nodes = np.argsort(order), order[:count]
    corners = np.ascontiguousarray(number[mesh.tets[:, :4]].T)
    bare = _MESHES[mesh.order](np.ascontiguousarray(mesh.points[nodes].T), corners)
    if mesh.order == 2 and count != bare.nvertices + bare.nedges:
        middles = count - bare.nvertices
        message = (
            f"{middles} mid-edge nodes on {bare.nedges} pairs of vertices: scikit-fem has one edge per pair. "
            "Mesh with smaller elements"
        )
        raise ValueError(message)
    part = np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part
    n_parts = int(part.max()) + 1
    names = list(parts) or [f"part {index}" for index in range(n_parts)]
    require(len(names) >= n_parts, "parts", names, f"must name each of the {n_parts} parts")
    surfaces = {
        str(surface): _facet_numbers(bare, number[facets[:, :3]])
        for surface, facets in mesh.facets.items()
        if len(facets)
    }
    elements = {name: np.flatnonzero(part == index) for index, name in enumerate(names)}
    return SkfemMesh(bare.with_boundaries(surfaces).with_subdomains(elements), nodes)


def basis(mesh: TetMesh, intorder: int | None = None) -> CellBasis:
    """Return the basis of displacements on a mesh: P2, or P1 of first order, in x, y and z.

    ``basis(mesh).boundary("small_end_bore")`` is the basis on the facets of a surface.

    Parameters
    ----------
    mesh
        As for `to_skfem`, which tells how the nodes are numbered.
    intorder
        Degree of the polynomials that are integrated exactly where elements are straight; by default that
        with which the stiffness is integrated here.
    """
    degree = stiffness_degree(mesh.tets.shape[1]) if intorder is None else intorder
    return _basis(to_skfem(mesh).mesh, degree)


def stiffness_coo(mesh: TetMesh, material: Material | Materials) -> COOData:
    """Integrate the stiffness of all elements as scikit-fem's bilinear forms leave it, N/mm.

    The same, much faster, as ``elasticity(material).coo_data(basis(mesh))``.

    Parameters
    ----------
    mesh
        As for `to_skfem`.
    material
        Of every element, or of each part.

    Examples
    --------
    >>> from fea import basis, prepare, stiffness_coo
    >>> from skfem import BilinearForm
    >>> from skfem.helpers import dot
    >>> rod = prepare("leon-2001", size=14)
    >>> foundation = BilinearForm(lambda u, v, _: 50.0 * dot(u, v))  # N/mm³
    >>> bore = basis(rod.mesh.cell).boundary("small_end_bore")
    >>> K = (stiffness_coo(rod.mesh.cell, rod.material) + foundation.coo_data(bore)).tocsr()
    >>> K.shape[0] == 3 * len(rod.mesh.cell.points)
    True
    """
    number = np.argsort(scikit_fem_order(mesh.tets, len(mesh.points)))[mesh.tets].astype(np.int32)
    dofs = (_AXES * number[:, :, None] + np.arange(_AXES, dtype=np.int32)).reshape(len(mesh.tets), -1).T
    count, size = len(dofs), int(dofs.max()) + 1
    indices = np.empty((2, count, count, len(mesh.tets)), dtype=np.int32)  # by trial, then by test function
    indices[0], indices[1] = dofs[None], dofs[:, None]
    pairs = COOData(indices.reshape(2, -1), np.empty(0), (size, size), (count, count))
    return pairs.fromlocal(element_stiffness(mesh, material))


def assembled_stiffness(mesh: TetMesh, material: Material | Materials) -> SymmetricMatrix:
    """Assemble `fea.solid.assembly.stiffness` by scikit-fem alone, from the weak form of elasticity."""
    bridged = to_skfem(mesh)
    K = elasticity(material).assemble(_basis(bridged.mesh, stiffness_degree(mesh.tets.shape[1])))
    if (np.diff(bridged.nodes) != 1).any():
        dofs = (_AXES * np.argsort(bridged.nodes)[:, None] + np.arange(_AXES)).ravel()
        K = K[dofs][:, dofs]
    return SymmetricMatrix.of_full(K)


class _Isoparametric(MappingIsoparametric):  # type: ignore[misc]
    """The map of curved elements, inverted once for all basis functions, and far from the origin, too."""

    _inverted: tuple[object, Floats] = None, np.empty(0)

    def invDF(self, X: Floats, tind: Ints | None = None) -> Floats:
        of = hash_args(X, tind)
        if self._inverted[0] != of:
            self._inverted = of, super().invDF(X, tind)
        return self._inverted[1]

    def invF(
        self, x: Floats, tind: Ints | None = None, newton_max_iters: int = 50, newton_tol: float = 1e-12
    ) -> Floats:
        # Facets find their quadrature points in the elements by Newton's steps, down to a tolerance below the
        # rounding of places where elements are smaller than a thousandth of their distance from the origin.
        steepest = np.abs(self.invDF(np.full((3, 1), 0.25), tind)).max()
        rounding = _ROUNDINGS * np.abs(x).max() * steepest
        return np.asarray(super().invF(x, tind, newton_max_iters, newton_tol + rounding))


def _basis(mesh: MeshTet, intorder: int) -> CellBasis:
    mapping = _Isoparametric(mesh, mesh.elem(), mesh.bndelem) if isinstance(mesh, MeshTet2) else None
    return CellBasis(mesh, ElementVector(mesh.elem()), mapping=mapping, intorder=intorder)


def _facet_numbers(mesh: MeshTet, facets: Ints) -> Ints:
    """Numbers that scikit-fem gives facets (n_facets, 3) of vertices, in whatever order."""
    of_mesh, keys = (face_keys(each.astype(np.int64), mesh.nvertices) for each in (mesh.facets.T, facets))
    numbers = np.minimum(np.searchsorted(of_mesh, keys), len(of_mesh) - 1)
    missing = np.flatnonzero(of_mesh[numbers] != keys)
    if missing.size:
        first = np.sort(facets[missing[0]]).tolist()
        raise ValueError(f"{missing.size} facets, the first of vertices {first}, that no element has")
    return np.asarray(numbers)
