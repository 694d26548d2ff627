"""A run on disk: what `fea run` has written."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fea.analysis.film import FilmResult
from fea.analysis.motion import Motion
from fea.analysis.result import Array, Arrays, DrawnBore, RunResult, WhatIf, drawn_bores
from fea.analysis.summary_figures import Summary
from fea.output.folder import read_columns
from fea.output.json_file import AGAIN, STUDY, run_summary
from fea.output.vtu import cell_name, point_name
from fea.study.study import Study, load_study
from geometry.errors import InvalidValue, require
from mesh.files.given import named_mesh
from mesh.tetmesh import MeshError, TetMesh


class FileFields(NamedTuple):
    """Content of a result file: the mesh without named surfaces, and the arrays of its nodes and elements."""

    mesh: TetMesh
    point: Mapping[str, Array]
    cell: Mapping[str, Array]


@dataclass(frozen=True)
class StoredRun:
    """A stored run with the names of `RunResult`; what is read late and damaged raises `InvalidValue`."""

    folder: Path
    study: Study
    summary: Summary
    files: Mapping[str, FileFields]  #: of each load case; none where one is missing
    motion: Motion | None = None
    without_motion: str = ""
    films: tuple[FilmResult, ...] = ()
    what_if: WhatIf = field(default_factory=WhatIf)

    @property
    def mesh(self) -> TetMesh:
        """The whole rod in its frame, mm, without named surfaces."""
        return next(iter(self.files.values())).mesh

    @cached_property
    def fields(self) -> Mapping[str, Arrays]:
        """Nodal arrays of each load case."""
        return {name: _floats(file.point) for name, file in self.files.items()}

    @cached_property
    def envelope(self) -> Arrays | None:
        """Nodal arrays of the whole crank cycle."""
        path = self.folder / "envelope.vtu"
        return _floats(read_vtu(path).point) if path.is_file() else None

    def _columns(self, name: str) -> Arrays | None:
        path = self.folder / name
        try:
            return read_columns(path) if path.is_file() else None
        except (OSError, ValueError) as error:
            raise InvalidValue("RUN", str(self.folder), f"cannot be read ({error})", AGAIN) from error

    forces = cached_property(partial(_columns, name="loads.csv"))
    film = cached_property(partial(_columns, name="film.csv"))
    contact = cached_property(partial(_columns, name="contact.csv"))
    log = cached_property(partial(_columns, name="log.csv"))

    @property
    def bores(self) -> tuple[DrawnBore, ...]:
        """The bores, where they are found in the mesh."""
        rod = self.study.rod.dimensions
        known = (None, None) if rod is None else (rod.big_end_bore, rod.small_end_bore)
        try:
            return drawn_bores(named_mesh(self.mesh, known)[0], self.summary.rod.length_mm)
        except MeshError:
            return ()

    def require_fields(self) -> None:
        """Refuse a run without fields."""
        missing = [name for name in self.summary.results if not (self.folder / f"{name}.vtu").is_file()]
        rule = f"has no fields of {', '.join(missing)}: of many speeds only the worst ones keep theirs"
        require(bool(self.files), "RUN", str(self.folder), rule, "Run this speed alone, and export that.")


# A run at one speed, computed or stored.
Run = RunResult | StoredRun


def read_run(folder: Path) -> StoredRun:
    """Read a run of one speed of `fea run`. Raises `InvalidValue`: it is none, or its files are damaged."""
    found = read_figures(folder)
    paths = {name: folder / f"{name}.vtu" for name in found.summary.results}
    complete = all(path.is_file() for path in paths.values())
    files = {name: read_vtu(path) for name, path in paths.items()} if complete else {}
    return replace(found, files=files)


def read_figures(folder: Path) -> StoredRun:
    """Read a run at one speed without its fields, which takes no time; errors as for `read_run`."""
    summary = run_summary(folder)
    return StoredRun(folder, replace(load_study(folder / STUDY), name=summary.study), summary, {})


def read_vtu(path: Path) -> FileFields:
    """Read the mesh and the arrays of a result file; errors as for `read_run`."""
    from meshio.vtu import read  # noqa: PLC0415 - only a stored run needs it

    try:
        content = read(str(path))
        (block,) = content.cells
        cells = {cell_name(name): np.asarray(values[0]) for name, values in content.cell_data.items()}
        part = cells.get("part")
        mesh = TetMesh(
            np.asarray(content.points),
            np.asarray(block.data, dtype=np.int64),
            {},
            None if part is None else part.astype(np.int64),
        )
    except Exception as error:  # what meshio and its parsers raise is not documented
        rule = f"cannot be read ({type(error).__name__}: {error})"
        raise InvalidValue("RUN", str(path), rule, AGAIN) from error
    points = {point_name(name): np.asarray(values) for name, values in content.point_data.items()}
    return FileFields(mesh, points, cells)


def _floats(arrays: Mapping[str, Any]) -> Arrays:
    return {name: np.asarray(values, float) for name, values in arrays.items()}
