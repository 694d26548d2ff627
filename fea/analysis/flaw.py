"""A given flaw: whether it grows over the crank cycle of a speed, or over a duty, and how long it lasts.

It counts with its projection on the plane across the largest principal stress, of a duty that of all its
entries, and grows straight into the depth in it. The stress along that line is that of the rod without it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.defect_figures import FlawFigures, FlawLifeFigures
from fea.analysis.figures import plain
from fea.analysis.gauges import FARTHEST, foot
from fea.analysis.prepared_rod import PreparedRod
from fea.base.material import CrackMetal, Material
from fea.judge.crack import DEEPEST, CrackLoad, grown_flaw
from fea.judge.defect import Position, StressCycle, area_root, flaw_limit
from fea.judge.history import rainflow
from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import CAP
from fea.pins.model import Weights
from fea.rod.places import place_name
from fea.solid.assembly import shape_functions
from fea.solid.sharp_edges import FacetSurface
from fea.solid.stress import across, opened
from fea.study.defect_table import Flaw
from geometry.arrays import Floats, Ints, vector
from geometry.errors import require
from mesh.tetmesh import TetMesh

_ALONG = 16  # places along the line into the depth, closer together near the surface
# A flaw inside whose middle is nearer to the surface than this multiple of its height touches it. Least share
# of a flaw that counts where it lies along the stress; and of the line into the depth that the plane holds.
_TOUCHES, _LEAST, _ALONG_SURFACE = 0.6, 1e-6, 1e-3


class Cycles(NamedTuple):
    """Crank cycles that are alike."""

    weights: Weights  #: of the unit solutions over one
    rate: float  #: of them, an hour
    rpm: float


def placed(flaw: Flaw, mesh: TetMesh, at: Floats) -> tuple[Floats, Floats, Position]:
    """Place (3,) of a flaw, by default the nearest on the surface, the normal (3,) there, and where it lies.

    Raises `InvalidValue`: it is outside of the rod.
    """
    middle, plane, facet, _ = foot(mesh, at, np.concatenate(list(mesh.facets.values())))
    corners = mesh.points[facet[:3]]
    outward = (np.eye(3) - plane) @ np.cross(corners[1] - corners[0], corners[2] - corners[0])
    outward /= np.linalg.norm(outward)
    below, away = float((middle - at) @ outward), float(np.linalg.norm(middle - at))
    rule = f"is {away:.3g} mm outside of the rod, and at most {FARTHEST:g} mm are allowed"
    near = f"Near it is {np.round(middle, 2).tolist()}."
    require(below > 0 or away <= FARTHEST, "defect.size", f"@{at.tolist()}", rule, near)
    if below < flaw.depth / 2:
        return middle, outward, Position.SURFACE
    return at, outward, Position.TOUCHING if below < _TOUCHES * flaw.depth else Position.INSIDE


@dataclass(frozen=True)
class FlawJudge:
    """Judges a flaw of a rod."""

    rod: PreparedRod
    flaw: Flaw
    at: Floats  #: (3,) mm, on the surface or inside
    outward: Floats  #: (3,) normal of the surface nearest to it
    position: Position
    node: int  #: of the whole rod, near it
    part: int
    error: float  #: of the amplitude of the stress there, over it
    material: Material
    metal: CrackMetal

    def figures(self, cycles: Cycles, duty: Sequence[Cycles] = ()) -> FlawFigures:
        """Return the figures over the cycle of a speed, and over the cycles of a duty."""
        return FlawFigures(
            **vars(self._over([cycles])),
            depth_mm=self.flaw.depth,
            length_mm=self.flaw.length,
            at_mm=vector(self.at),
            where=place_name(self.rod.mesh, self.node),
            position=self.position.value,
            duty=self._over(duty) if duty else None,
        )

    def _over(self, cycles: Sequence[Cycles]) -> FlawLifeFigures:
        """Return the worst limit, and the growth, over cycles of several kinds."""
        weights = joined(*(each.weights for each in cycles))
        begin: Ints = np.cumsum([0, *(each.weights.even.shape[1] for each in cycles)])[:-1]
        stress = self._histories(self.at[None], weights)
        (normal,), given = opened(stress), self.rod.study.defect.normal
        histories = np.split(across(stress, normal)[0], begin[1:])
        cycle = StressCycle(*np.array([[each.max(), each.min()] for each in histories]).T)
        share = 1.0 if given is None else float(abs(np.array(given) @ normal) / np.linalg.norm(given))
        size = max(share, _LEAST) ** 0.5 * self.flaw.depth, max(share, _LEAST) ** 0.5 * self.flaw.length / 2
        criterion, bears = flaw_limit(size, cycle, self.material, self.metal, self.position)
        least = np.where(cycle.highest > 0, np.minimum(bears / cycle.amplitude, CAP), CAP)
        worst = int(least.argmin())
        factor = SafetyFactor.of_stress(float(least[worst]), 100 * self.error, mode="crack growth")
        found = FlawLifeFigures(
            rpm=cycles[worst].rpm,
            normal=vector(normal),
            counted_percent=100 * share,
            area_root_um=area_root(*size),
            amplitude_MPa=float(cycle.amplitude[worst]),
            stress_ratio=plain(cycle.ratio[worst]),
            criterion=criterion,
            factor=factor,
        )
        line = None if factor.low >= 1 else self._line(normal)
        if line is None:
            return found
        reached: Ints = np.array([[each.argmax(), each.argmin()] for each in histories])
        instants = (begin[:, None] + reached).ravel()
        places, depths, below, wall = line
        along = partial(np.interp, xp=depths)
        pairs = across(self._histories(places, weights.at(instants)), normal).T
        rates = [each.rate * self._share(own) for each, own in zip(cycles, histories, strict=True)]
        loads = [
            CrackLoad(partial(along, fp=high), partial(along, fp=low), rate)
            for high, low, rate in zip(pairs[::2], pairs[1::2], rates, strict=True)
            if rate > 0
        ]
        growth = grown_flaw(size, below, wall, loads, self.metal)
        service, last = self.rod.study.defect.service_hours or np.inf, float(growth.hours[-1])
        by_then = float(np.interp(service, growth.hours, growth.sizes[:, 0]))
        return replace(
            found,
            hours=last,
            ends="fracture" if growth.breaks else f"{100 * DEEPEST:.0f} % of the wall",
            hours_to_surface=growth.surfaces,
            depth_after_service_mm=by_then if service < last else None,
        )

    def _share(self, history: Floats) -> float:
        """Effect of a cycle over that of its largest range, as only tension opens a crack."""
        _, ranges = rainflow(np.maximum(history, 0.0))
        largest = ranges.max(initial=0.0)
        return float(((ranges / largest) ** self.metal.exponent).sum()) if largest > 0 else 0.0

    def _line(self, normal: Floats) -> tuple[Floats, Floats, float, float] | None:
        """Line into the depth, in the plane of a normal; None along a surface.

        Places (n, 3) and their depths (n,), the depth of the flaw and that of the wall, mm.
        """
        mesh, at, outward = self.rod.mesh.whole, self.at, self.outward
        ahead = (outward @ normal) * normal - outward
        if (length := np.linalg.norm(ahead)) < _ALONG_SURFACE:
            return None
        ahead /= length
        facets = np.concatenate(list(mesh.facets.values()))
        surface = FacetSurface(mesh.points, facets, np.zeros_like(facets[:, 0]), np.zeros((0, 3, 3)))
        below, beyond = 0.0, float(surface.depth(at[None], ahead[None])[0])
        if self.position is not Position.SURFACE:
            below = float(surface.depth(at[None], -ahead[None])[0])
        if not np.isfinite(below + beyond):
            return None
        if below > beyond:
            below, beyond, ahead = beyond, below, -ahead
        depths = DEEPEST * (below + beyond) * np.linspace(0.0, 1.0, _ALONG) ** 2
        return at + (depths - below)[:, None] * ahead, depths, below, below + beyond

    def _histories(self, places: Floats, weights: Weights) -> Floats:
        """Stress (n, 6, n_instants), MPa, of the part at places (n, 3) in it."""
        mesh, part, found = self.rod.mesh.whole, self.part, list[Floats]()
        tets = mesh.tets if mesh.part is None else mesh.tets[mesh.part == part]
        corners = mesh.points[tets[:, :4]]
        inverse = np.linalg.inv(np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2))
        for place in places:
            share = np.einsum("nij,nj->ni", inverse, place - corners[:, 0])
            best = int(np.minimum(share.min(axis=1), 1 - share.sum(axis=1)).argmax())
            local, nodes = share[best], tets[best]
            for _ in range(4):  # for curved edges
                shape = shape_functions(len(nodes), local[:, None])[0][0]
                local = local + inverse[best] @ (place - shape @ mesh.points[nodes])
            of_nodes = ((int(node), part) for node in nodes)
            every = spots(of_nodes, self.rod.cycle.units, weights, self.rod.mesh.mirrored)
            found.append(np.einsum("k,kct->ct", shape, np.stack([spot.stress for spot in every])))
        return np.stack(found)
