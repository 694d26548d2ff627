"""The line of the permanent set: loads that leave a rod deformed beyond its limits, those of ``[overload]``.

Plastic flow takes long to follow, so that the line is found on a few rays and straight between them. Along a
ray all loads grow together: those at first yield are solved once, and flow is followed at multiples of them,
over a few turns of the peak cases without hardening. Loads are not raised by what the stress at the surface
exceeds that inside the elements: a set that counts is one of whole sections.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fea.analysis.collapse import overload_table
from fea.analysis.flowing_rod import FlowingRod, FollowedFlow, flowing_under
from fea.analysis.permanent_set import judged, permanent_set
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.survival import SET_WORDS
from fea.apps.limits.engine import ScaledEngine
from fea.apps.limits.factors import FailureMode, ModeFactor
from fea.apps.limits.limit_map import LimitMap, LimitPoint, few
from fea.output.flow_statements import set_limit
from fea.plastic.cycling import PlasticAnswer

_RAYS = 4
# Turns that are followed: after so many it is known whether a rod ratchets.
_TURNS = 4
# The load is sought up to so many times that at which flow begins, by so many halvings of the logarithm: to
# 2 % of the load.
_MOST, _HALVINGS = 2.0, 5


def with_set(
    rod: PreparedRod, engine: ScaledEngine, of_rays: LimitMap, required: float, show: Callable[[str], None]
) -> LimitMap:
    """Return the map with the line of the permanent set; without one where the rod never yields."""
    axes, angles = of_rays.axes, of_rays.angles
    yielding = of_rays.loads.get(FailureMode.YIELD, np.full(angles.size, np.inf))
    rays = np.flatnonzero(np.isfinite(yielding))
    if not rays.size:
        return of_rays
    some, found = few(rays, _RAYS), dict[int, ModeFactor]()
    loads = np.full(some.size, np.inf)
    for number, ray in enumerate(some.tolist()):
        show(f"permanent set on ray {number + 1} of {some.size}")
        peaks = engine.cycle(*axes.point(float(angles[ray]), float(yielding[ray]))).peaks.cases
        cases = peaks[peaks.in_cycle]
        flowing = flowing_under(rod, cases[np.argsort(cases.crank_angle)])
        multiple, what = _multiple(flowing, overload_table(rod).limits)
        loads[number] = multiple * yielding[ray] / required
        found[ray] = ModeFactor(required, what=what)
    between = LimitMap(axes, angles[some], {FailureMode.SET: loads}, {})
    every = np.array(
        [
            float(between.factors(*map(np.asarray, axes.point(float(angle), 1.0)))[FailureMode.SET])
            for angle in angles
        ]
    )

    def limit(ray: int) -> LimitPoint | None:
        if not math.isfinite(every[ray]):
            return None
        point = axes.point(float(angles[ray]), float(every[ray]))
        near = found[min(found, key=lambda other: abs(other - ray))]
        return LimitPoint(FailureMode.SET, *point, engine.peak(*point), near, -1.0, ray not in found)

    return replace(
        of_rays,
        loads={**of_rays.loads, FailureMode.SET: every},
        limits={**of_rays.limits, FailureMode.SET: tuple(map(limit, range(angles.size)))},
    )


def _multiple(flowing: FlowingRod, limits: Mapping[str, float]) -> tuple[float, str]:
    """Multiple of the loads from which what is left exceeds a limit, which one; infinite where none is."""
    strength, what = flowing.rod.materials[0].flow_strength, ""
    low = strength / float(flowing.nodal.max())
    high = _MOST * low
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        if exceeded := _exceeded(flowing.followed(strength, middle, _TURNS), limits):
            high, what = middle, exceeded
        else:
            low = middle
    return (math.sqrt(low * high), what) if what else (math.inf, "")


def _exceeded(followed: FollowedFlow, limits: Mapping[str, float]) -> str:
    """Return what of the set exceeds its limit, in words; empty where nothing does."""
    answer, mesh = followed.flow.answer, followed.rod.rod.mesh
    if answer is PlasticAnswer.COLLAPSES:
        return "it gives way plastically"
    left = permanent_set(mesh.whole, mesh.bores.rod_length, followed.whole)
    for name in judged(left, limits).exceeded:
        return f"{SET_WORDS[name]} more than {set_limit(name, limits[name])}"
    return "more in every turn" if answer is PlasticAnswer.RATCHETS else ""
