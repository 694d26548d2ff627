"""The pressure of a pin on a bore, with exactly the given resultant."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fea.solid.bore import BoreFacets, FacetPoints, facets_within, radial_forces, radial_traction, wrapped
from fea.solid.parity import Split
from geometry.arrays import Floats

# Angles (rad) that agree to this many decimals count as equal, so that an arc may end at a node.
ANGLE_DECIMALS = 9


@dataclass(frozen=True)
class BoreLoad:
    """A bore pressure on the cell.

    Attributes
    ----------
    forces
        Nodal forces, N.
    traction
        At the bore's nodes, MPa, zero elsewhere.
    scale
        Factor on the analytic peak pressure that made the resultant exact.
    """

    forces: Split
    traction: Split
    scale: float


def bore_load(
    bore: BoreFacets,
    n_nodes: int,
    force: tuple[float, float],
    pressure: Callable[[Floats], Floats],
    half_arc: float,
) -> BoreLoad:
    """Press a bore in the direction of `force`, with exactly that resultant.

    The traction points along the exact radius, so that it has no moment about the bore's axis; the
    pressure p(ψ), ψ from the direction of the force, is multiplied by a + b sin ψ with the a ≈ 1 and
    b ≈ 0 that make both components of the discrete resultant exact.

    Parameters
    ----------
    bore
        The facets of the meshed cell.
    n_nodes
        Of the mesh.
    force
        (x, y) on the whole rod, N.
    pressure
        p(ψ), MPa, of the whole force on the whole width; vectorised, and smooth slightly beyond the arc too.
    half_arc
        |ψ| beyond which there is no pressure, rad; see `facets_within`.
    """
    magnitude, direction = float(np.hypot(*force)), float(np.arctan2(force[1], force[0]))
    sides = (1, -1) if bore.cut_y else (1,)  # the cell, and its mirror image reflected onto the cell
    if not magnitude:
        nothing = np.zeros((n_nodes, 3))
        split = Split(nothing, nothing if bore.cut_y else None)
        return BoreLoad(split, split, 1.0)
    own, nodes = np.unique(bore.nodes, return_inverse=True)  # sums over the nodes of the bore only
    local = replace(bore, nodes=nodes.reshape(bore.nodes.shape))

    def psi(angle: Floats, side: int) -> Floats:
        return np.asarray(side * wrapped(angle - side * direction))

    basis = [
        _basis(facets_within(local, side * direction, half_arc), own.size, pressure, partial(psi, side=side))
        for side in sides
    ]
    factors = np.linalg.solve(_resultants(basis, direction, bore), [magnitude, 0.0])

    def nodal(side: int) -> Floats:
        off = psi(bore.node_angle, side)
        within = np.heaviside(np.round(half_arc - np.abs(off), ANGLE_DECIMALS), 0.5)
        return np.asarray(within * pressure(off) * (factors[0] + factors[1] * np.sin(off)))

    forces = [np.zeros((n_nodes, 3)) for _ in sides]
    for force_here, both in zip(forces, basis, strict=True):
        force_here[own] = np.tensordot(factors, both, axes=1)
    tractions = [radial_traction(bore, n_nodes, nodal(side)) for side in sides]
    return BoreLoad(_split(forces), _split(tractions), float(factors[0]))


def _basis(
    facets: Iterable[FacetPoints],
    n_nodes: int,
    pressure: Callable[[Floats], Floats],
    psi: Callable[[Floats], Floats],
) -> Floats:
    """Nodal forces (2, n_nodes, 3) of p and of p sin ψ."""
    forces = np.zeros((2, n_nodes, 3))
    for points in facets:
        off = psi(points.angle)
        pressed = pressure(off)
        forces[0] += radial_forces(points, n_nodes, pressed)
        forces[1] += radial_forces(points, n_nodes, pressed * np.sin(off))
    return forces


def _resultants(basis: list[Floats], direction: float, bore: BoreFacets) -> Floats:
    """Resultants along and across the force of p and of p sin ψ (columns), over every image of the cell."""
    sums: Floats = np.stack([forces.sum(axis=1) for forces in basis])  # (n_sides, 2, 3)
    x, y = sums[..., 0].sum(axis=0), sums[0, :, 1] - sums[1:, :, 1].sum(axis=0)
    cosine, sine = np.cos(direction), np.sin(direction)
    return (2 if bore.cut_z else 1) * np.stack([cosine * x + sine * y, cosine * y - sine * x])


def _split(fields: list[Floats]) -> Split:
    """Split a field into its parities, from its values on the cell and on its mirror image, if any."""
    if len(fields) == 1:
        return Split(fields[0], None)
    here, image = fields
    return Split((here + image) / 2, (here - image) / 2)
