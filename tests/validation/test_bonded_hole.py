"""A hole under a uniform traction vector, against the exact solution for an infinite body in plane strain.

A force P per thickness, spread uniformly over the edge r = R of a hole, has the potentials φ = −A ln z and
ψ = κ A ln z + A R²/z² (Muskhelishvili 1953) with A = P/(2π(1 + κ)), whose displacement is
2μ(u + iv) = −2κA ln r + A(1 − R²/r²) e^{2iθ}: the edge moves as a rigid body. A uniform traction is therefore
what a rigid pin exerts that is bonded to a hole in a large plate. The hoop stress on the edge is
−ν/(1 − ν) q cos θ, q = P/(2πR).
"""

import numpy as np
import pytest
from exact_bodies import HEIGHT, INNER, MATERIAL, PLANES, PROBLEMS, tetrahedralise

from fea.pins.bonded import BondedBore
from fea.solid.bore import bore_facets
from fea.solid.recovery import Recovery
from fea.solvers.static import displacement
from geometry.surfaces import Surface

FORCE = 8 * np.pi  # N on the thickness 2 HEIGHT, so that q = 2 MPa
NU, MU = MATERIAL.poissons_ratio, MATERIAL.shear_modulus
KAPPA = 3 - 4 * NU
A = FORCE / (2 * HEIGHT) / (2 * np.pi * (1 + KAPPA))
TRACTION = FORCE / (2 * HEIGHT) / (2 * np.pi)


def exact_displacement(points):
    x, y, _ = points.T
    z = x + 1j * y
    r = np.abs(z)
    w = (-2 * KAPPA * A * np.log(r) + A * (1 - 1 / r**2) * (z / r) ** 2) / (2 * MU)
    return np.stack([w.real, w.imag, 0 * r], axis=1)


def exact_stress(points):
    """σ_rr, σ_θθ, σ_rθ (n,)."""
    r, theta = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
    radial = -((3 + KAPPA) * A / r - 2 * A / r**3) * np.cos(theta)
    return radial, -4 * A / r * np.cos(theta) - radial, ((KAPPA - 1) * A / r + 2 * A / r**3) * np.sin(theta)


def solved(size):
    mesh = tetrahedralise(PROBLEMS["kirsch"], size)
    bond = BondedBore.of(bore_facets(mesh, INNER, 0.0), len(mesh.points))
    load = bond.load((FORCE, 0.0), 4 * np.pi * HEIGHT)
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    for plane, axis in zip(PLANES, (1, 2), strict=True):
        fixed[mesh.facets[plane].ravel(), axis] = True
    fixed[np.isclose(mesh.points[:, 2], HEIGHT), 2] = True
    fixed[mesh.facets[Surface.FREE].ravel()] = True  # the outer surface: held as the exact solution moves
    u = displacement(mesh, MATERIAL, load.forces.symmetric, fixed, exact_displacement(mesh.points))
    recovery = Recovery(mesh, PLANES, (INNER,))
    stress = recovery.nodal_stress(u, MATERIAL, traction={INNER: load.traction.symmetric[:, :, None]})
    return mesh, load, u[:, :, 0], stress[:, :, 0]


def polar(mesh, stress):
    angle = np.arctan2(mesh.points[:, 1], mesh.points[:, 0])
    c, s = np.cos(angle), np.sin(angle)
    xx, yy, _, xy, _, _ = stress.T
    radial, hoop = c * c * xx + s * s * yy + 2 * s * c * xy, s * s * xx + c * c * yy - 2 * s * c * xy
    return radial, hoop, (c * c - s * s) * xy + s * c * (yy - xx)


def on_bore(mesh):
    """Nodes of the hole away from the end that is only held flat."""
    nodes = np.unique(mesh.facets[INNER])
    return nodes[mesh.points[nodes, 2] < 0.6 * HEIGHT]


def errors(size):
    """Largest errors on the edge: of σ_rr, σ_θθ, σ_rθ over the traction, and of the displacement."""
    mesh, load, u, stress = solved(size)
    assert load.scale == pytest.approx(1, abs=1e-5)
    edge, exact = on_bore(mesh), exact_displacement(mesh.points)
    found = zip(polar(mesh, stress), exact_stress(mesh.points), strict=True)
    moved = np.abs(u - exact)[edge].max() / np.abs(exact).max()
    return *(np.abs(one - other)[edge].max() / TRACTION for one, other in found), moved


def test_a_bonded_hole_has_the_exact_stress_and_moves_as_a_rigid_body():
    coarse, fine = np.array(errors(0.28)), np.array(errors(0.14))
    # Traction is known on the edge, the hoop stress follows from the strain, which is of second order.
    radial, hoop, shear, moved = fine
    assert max(radial, shear) < 1e-3
    assert hoop < 0.015
    assert moved < 6e-4
    assert (coarse[[1, 3]] > 2 * fine[[1, 3]]).all()
