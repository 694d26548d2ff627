"""The inertia of a moving body: mass properties, D'Alembert forces, and the equilibrium with them."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.solid.assembly import VOLUME_DEGREE, SymmetricMatrix, gauss_blocks, pattern, tabulate, volume_points
from fea.solid.parity import ParityPair
from fea.solid.traction import traction_forces
from geometry.arrays import Floats, vector
from geometry.mass import MassProperties, tensor
from geometry.surfaces import PLANE_AXIS, Surface
from loads.instants import Instants, in_motion
from mesh.slices import Slice, cut
from mesh.tetmesh import TetMesh

# Unit motions whose forces are even about y = 0 (acceleration along x, spin) and odd (along y, spinning up).
EVEN_MOTIONS = (in_motion((1.0, 0.0)), in_motion((0.0, 0.0), 1.0))
ODD_MOTIONS = (in_motion((0.0, 1.0)), in_motion((0.0, 0.0), 0.0, 1.0))
_PLANES = (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)


@dataclass(frozen=True)
class Inertia:
    """Integrals over a meshed body from which the inertia forces of a planar rigid motion follow."""

    weight: Floats  #: (n_nodes,) integrals of ρ N_a, t
    moments: Floats  #: (n_nodes, 3) integrals of ρ N_a times x, y and z, t·mm
    #: Of the whole body, from the same quadrature, so that forces computed from both balance to rounding
    properties: MassProperties
    cut_y: bool  #: whether the mesh is cut at y = 0

    def forces(self, motion: Instants) -> ParityPair:
        """D'Alembert forces −ρ(a₀ + α × x − ω² x) as nodal forces, N."""
        ax, square, ay, alpha = motion.motions
        m, (mx, my, _), none = self.weight, self.moments.T, np.zeros_like(self.weight)
        symmetric = np.stack([square * mx - ax * m, square * my, none], axis=1)
        antisymmetric = np.stack([alpha * my, -ay * m - alpha * mx, none], axis=1)
        return ParityPair.of(symmetric, antisymmetric, cut=self.cut_y)


def inertia(mesh: TetMesh, density: float | Floats) -> Inertia:
    """Integrate mass and its moments over a cell; the planes it is cut at complete the properties.

    The density is that of every element, or (n_elements,) of each, t/mm³.
    """
    places, volumes = volume_points(mesh)
    mass = volumes * np.reshape(density, (-1, 1))
    values, nodes = tabulate(mesh.tets.shape[1], VOLUME_DEGREE).values, mesh.tets.ravel()
    weight, *moments = (
        np.asarray(np.bincount(nodes, (field @ values).ravel(), minlength=len(mesh.points)), dtype=float)
        for field in (mass, *(mass * places[..., axis] for axis in range(3)))
    )
    properties = _properties(mesh, places.reshape(-1, 3), mass.ravel())
    return Inertia(weight, np.stack(moments, axis=1), properties, Surface.SYMMETRY_Y in mesh.facets)


def _properties(cell: TetMesh, places: Floats, mass: Floats) -> MassProperties:
    """Mass properties of point masses (n,) at places (n, 3) of a cell, with their mirror images."""
    mirrored = [PLANE_AXIS[plane] for plane in _PLANES if plane in cell.facets]
    images = 2 ** len(mirrored)
    total = images * mass.sum()
    first = images * (mass @ places)
    second = images * ((places * mass[:, None]).T @ places)
    for axis in mirrored:  # odd moments of a mirrored body vanish
        first[axis] = 0.0
        second[axis, np.arange(3) != axis] = second[np.arange(3) != axis, axis] = 0.0
    center = first / total
    central = second - total * np.outer(center, center)
    about = np.trace(central) * np.eye(3) - central
    return MassProperties(float(total), vector(center), tensor((about + about.T) / 2))


def mass_matrix(mesh: TetMesh, density: float | Floats) -> SymmetricMatrix:
    """Assemble M_ab = ∫ρ N_a N_b dV I, degrees of freedom node-wise (u_x, u_y, u_z), t."""
    n_nodes = mesh.tets.shape[1]
    layout = pattern(mesh.tets, len(mesh.points))
    values = tabulate(n_nodes, VOLUME_DEGREE).values
    products = (values[:, :, None] * values[:, None, :]).reshape(len(values), -1)
    volumes = np.concatenate([block.volumes for _, block in gauss_blocks(mesh, VOLUME_DEGREE)])
    masses = (volumes * np.reshape(density, (-1, 1))) @ products
    masses = masses.reshape(-1, n_nodes, n_nodes)
    first, second = np.triu_indices(n_nodes)
    element = np.arange(len(masses))[:, None]
    ordered = masses[element, layout.node_order[:, first], layout.node_order[:, second]]
    return layout.matrix(ordered[..., None, None] * np.eye(3))


def enclosed_volume(mesh: TetMesh) -> float:
    """Volume inside facets, mm³, ∫ x · n dA / 3: that of the elements if facets fill the boundary once."""
    outwards = (traction_forces(mesh, surface, lambda _, normals: normals) for surface in mesh.facets)
    return sum(float((mesh.points * forces).sum()) for forces in outwards) / 3


# Resultants that vanish in plane motion: force along z, moments about x and y.
_OUT_OF_PLANE = (2, 3, 4)


