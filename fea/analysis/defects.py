"""The largest defects that do not grow over a crank cycle, at every node and by region; and a given flaw.

The plane of a defect is that across the largest principal stress of the cycle; the stress across it over the
cycle gives amplitude and ratio.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fea.analysis.cycle.envelope import NOT_JUDGED, carried
from fea.analysis.cycle.screened import superposed
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.defect_figures import DefectFigures, DefectPlaceFigures, FlawFigures
from fea.analysis.figures import plain
from fea.analysis.flaw import Cycles, FlawJudge, placed
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.base.material import CrackMetal, Material
from fea.base.note import Note, assumptions, warning
from fea.judge.defect import ACCURATE, Position, StressCycle, largest_defect
from fea.machine.threads import side_by_side
from fea.rod.places import place_names
from fea.solid.stress import across, opened
from fea.study.defect_table import Flaw
from geometry.arrays import Floats, Ints, Mask, vector

_TOPIC = "defects"
# Of the degrees of a cycle, one in so many; of these, one in so many to find the plane. Between two of the
# former a peak of inertia forces is 0.03 % higher at most.
_EVERY, _COARSE = 3, 4
_BLOCK = 500  # nodes evaluated at once


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


def flaw_figures(
    flaw: Flaw, rod: PreparedRod, result: CycleResult, nodes: NodeCycles, rpm: float
) -> FlawFigures:
    """Judge a flaw, by default where the smallest defect of the surface grows; errors as `with_defects`."""
    points, order = rod.mesh.whole.points, np.lexsort((-nodes.cycle.amplitude, nodes.largest(rod)))
    first = order[(nodes.surface & nodes.counts & (nodes.cycle.highest > 0))[order]][0]
    at, outward, position = placed(flaw, rod.mesh.whole, np.array(flaw.at or points[nodes.node[first]]))
    near = int(np.linalg.norm(points[nodes.node] - at, axis=1).argmin())
    node, part = int(nodes.node[near]), int(nodes.part[near])
    error = float(nodes.error[near])
    judge = FlawJudge(rod, flaw, at, outward, position, node, part, error, *_metal(rod, part))
    duty = list[Cycles]()
    if rod.duty is not None and rod.life is not None and rod.life.operation is not None:
        entries = zip(rod.life.operation.entries, rod.duty.table.entries, strict=True)
        duty = [Cycles(each.weights, each.rate, entry.rpm) for each, entry in entries]
    return judge.figures(Cycles(result.weights, rod.engine.engine.cycles_per_hour * rpm, rpm), duty)
