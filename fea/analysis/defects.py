"""The largest defects that do not grow over a crank cycle, at every node and by region; and a given flaw.

The plane of a defect is that across the largest principal stress of the cycle; the stress across it over the
cycle gives amplitude and ratio. A given flaw counts with its projection on that plane, in which it grows
straight into the depth. The stress along that line is that of the rod without the flaw.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fea.analysis.cycle.envelope import NOT_JUDGED, carried
from fea.analysis.cycle.screened import superposed
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.defect_figures import DefectFigures, DefectPlaceFigures, FlawFigures
from fea.analysis.figures import plain
from fea.analysis.gauges import FARTHEST, foot
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.base.material import CrackMetal, Material
from fea.base.note import Note, assumptions, warning
from fea.judge.crack import DEEPEST, grown, surface_intensity
from fea.judge.defect import ACCURATE, Position, StressCycle, area_root, flaw_limit, largest_defect
from fea.judge.history import rainflow
from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import CAP
from fea.machine.threads import side_by_side
from fea.rod.places import place_name, place_names
from fea.solid.assembly import shape_functions
from fea.solid.sharp_edges import FacetSurface
from fea.solid.stress import principal
from fea.study.defect_table import Flaw
from geometry.arrays import Floats, Ints, Mask, vector
from geometry.errors import require
from mesh.tetmesh import TetMesh

_TOPIC = "defects"
# Of the degrees of a cycle, one in so many; of these, one in so many to find the plane. Between two of the
# former a peak of inertia forces is 0.03 % higher at most.
_EVERY, _COARSE = 3, 4
_BLOCK = 500  # nodes evaluated at once
_ALONG = 16  # places along the line into the depth, closer together near the surface
# A flaw inside whose middle is nearer to the surface than this multiple of its height touches it. Least share
# of a flaw that counts where it lies along the stress.
_TOUCHES, _LEAST = 0.6, 1e-6


def with_defects(rod: PreparedRod, result: SpeedResult) -> SpeedResult:
    """Judge defects over the cycle of a speed: of steels of known hardness but linings, and a given flaw.

    Raises `InvalidValue`: the flaw is outside the rod, or how cracks grow is not known of its metal.
    """
    parts = [n for n, metal in enumerate(rod.materials) if metal.hardness is not None and not metal.lining]
    flaw, cycle = rod.study.defect.flaw, result.cycle
    if cycle is None or result.rpm is None or not (parts or flaw):
        return result
    with rod.clock(_TOPIC):
        nodes = NodeCycles.of(rod, result, cycle, parts or [0])
        size = nodes.largest(rod)
        places = list(_places(rod, nodes, size)) if parts else []
        found = None if flaw is None else flaw_figures(flaw, rod, cycle, nodes, result.rpm)
        field = np.full(len(rod.mesh.whole.points), np.nan)
        np.fmin.at(field, nodes.node, np.maximum(size, 1.0))
    worst = places[0] if places else None
    figures = DefectFigures(
        hardness_HV=rod.materials[0].hardness,
        smallest_um=None if worst is None else worst.smallest_um,
        at_mm=None if worst is None else worst.at_mm,
        region=None if worst is None else worst.region,
        regions=tuple(places),
        factor=None if found is None else found.factor,
        flaw=found,
    )
    field = np.nan_to_num(field, nan=NOT_JUDGED)
    notes = (*result.notes, *_notes(rod, found))
    return replace(result, notes=notes, defect=figures, largest_defect=field if parts else None)


def _notes(rod: PreparedRod, flaw: FlawFigures | None) -> Iterator[Note]:
    material, assumed = rod.materials[0], list[str]()
    if material.hardness is not None and material.hardness_estimated:
        assumed.append(
            f"{material.hardness:.0f} HV by the ultimate strength (ISO 18265; low-alloy steel, not "
            "case-hardened or decarburised; material.hardness_HV)"
        )
    if flaw is not None and (own := _metal(rod, 0)[1].assumed):
        assumed.append(f"{', '.join(own)} of the growth of cracks ([defect])")
    yield from assumptions(_TOPIC, assumed)
    if material.hardness is not None and material.hardness > ACCURATE:
        yield warning(f"above {ACCURATE:.0f} HV Murakami's model errs by more than 10 %", _TOPIC)


def _metal(rod: PreparedRod, part: int) -> tuple[Material, CrackMetal]:
    table = rod.study.part_material_table(list(rod.mesh.parts)[part])
    return rod.materials[part], rod.study.defect.metal(table)


def opened(stress: Floats) -> Floats:
    """Normals (n, 3) of the planes across the largest principal stress of histories (n, 6, n_instants)."""
    worst = principal(np.moveaxis(stress, 1, -1))[..., 0].argmax(axis=1)
    xx, yy, zz, xy, yz, xz = stress[np.arange(len(stress)), :, worst].T
    tensors = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), -1, 0)
    return np.asarray(np.linalg.eigh(tensors)[1][:, :, -1])


def across(stress: Floats, normals: Floats) -> Floats:
    """Stress (n, n_instants) across planes of normals (n, 3) or one for all, of histories as of `opened`."""
    x, y, z = np.broadcast_to(normals, (len(stress), 3)).T
    dyads = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z], axis=1)
    return np.asarray((dyads[:, None] @ stress)[:, 0])


@dataclass(frozen=True)
class NodeCycles:
    """Stress across the planes of defects at the nodes of parts, (n,): a node of two parts occurs twice."""

    node: Ints  #: of the whole rod
    part: Ints
    cycle: StressCycle
    error: Floats  #: of the amplitude, over it: at most the larger error of both ends
    surface: Mask  #: whether the node lies on a surface of the rod or of a part
    counts: Mask  #: whether it is not near a stress singularity

    @classmethod
    def of(cls, rod: PreparedRod, speed: SpeedResult, result: CycleResult, parts: list[int]) -> "NodeCycles":
        """Evaluate every node of some parts."""
        ends, count = np.concatenate([_ends(rod, result, part) for part in parts], axis=1), len(result.counts)
        rows = np.flatnonzero(~np.isnan(ends[0]))
        node, cycle = rows % count, StressCycle(*ends[:, rows])
        errors = [case.von_mises_error for case in speed.cases.values() if case.load.in_cycle]
        error = np.max(errors, axis=0)[node] / cycle.amplitude
        surface = np.isin(node, np.concatenate(list(rod.mesh.whole.facets.values())))
        return cls(node, np.array(parts)[rows // count], cycle, error, surface, result.counts[node])

    def largest(self, rod: PreparedRod, off: float = 0.0) -> Floats:
        """√area (n,), µm, that does not grow, with stresses off by a multiple of their error."""
        size, factor = np.full(len(self.node), np.nan), np.maximum(1 + off * self.error, 0.0)
        for part in np.unique(self.part).tolist():
            for position in (Position.SURFACE, Position.INSIDE):
                rows = (self.part == part) & (self.surface == (position is Position.SURFACE))
                size[rows] = largest_defect(self.cycle.some(rows, factor), *_metal(rod, part), position)
        return size


def _ends(rod: PreparedRod, result: CycleResult, part: int) -> Floats:
    """Highest and lowest stress (2, n_nodes) across the planes of a part, NaN elsewhere."""
    units, weights = rod.cycle.units, result.weights.at(slice(None, None, _EVERY))
    own = units.parts[part]

    def block(start: int) -> Floats:
        rows = slice(start, start + _BLOCK)
        pair = own.even[rows][..., : len(weights.even)], own.odd[rows][..., : len(weights.odd)]
        stress = np.asarray(superposed(*pair, units.sides, weights), np.float64)
        history = across(stress, opened(stress[..., ::_COARSE]))
        return np.reshape([history.max(axis=1), history.min(axis=1)], (2, len(units.sides), -1))

    ends = np.concatenate(side_by_side(block, range(0, len(own.nodes), _BLOCK)), axis=2)
    return np.stack([carried(own, list(sides), rod.mesh.mirrored) for sides in ends])


def _places(rod: PreparedRod, found: NodeCycles, size: Floats) -> Iterator[DefectPlaceFigures]:
    """Yield the smallest defect of every region, the worst first."""
    low, high, cycle = found.largest(rod, 1.0), found.largest(rod, -1.0), found.cycle
    rows = np.flatnonzero(found.counts & (rod.mesh.mirrored.sign[found.node, 2] > 0))
    rows = rows[np.lexsort((-cycle.amplitude[rows], size[rows]))]
    regions: dict[str, list[int]] = {}
    for row, name in zip(rows.tolist(), place_names(rod.mesh, found.node[rows]), strict=True):
        regions.setdefault(name, []).append(row)
    for name, own in regions.items():
        first = own[0]
        yield DefectPlaceFigures(
            region=name,
            smallest_um=float(size[first]),
            smallest_um_low=float(low[own].min()),
            smallest_um_high=float(high[first]),
            at_mm=vector(rod.mesh.whole.points[found.node[first]]),
            amplitude_MPa=float(cycle.amplitude[first]),
            stress_ratio=plain(cycle.ratio[first]),
        )


def _placed(flaw: Flaw, mesh: TetMesh, at: Floats) -> tuple[Floats, Floats, Position]:
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


def flaw_figures(
    flaw: Flaw, rod: PreparedRod, result: CycleResult, nodes: NodeCycles, rpm: float
) -> FlawFigures:
    """Judge a flaw, by default where the smallest defect of the surface grows; errors as `with_defects`."""
    points, order = rod.mesh.whole.points, np.lexsort((-nodes.cycle.amplitude, nodes.largest(rod)))
    first = order[(nodes.surface & nodes.counts & (nodes.cycle.highest > 0))[order]][0]
    at, outward, position = _placed(flaw, rod.mesh.whole, np.array(flaw.at or points[nodes.node[first]]))
    near = int(np.linalg.norm(points[nodes.node] - at, axis=1).argmin())
    part = int(nodes.part[near])
    stress, (material, metal) = _histories(rod, result, at[None], part), _metal(rod, part)
    (normal,), given = opened(stress), rod.study.defect.normal
    history = across(stress, normal)
    cycle = StressCycle(history.max(axis=1), history.min(axis=1))
    share = 1.0 if given is None else float(abs(np.array(given) @ normal) / np.linalg.norm(given))
    depth, half = (max(share, _LEAST) ** 0.5 * size for size in (flaw.depth, flaw.length / 2))
    criterion, (bears,) = flaw_limit((depth, half), cycle, material, metal, position)
    least = min(float(bears / cycle.amplitude[0]), CAP) if cycle.highest[0] > 0 else CAP
    factor = SafetyFactor.of_stress(least, 100 * float(nodes.error[near]), mode="crack growth")
    figures = FlawFigures(
        depth_mm=flaw.depth,
        length_mm=flaw.length,
        at_mm=vector(at),
        where=place_name(rod.mesh, int(nodes.node[near])),
        position=position.value,
        area_root_um=area_root(depth, half),
        amplitude_MPa=float(cycle.amplitude[0]),
        stress_ratio=plain(cycle.ratio[0]),
        criterion=criterion,
        factor=factor,
    )
    if factor.low >= 1 or position is not Position.SURFACE:
        return figures
    ahead = (outward @ normal) * normal - outward
    ahead /= np.linalg.norm(ahead)
    facets = np.concatenate(list(rod.mesh.whole.facets.values()))
    surface = FacetSurface(points, facets, np.zeros_like(facets[:, 0]), np.zeros((0, 3, 3)))
    wall = float(surface.depth(at[None], ahead[None])[0])
    if not np.isfinite(wall):  # along a surface
        return figures
    along = DEEPEST * wall * np.linspace(0.0, 1.0, _ALONG)[:, None] ** 2 * ahead
    line = across(_histories(rod, result, at + along, part), normal)
    stresses = (
        partial(np.interp, xp=np.linalg.norm(along, axis=1), fp=line[:, instant])
        for instant in (line[0].argmax(), line[0].argmin())
    )
    high, low = (partial(surface_intensity, wall=wall, stress=stress) for stress in stresses)
    cycles, depths, breaks = grown((depth, half), DEEPEST * wall, high, low, metal)
    # Smaller ranges count as a share of the largest; only tension opens a crack.
    _, ranges = rainflow(np.maximum(history[0], 0.0))
    an_hour = rod.engine.engine.cycles_per_hour * rpm * ((ranges / ranges.max()) ** metal.exponent).sum()
    service = (rod.study.defect.service_hours or np.inf) * an_hour
    return replace(
        figures,
        hours=float(cycles[-1] / an_hour),
        ends="fracture" if breaks else f"{100 * DEEPEST:.0f} % of the wall",
        depth_after_service_mm=float(np.interp(service, cycles, depths)) if service < cycles[-1] else None,
    )


def _histories(rod: PreparedRod, result: CycleResult, places: Floats, part: int) -> Floats:
    """Stress (n, 6, n_instants), MPa, of a part at places (n, 3) in it, at every degree."""
    mesh = rod.mesh.whole
    tets = mesh.tets if mesh.part is None else mesh.tets[mesh.part == part]
    corners, found = mesh.points[tets[:, :4]], list[Floats]()
    inverse = np.linalg.inv(np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2))
    for place in places:
        share = np.einsum("nij,nj->ni", inverse, place - corners[:, 0])
        best = int(np.minimum(share.min(axis=1), 1 - share.sum(axis=1)).argmax())
        local, nodes = share[best], tets[best]
        for _ in range(4):  # for curved edges
            shape = shape_functions(len(nodes), local[:, None])[0][0]
            local = local + inverse[best] @ (place - shape @ mesh.points[nodes])
        of_nodes = ((int(node), part) for node in nodes)
        every = spots(of_nodes, rod.cycle.units, result.weights, rod.mesh.mirrored)
        found.append(np.einsum("k,kct->ct", shape, np.stack([spot.stress for spot in every])))
    return np.stack(found)
