"""The job behind `fea export`: a run in the format of another program."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fea.analysis.prepare import PreparedRod
from fea.apps.report_run import prepared_again, require_same_loads
from fea.base.note import Note, warning
from fea.output.inp import Step, write_deck
from fea.output.mesh_formats import FORMATS, write_mesh
from fea.output.stored_run import StoredRun, read_run
from fea.output.target import require_target
from fea.solid.supports import clamped, determinate_restraints
from geometry.errors import require
from geometry.surfaces import Surface
from loads.instants import Instants
from mesh.files.given import named_mesh
from mesh.tetmesh import MeshError

SUFFIXES = (".inp", *FORMATS)


@dataclass(frozen=True)
class Exported:
    """What was written."""

    files: tuple[Path, ...]  #: where
    notes: tuple[Note, ...]  #: what the format does not carry, and what a reader must know of the file


def export_run(folder: Path, file: Path) -> Exported:
    """Write the mesh of a run at one speed with its loads or its results.

    The suffix chooses the format: ``.inp`` is a deck of all load cases for CalculiX and Abaqus, the others
    hold the mesh with the results as far as the format carries them. Raises `InvalidValue`: the folder is not
    that of a run, or the file cannot be written there; `MeshError`: the bores of the run's mesh were not
    found, which a deck needs; `StorageError`: the disk, a permission or a missing library prevents writing.
    """
    require_target("FILE", file, SUFFIXES)
    inside = file.resolve().parent == folder.resolve()
    rule = "is inside the folder of the run, whose files are never mixed with others"
    require(not inside, "FILE", str(file), rule, "Name a file in another folder.")
    run = read_run(folder)
    run.require_fields()
    return _deck(run, file) if file.suffix.lower() == ".inp" else _results(run, file)


def _results(run: StoredRun, file: Path) -> Exported:
    form = FORMATS[file.suffix.lower()]
    mesh, notes = run.mesh, []
    if form.surfaces:
        try:
            mesh, _ = named_mesh(run.mesh, (None, None))
        except MeshError as error:
            notes.append(f"the surfaces have no names, because {error}")
    stored = run.files.items()
    points = {f"{case}_{name}": values for case, file in stored for name, values in file.point.items()}
    cells = {f"{case}_{name}": values for case, file in stored for name, values in file.cell.items()}
    files = write_mesh(file, mesh, points, cells)
    if form.without:
        notes.append(f"{file.suffix.lower()} does not carry {form.without}")
    return Exported(files, tuple(map(warning, notes)))


def _deck(run: StoredRun, file: Path) -> Exported:
    rod, rpm = prepared_again(run), run.summary.rpm
    cases = require_same_loads(run, rod.loading.at(rod.mass, rpm).cases)
    steps = [_step(run, rod, case) for case in cases.values()]
    materials = dict(zip(rod.mesh.parts, rod.materials, strict=True))
    heading = [f"{run.summary.title}: one step per load case"]
    write_deck(file, rod.mesh.whole, materials, steps, heading)
    notes = [
        "pressures and inertia are nodal forces (*CLOAD); three nodes are held at the run's displacement, so "
        "that displacements agree"
        if not rod.clamped
        else "pressures and inertia are nodal forces (*CLOAD); the big-end bore is held"
    ]
    if rod.structure.soft:
        notes.append(
            "a part is nearly incompressible: the run solves it with mixed elements, which have a pressure "
            "field that C3D10 lack, so that results of the deck differ there"
        )
    return Exported((file,), tuple(map(warning, notes)))


def _step(run: StoredRun, rod: PreparedRod, case: Instants) -> Step:
    mesh = rod.mesh.whole
    fixed = clamped(mesh, Surface.BIG_END_BORE) if rod.clamped else determinate_restraints(mesh)
    displacement = run.files[case.name].point["displacement"].astype(float)
    angle = run.summary.loads[case.name].crank_deg
    title = case.name if angle is None else f"{case.name}, crank angle {angle:g} degrees"
    (response,) = rod.pins.respond(case[None])
    return Step(title, response.forces.symmetric, fixed, np.where(fixed, displacement, 0.0))
