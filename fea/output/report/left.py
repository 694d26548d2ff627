"""What a report needs of a run on disk."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from fea.analysis.figures import Summary
from fea.output.columns_csv import read_columns
from fea.output.json_file import read_summary
from fea.output.left_run import LeftRun, left_summary, read_run, read_vtu
from fea.output.report.bores import drawn_bores
from fea.output.report.reported import Arrays, Reported
from fea.study.study import Study, load_study
from geometry.invalid import InvalidValue
from mesh.errors import MeshError
from mesh.files.given import named_mesh
from mesh.tetmesh import TetMesh


def reported_left(folder: Path) -> tuple[Reported, LeftRun | None]:
    """Return what a report needs of a run, but for its motion and picture; and the run's fields.

    Raises
    ------
    InvalidValue
        It is not the folder of a run, or its files are damaged.
    """
    left_summary(folder)  # refuses what is not a run in words
    remedy = "Repeat the run: fea run study.toml."
    try:
        summary = read_summary(folder)
        forces, contact = _columns(folder / "loads.csv"), _columns(folder / "contact.csv")
    except (OSError, ValueError) as error:
        raise InvalidValue("RUN", str(folder), f"cannot be read ({error})", remedy) from error
    study = replace(load_study(folder / "study.toml"), name=summary.study)
    run = Reported(study=study, summary=summary, forces=forces, contact=contact)
    if not all((folder / f"{name}.vtu").is_file() for name in summary.results):
        return run, None  # of many speeds only the worst keep their fields
    left = read_run(folder)
    return _with_fields(run, left), left


def _with_fields(run: Reported, left: LeftRun) -> Reported:
    envelope = left.folder / "envelope.vtu"
    arrays: Arrays | None = None
    if envelope.is_file():
        _, fields = read_vtu(envelope)
        arrays = _plain(fields.point)
    mesh = _named(left.mesh, run.study)
    return replace(
        run,
        mesh=mesh,
        cases={name: _plain(fields.point) for name, fields in left.cases.items()},
        envelope=arrays,
        bores=drawn_bores(mesh, _length(run.summary)),
    )


def _plain(arrays: Arrays) -> Arrays:
    return {name: np.asarray(values, float) for name, values in arrays.items()}


def _named(mesh: TetMesh, study: Study) -> TetMesh:
    """The mesh with its bores named, if they are found."""
    rod = study.rod.dimensions
    try:
        return named_mesh(mesh, (None, None) if rod is None else (rod.big_end_bore, rod.small_end_bore))[0]
    except MeshError:
        return mesh


def _length(summary: Summary) -> float:
    return summary.rod.length_mm


def _columns(path: Path) -> Mapping[str, np.ndarray] | None:
    return read_columns(path) if path.is_file() else None
