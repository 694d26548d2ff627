"""The problem every program is given: one rod, one mesh, one load, as plain arrays in a file.

The symmetry cell of the León rod is meshed by gmsh to second order and reflected twice, so that the whole
rod of every program and the quarter of ours are the same mesh. The load is one peak of the crank cycle
at 6000 rpm (half-cosine bearing pressures and inertia) as nodal forces; six degrees of freedom at three
nodes are held.
"""

import json
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np

from fea.analysis.meshing import mesh_study
from fea.base.choices import Support
from fea.base.units import RPM
from fea.output.inp import write_inp
from fea.pins.model import Response
from fea.pins.prescribed import PressedPins
from fea.rod.meshed_rod import Bores, MeshedRod
from fea.solid.inertia import inertia
from fea.solid.supports import determinate_restraints
from fea.study.study import load_study
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from mesh.tetmesh import EDGES, MirroredMesh, TetMesh, reflect, unmirrored

STUDY, LOAD, SPEED = "leon-2001", "side", 6000.0
PLANES = (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)


@dataclass(frozen=True)
class Case:
    """The problem: the whole rod as arrays, and the cell that makes it."""

    cell: TetMesh
    whole: MirroredMesh
    forces: np.ndarray
    fixed: np.ndarray
    bores: Bores

    @property
    def dofs(self) -> int:
        return 3 * len(self.whole.mesh.points)


def make_case(path: Path, dofs: int) -> None:
    """Write the case whose whole rod has about `dofs` degrees of freedom."""
    found = cell_with(dofs)
    cell = found.cell
    whole = mirrored(cell)
    forces = nodal_forces(whole.mesh, found.bores).forces.symmetric
    fixed = restraints(whole.mesh)
    material = load_study(STUDY).material.material()
    write_inp(path.with_suffix(".inp"), whole.mesh, material, forces, fixed)
    facts = {"dofs": forces.size, "elements": len(whole.mesh.tets), "size_mm": found.meshing.size}
    path.with_suffix(".json").write_text(json.dumps(facts), encoding="utf-8")
    # What the peers read: no package of ours.
    np.savez(
        path,
        bores=astuple(found.bores),
        cell_points=cell.points,
        cell_tets=cell.tets,
        **{f"facets_{surface.name}": facets for surface, facets in cell.facets.items()},
        points=whole.mesh.points,
        tets=whole.mesh.tets,
        straight=straightened(whole.mesh),
        forces=forces,
        fixed=fixed,
        young=material.youngs_modulus,
        poisson=material.poissons_ratio,
    )


def read_case(path: Path) -> Case:
    """Read what `make_case` wrote."""
    with np.load(path) as data:
        facets = {
            Surface[name.removeprefix("facets_")]: data[name] for name in data if name.startswith("facets_")
        }
        cell = TetMesh(data["cell_points"], data["cell_tets"], facets)
        return Case(cell, mirrored(cell), data["forces"], data["fixed"], Bores(*data["bores"].tolist()))


def cell_with(dofs: int) -> MeshedRod:
    """The rod whose whole has `dofs` degrees of freedom to within two per cent, its cell a quarter."""
    size = 5.0 * (20_000 / dofs) ** 0.4
    slope = -2.5  # of log dofs against log size; measured from the second attempt on
    best: tuple[float, MeshedRod] | None = None
    last: tuple[float, float] | None = None
    for _ in range(8):
        meshed_rod = meshed(size)
        found = 3 * len(meshed_rod.whole.points)
        error = float(np.log(dofs / found))
        if best is None or abs(error) < abs(best[0]):
            best = error, meshed_rod
        if abs(error) < 0.02:
            break
        if last is not None and last[0] != size:
            measured = (np.log(found) - last[1]) / np.log(size / last[0])
            slope = float(np.clip(measured, -4, -1.5))
        last = size, float(np.log(found))
        size = round(size * float(np.exp(error / slope)), 4)
    assert best is not None
    return best[1]


def meshed(size: float) -> MeshedRod:
    """The rod at an element size (mm)."""
    study = load_study(STUDY)
    sized = replace(study, mesh=replace(study.mesh, size_mm=size))
    return mesh_study(sized)


def mirrored(cell: TetMesh) -> MirroredMesh:
    """The whole rod."""
    whole = unmirrored(cell)
    for plane in PLANES:
        whole = reflect(whole, plane)
    return whole


def nodal_forces(mesh: TetMesh, bores: Bores) -> Response:
    """Nodal forces of the load on a mesh, cut at its mirror planes or whole."""
    study = load_study(STUDY)
    weights = inertia(mesh, study.material.material().density)
    assert study.engine is not None
    engine = study.engine.engine(study.rod.length)
    peaks = CrankCycle(engine, weights.properties, study.engine.gas_model(engine), SPEED * RPM).peaks
    chosen = next(case for case in peaks.cases if case.name == LOAD)
    return PressedPins(mesh, bores, weights, Support.INERTIA_RELIEF, study.analysis.pressure).respond(
        chosen[None]
    )[0]


def restraints(mesh: TetMesh) -> np.ndarray:
    """Six degrees of freedom at three vertices; ours may hold others: only the rigid motion differs."""
    vertices = np.unique(mesh.tets[:, :4])
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    held[vertices] = determinate_restraints(TetMesh(mesh.points[vertices], np.empty((0, 4), dtype=np.int64)))
    return held


def straightened(mesh: TetMesh) -> np.ndarray:
    """The points with straight edges: for a program without curved elements."""
    points = mesh.points.copy()
    for column, (a, b) in enumerate(EDGES):
        points[mesh.tets[:, 4 + column]] = (points[mesh.tets[:, a]] + points[mesh.tets[:, b]]) / 2
    return points
