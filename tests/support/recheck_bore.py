"""The pressure on a bore, integrated anew.

The law is the program's documented one: p = p(ψ) (a + b sin ψ) with the exact resultant, and an arc that ends
within a facet on the straight line, in reference coordinates, where the angle interpolated between the
corners is the arc's end. The integration over the facets it crosses is another: along lines of equal angle.
"""

import math
import re

import numpy as np
from recheck_elements import rule, shapes

FACES = np.array([[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]])
DEGREE, LINES = 12, 12
_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def bore_faces(points, tets, center, radius):
    """Faces (n, 3 or 6) of the skin that lie on a bore."""
    local = FACES if tets.shape[1] == 10 else FACES[:, :3]
    faces = tets[:, local].reshape(-1, local.shape[1])
    _, first, counts = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    faces = faces[first[counts == 1]]
    away = np.hypot(points[:, 0] - center, points[:, 1])
    return faces[(np.abs(away - radius) < 1e-6 * radius)[faces[:, :3]].all(axis=1)]


def arc(pressure, axial):
    """Relative pressure over the angle from the force, and half its arc; an end is pulled if axial > 0."""
    if pressure == "webster":
        pressure = "cosine-180" if axial > 0 else "uniform-120"
    shape, degrees = re.fullmatch(r"(cosine|uniform)-([\d.]+)", pressure).groups()
    half = math.radians(float(degrees)) / 2
    return (np.ones_like if shape == "uniform" else lambda psi: np.cos(np.pi / (2 * half) * psi)), half


def bore_forces(points, faces, center, force, pressed):
    """Pressure on a bore with the resultant `force` (x, y), as nodal forces (n, 3)."""
    out = np.zeros_like(points)
    magnitude, direction = math.hypot(*force), math.atan2(force[1], force[0])
    if not magnitude:
        return out
    shape, half = pressed
    corners = points[faces] - [center, 0, 0]
    samples = []  # number of the facet, area, values, angle
    psi = _turned(np.arctan2(corners[:, :3, 1], corners[:, :3, 0]), direction)
    for facet in np.flatnonzero((psi.max(axis=1) > -half) & (psi.min(axis=1) < half)):
        if np.abs(psi[facet]).max() <= half:
            weights, values, slopes = rule(faces.shape[1], DEGREE)
        else:
            places, weights = lines(psi[facet], half)
            values, slopes = shapes(faces.shape[1], places.T)
        tangents = np.einsum("ni,qnk->qik", corners[facet], slopes)
        area = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1) * weights
        x, y, _ = (values @ corners[facet]).T
        samples.append((faces[facet], area, values, np.arctan2(y, x)))
    area, angle = (np.concatenate([sample[part] for sample in samples]) for part in (1, 3))
    psi = np.mod(angle - direction + math.pi, 2 * math.pi) - math.pi
    basis = [shape(psi), shape(psi) * np.sin(psi)]
    system = [[(area * b * trig(psi)).sum() for b in basis] for trig in (np.cos, np.sin)]
    a, b = np.linalg.solve(system, [magnitude, 0.0])
    pressure, start = area * (a * basis[0] + b * basis[1]), 0
    for nodes, own, values, angle in samples:
        force = pressure[start : start + len(own), None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        out[nodes, :2] += values.T @ force
        start += len(own)
    return out


def lines(psi, half):
    """Places (q, 2) and weights for the part within ±`half` of a triangle, psi (3,) at its corners."""
    order = np.argsort(psi)
    (low, middle, high), (first, second, third) = psi[order], _CORNERS[order]
    t, w = (each / 2 for each in np.polynomial.legendre.leggauss(LINES))
    t = t + 0.5
    places, weights = [], []
    for start, end, one, other in ((low, middle, first, second), (middle, high, second, third)):
        at, stop = max(start, -half), min(end, half)
        if at >= stop:
            continue
        v, along = (each.ravel() for each in np.meshgrid(at + t * (stop - at), t, indexing="ij"))
        whole, part = (third - first) / (high - low), (other - one) / (end - start)
        a, b = first + (v - low)[:, None] * whole, one + (v - start)[:, None] * part
        slope = whole + along[:, None] * (part - whole)
        across = b - a
        places.append(a + along[:, None] * across)
        area = np.abs(slope[:, 0] * across[:, 1] - slope[:, 1] * across[:, 0])
        weights.append(area * (stop - at) * np.outer(w, w).ravel())
    return np.concatenate(places), np.concatenate(weights)


def _turned(angle, direction):
    """Angles (n, 3) from a direction, of the corners of a facet without a jump among them."""
    first = np.mod(angle[:, :1] - direction + math.pi, 2 * math.pi) - math.pi
    return first + np.mod(angle - angle[:, :1] + math.pi, 2 * math.pi) - math.pi
