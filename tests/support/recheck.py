"""A written run examined anew, with nothing of the program but its files: piston, equilibrium, sections.

The internal forces K u are integrated from the displacement of the VTU files, the loads from the figures of
the summary.
"""

import json
import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import meshio
import numpy as np
import pyvista as pv
from recheck_bore import arc, bore_faces, bore_forces
from recheck_elements import rule
from recheck_pressure import pressures

VOLUME = 5
AT_REST = ("gas", "given")


@dataclass(frozen=True)
class Told:
    """What was asked: mm, t, N, MPa, rad/s; materials as (E, nu, density), the bushing's last."""

    materials: tuple[tuple[float, float, float], ...]
    big_radius: float
    small_radius: float
    length: float
    bushing: float = 0.0
    pressure: str = "cosine-180"
    clamped: bool = False
    crank_radius: float = 0.0
    speed: float = 0.0
    offset: float = 0.0
    friction: float = 0.0
    piston_mass: float = 0.0


class Errors(NamedTuple):
    """The largest over the cases of a run, each relative to the largest force."""

    equilibrium: float = 0.0
    section: float = 0.0
    piston: float = 0.0

    def worst(self, other):
        """The larger of each."""
        return Errors(*map(max, self, other))


@dataclass(frozen=True)
class Body:
    """The mesh of a run: places, elements with their materials, and what lies on its bores."""

    points: np.ndarray
    tets: np.ndarray
    material: np.ndarray
    small: np.ndarray
    big: np.ndarray

    @classmethod
    def of(cls, written, told):
        """The body of a VTU file."""
        points, tets = written.points.astype(float), written.cells[0].data.astype(int)
        small, big = (
            bore_faces(points, tets, center, radius)
            for center, radius in ((told.length, told.small_radius), (0.0, told.big_radius))
        )
        part = written.cell_data.get("part")
        return cls(points, tets, _materials(points, tets, told, part), small, big)

    @cached_property
    def internal(self):
        """At the stiffness's points: shape functions, gradients (n, n_local, 3), volumes (n, q)."""
        weights, values, slopes = rule(self.tets.shape[1], 2 if self.tets.shape[1] == 10 else 0)
        J = [self.points[self.tets].transpose(0, 2, 1) @ slope for slope in slopes]
        volumes = weights * np.stack([np.linalg.det(j) for j in J], axis=1)
        return values, [slope @ np.linalg.inv(j) for slope, j in zip(slopes, J, strict=True)], volumes

    @cached_property
    def inertial(self):
        """At the points of the rule of volumes: shape functions, volumes (n,), x and y (n,)."""
        corners = self.points[self.tets]
        found = []
        for weight, value, slope in zip(*rule(self.tets.shape[1], VOLUME), strict=True):
            x, y, _ = (value @ corners).T
            found.append((value, weight * np.linalg.det(corners.transpose(0, 2, 1) @ slope), x, y))
        return found

    def scattered(self, forces):
        """Sum forces (n_elements, n_local, 3) at their nodes."""
        sums = [
            np.bincount(self.tets.ravel(), forces[..., axis].ravel(), minlength=len(self.points))
            for axis in range(3)
        ]
        return np.stack(sums, axis=1)


def internal_forces(body, u, told):
    """K u at the nodes (n, 3): the work of the stress of u with each shape function's gradient."""
    values, g, volumes = body.internal
    E, nu = np.array([(E, nu) for E, nu, _ in told.materials])[body.material].T
    mu, lame = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    H = [u[body.tets].transpose(0, 2, 1) @ one for one in g]
    dilation = np.stack([np.trace(h, axis1=1, axis2=2) for h in H], axis=1)
    pressure = pressures(body.tets, dilation, volumes, values, (lame, nu, body.material))
    out = np.zeros((*body.tets.shape, 3))
    for one, h, p, volume in zip(g, H, pressure.T, volumes.T, strict=True):
        stress = mu[:, None, None] * (h + h.transpose(0, 2, 1)) + p[:, None, None] * np.eye(3)
        out += volume[:, None, None] * (one @ stress)
    return body.scattered(out)


def rod_angle(told, theta):
    """β of the rod, its first and second rate."""
    ratio, w = told.crank_radius / told.length, told.speed
    sin_b = ratio * math.sin(theta) - told.offset / told.length
    cos_b = math.sqrt(1 - sin_b**2)
    rate = ratio * w * math.cos(theta) / cos_b
    return math.asin(sin_b), rate, (-ratio * w * w * math.sin(theta) + rate**2 * sin_b) / cos_b