@dataclass(frozen=True)
class Tilt:
    """The inertia of a body without a mirror plane that keeps it in its plane of motion.

    If a body is not symmetric about z = 0, pressures that are constant along the pins leave a small force
    along z and small moments about x and y, which the restraints would react as point forces. As in any
    inertia relief, the rigid accelerations that they cause balance them instead.
    """

    points: Floats  #: (n_nodes, 3), mm
    #: Nodal forces (3, n_nodes, 3) of rigid accelerations with one resultant each: a force of 1 N along z, a
    #: moment of 1 N·mm about x, and about y
    fields: Floats

    @classmethod
    def of(cls, points: Floats, inertia: Inertia) -> "Tilt":
        """Form the fields of a body whose nodes are `points`."""
        axes = np.eye(3)[:, None]
        rigid = np.concatenate([axes * inertia.weight[:, None], np.cross(axes, inertia.moments)])
        reached = np.stack([resultants(points, field) for field in rigid], axis=1)
        scale = np.sqrt(np.diag(reached))  # mass and moments of inertia differ by powers of ten
        shares = np.linalg.inv(reached / np.outer(scale, scale)) / np.outer(scale, scale)
        return cls(points, np.tensordot(shares[:, _OUT_OF_PLANE].T, rigid, axes=1))

    def balanced(self, forces: Floats) -> Floats:
        """Nodal forces (n_nodes, 3) plus the inertia forces that cancel their out-of-plane resultants."""
        return np.asarray(forces - np.tensordot(self.out_of_plane(forces), self.fields, axes=1))

    def out_of_plane(self, forces: Floats) -> Floats:
        """Force along z (N) and moments about x and y (N·mm) of nodal forces (n_nodes, 3)."""
        return resultants(self.points, forces)[list(_OUT_OF_PLANE)]


def resultants(points: Floats, forces: Floats) -> Floats:
    """Force (N) and moment about the origin (N·mm) of nodal forces (n_nodes, 3): (6,)."""
    return np.concatenate([forces.sum(axis=0), np.cross(points, forces).sum(axis=0)])


def imbalance(points: Floats, forces: ParityPair, images: int) -> tuple[float, float]:
    """Resultant force (N) and moment about z (N·mm) of nodal forces on the whole rod, both zero in balance.

    The nodes (n_nodes, 3) and forces are those of the cell, of which `images` make the whole rod.
    """
    x_part = forces.symmetric
    y_part = forces.symmetric if forces.antisymmetric is None else forces.antisymmetric
    moment = points[:, 0] @ y_part[:, 1] - points[:, 1] @ y_part[:, 0]
    resultant = np.hypot(x_part[:, 0].sum(), y_part[:, 1].sum())
    return float(images * resultant), float(images * abs(moment))


_XX, _XY = 0, 3


class SectionBalance:
    """The section of a rod at x = `station`, mm, and the cell's mass beyond it, computed on first use."""

    def __init__(
        self, whole: TetMesh, cell: TetMesh, density: float | Floats, rod_length: float, station: float
    ) -> None:
        self._whole, self._cell, self._density = whole, cell, density
        self._rod_length, self._station = rod_length, station

    def error(self, case: Instants, stress: Floats) -> float:
        """Equilibrium error of a case's nodal stress (n_nodes, 6), MPa, at the section.

        Returns the larger of the force error and the moment error over the radius of gyration, relative to
        the largest bore force plus the moment over the radius of gyration.
        """
        x, y = map(float, case.pin)
        moment = (self._rod_length - self._station) * y
        if case.motions.any():
            along, across, turning = _inertia_forces(self._beyond, case)
            center_x, center_y, _ = self._beyond.center
            moment += (center_x - self._station) * across - center_y * along + turning
            x, y = x + along, y + across
        values, areas = self._slice.at_corners(stress[:, [_XX, _XY]]), self._slice.areas
        normal, shear = (areas @ values.mean(axis=1)).tolist()
        sigma, height = values[..., 0], self._slice.places[..., 0]  # each linear on a triangle
        products = height.sum(axis=1) * sigma.sum(axis=1) + (height * sigma).sum(axis=1)
        error = max(abs(x - normal), abs(y - shear), abs(moment + areas @ products / 12) / self._gyration)
        return float(error / (float(case.largest_force) + abs(moment) / self._gyration))

    @cached_property
    def _slice(self) -> Slice:
        return cut(self._whole, self._station)

    @cached_property
    def _gyration(self) -> float:
        """Radius of gyration about z, mm."""
        section = self._slice.section()
        return math.sqrt(section.inertia_z / section.area)

    @cached_property
    def _beyond(self) -> MassProperties:
        """Mass properties beyond the section, by Gauss points; some elements must lie there."""
        mesh, station = self._cell, self._station
        far = mesh.points[mesh.tets, 0].max(axis=1) > station
        places, volumes = volume_points(TetMesh(mesh.points, mesh.tets[far]))
        mass = volumes * np.reshape(np.broadcast_to(self._density, len(far))[far], (-1, 1))
        beyond = places[..., 0] > station
        return _properties(mesh, places[beyond], mass[beyond])


def _inertia_forces(body: MassProperties, motion: Instants) -> tuple[float, float, float]:
    """D'Alembert force along x and y, N, and moment about the centre of gravity, N·mm."""
    x, y, _ = body.center
    ax, square, ay, alpha = map(float, motion.motions)
    along, across = ax - alpha * y - square * x, ay + alpha * x - square * y
    return -body.mass * along, -body.mass * across, -body.inertia_z * alpha
