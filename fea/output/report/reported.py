"""What a report is made from, wherever the run is: in memory or on disk."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.output.columns_csv import read_columns
from fea.output.json_file import read_summary
from fea.output.left_run import LeftRun, left_summary, read_run, read_vtu
from fea.output.report.bores import DrawnBore, drawn_bores
from fea.run.figures import EnvelopeFigures, Summary
from fea.run.motion import Motion
from fea.study.study import Study, load_study
from geometry.errors import InvalidValue
from mesh.files.given import named_mesh
from mesh.tetmesh import MeshError, TetMesh

Array = npt.NDArray[Any]
Arrays = Mapping[str, Array]


@dataclass(frozen=True, kw_only=True)
class Reported:
    """A run as a report needs it.

    Attributes
    ----------
    study, summary
        What was asked, and the figures found.
    mesh
        The whole rod, mm; None where the run has no fields.
    cases
        Nodal arrays of each load case, by their names in its VTU file.
    envelope
        Those of the whole crank cycle; None without it.
    forces
        The columns of ``loads.csv``; None where forces are given.
    contact
        The columns of ``contact.csv``; None where there is no contact over the cycle.
    bores
        The two bores, the big end's first; empty where they were not found.
    motion
        The surface at every crank angle; None where it was not worked out.
    without_motion
        Why not, where the cycle was analysed; empty otherwise.
    picture
        A still picture (PNG) of the worst load case; None where this machine cannot draw.
    """

    study: Study
    summary: Summary
    mesh: TetMesh | None = None
    cases: Mapping[str, Arrays] = field(default_factory=dict)
    envelope: Arrays | None = None
    forces: Arrays | None = None
    contact: Arrays | None = None
    bores: tuple[DrawnBore, ...] = ()
    motion: Motion | None = None
    without_motion: str = ""
    picture: bytes | None = None

    @property
    def cycle(self) -> EnvelopeFigures | None:
        """The figures of the whole cycle with its histories, where there are any."""
        found = self.summary.envelope
        return found if isinstance(found, EnvelopeFigures) else None


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