def inertia_forces(body, told, crank_deg, cut):
    """D'Alembert forces at the nodes (n, 3), and their resultant beyond x = `cut`."""
    theta, w = math.radians(crank_deg), told.speed
    beta, rate, growth = rod_angle(told, theta)
    inward = -told.crank_radius * w * w * np.array([math.cos(theta), math.sin(theta)])
    a_x, a_y = inward @ [math.cos(beta), -math.sin(beta)], inward @ [math.sin(beta), math.cos(beta)]
    density = np.array([rho for _, _, rho in told.materials])[body.material]
    beyond, out = np.zeros(3), np.zeros((*body.tets.shape, 3))
    for value, volume, x, y in body.inertial:
        mass = density * volume
        force = -mass * np.stack([a_x + growth * y - rate**2 * x, a_y - growth * x - rate**2 * y, 0 * x])
        beyond += force[:, x > cut].sum(axis=1)
        out += force.T[:, None, :] * value[:, None]
    return body.scattered(out), beyond


def piston_error(load, told):
    """What is left of m ẍ = −gas + friction − pin on the piston, over the largest of them."""
    theta, w, r, l = math.radians(load["crank_deg"]), told.speed, told.crank_radius, told.length
    beta, rate, growth = rod_angle(told, theta)
    velocity = -r * w * math.sin(theta) - l * rate * math.sin(beta)
    a = -r * w * w * math.cos(theta) - l * (rate**2 * math.cos(beta) + growth * math.sin(beta))
    along, across = load["pin_axial_N"], load["pin_transverse_N"]
    pin_x = along * math.cos(beta) + across * math.sin(beta)
    pin_y = across * math.cos(beta) - along * math.sin(beta)
    friction = -told.friction * abs(pin_y) * np.sign(velocity)
    parts = [told.piston_mass * a, load["gas_N"], -friction, pin_x]
    return float(abs(sum(parts)) / max(map(abs, parts)))


def recheck(folder, told):
    """Largest errors over the cases of a run: of piston, equilibrium, and the section amid the shank.

    Returns
    -------
    Errors
    """
    figures = json.loads((folder / "summary.json").read_text())
    found, body = Errors(), None
    for name, load in figures["loads"].items():
        written = meshio.read(folder / f"{name}.vtu")
        if body is None:  # the first file has exact coordinates
            body = Body.of(written, told)
        pin = load["pin_axial_N"], load["pin_transverse_N"]
        crank = -load["crank_axial_N"], load["crank_transverse_N"]
        largest = max(math.hypot(*pin), math.hypot(*crank))
        cut = 0.5 * told.length + 1e-3
        f = bore_forces(body.points, body.small, told.length, pin, arc(told.pressure, load["pin_axial_N"]))
        beyond = np.zeros(3)
        if name not in AT_REST:
            inertia, beyond = inertia_forces(body, told, load["crank_deg"], cut)
            f += inertia
        if not told.clamped:
            f += bore_forces(body.points, body.big, 0.0, crank, arc(told.pressure, load["crank_axial_N"]))
        left = internal_forces(body, written.point_data["displacement"].astype(float), told) - f
        reaction = 0.0
        if told.clamped:
            held = np.unique(body.big)
            reaction = float(np.abs(left[held].sum(axis=0)[:2] - crank).max() / largest)
            left[held] = 0.0
        plane = pv.read(folder / f"{name}.vtu").slice(normal="x", origin=(cut, 0, 0))
        stress = plane.integrate_data()["stress"][0]
        carried = np.array([stress[0], stress[3]])
        found = found.worst(
            Errors(
                max(float(np.abs(left).max() / np.abs(f).max()), reaction),
                float(np.abs(carried - (pin + beyond[:2])).max() / largest),
                0.0 if name in AT_REST else piston_error(load, told),
            )
        )
    return found


def _materials(points, tets, told, part):
    """Which material (n_tets,) an element has: the bushing's where it lies within its outer radius.

    An element with all corners on that radius may be of either part: the file says of which.
    """
    if not told.bushing:
        return np.zeros(len(tets), dtype=int)
    outer = told.small_radius + told.bushing
    away = np.hypot(points[:, 0] - told.length, points[:, 1])[tets[:, :4]] - outer
    between = (np.abs(away) < 1e-6 * outer).all(axis=1)
    return np.where(between, part[0], (away <= 1e-6 * outer).all(axis=1))
