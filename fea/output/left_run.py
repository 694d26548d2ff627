"""Read what a run has left on disk."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.output.folder import SUMMARY
from fea.run.figures import SCHEMA
from geometry.errors import InvalidValue, require
from mesh.tetmesh import TetMesh

Array = npt.NDArray[Any]
STUDY = "study.toml"


@dataclass(frozen=True)
class Fields:
    """The arrays of a load case by their names: of the nodes and of the elements."""

    point: Mapping[str, Array]
    cell: Mapping[str, Array]


@dataclass(frozen=True)
class LeftRun:
    """A run on disk.

    Attributes
    ----------
    folder
        Its directory.
    summary
        What its `summary.json` holds.
    mesh
        The whole rod in its frame, mm, without named surfaces.
    cases
        Fields of each load case.
    """

    folder: Path
    summary: Mapping[str, Any]
    mesh: TetMesh
    cases: Mapping[str, Fields]

    @property
    def study(self) -> Path:
        """The study that the run resolved."""
        return self.folder / STUDY


def read_run(folder: Path) -> LeftRun:
    """Read the summary and the load cases of a run.

    Parameters
    ----------
    folder
        That `fea run` has written, of one speed.

    Raises
    ------
    InvalidValue
        It is not such a folder, or its fields are missing or damaged.
    """
    summary = left_summary(folder)
    names = list(summary.get("results", {}))
    missing = [name for name in names if not (folder / f"{name}.vtu").is_file()]
    rule = f"has no fields of {', '.join(missing)}: of many speeds only the worst ones keep theirs"
    require(bool(names) and not missing, "RUN", str(folder), rule, "Run this speed alone, and export that.")
    found = {name: read_vtu(folder / f"{name}.vtu") for name in names}
    mesh, _ = found[names[0]]
    return LeftRun(folder, summary, mesh, {name: fields for name, (_, fields) in found.items()})


def left_summary(folder: Path) -> dict[str, Any]:
    """Read the summary of a run; errors as for `read_run`, whether it has fields or not."""
    remedy = "Name the folder that fea run has written, such as results/leon-2001-6000rpm."
    require(folder.is_dir(), "RUN", str(folder), "is not a directory", remedy)
    speeds = sorted(place.parent.name for place in folder.glob(f"*/{SUMMARY}"))
    if speeds and not (folder / SUMMARY).is_file():
        rule = f"holds runs at several speeds: {', '.join(speeds[:8])}"
        raise InvalidValue("RUN", str(folder), rule, f"Name one of them, such as {folder / speeds[0]}.")
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidValue("RUN", str(folder), f"has no readable {SUMMARY} ({error})", remedy) from error
    ours = isinstance(summary, dict) and summary.get("schema") == SCHEMA and (folder / STUDY).is_file()
    require(ours, "RUN", str(folder), "is not the folder of a run of this version", remedy)
    return dict(summary)


def read_vtu(path: Path) -> tuple[TetMesh, Fields]:
    """Read the mesh and the arrays of a result file; errors as for `read_run`."""
    from meshio.vtu import read  # noqa: PLC0415 - only an export needs it

    try:
        found = read(str(path))
        (block,) = found.cells
        cells = {name: np.asarray(values[0]) for name, values in found.cell_data.items()}
        part = cells.get("part")
        mesh = TetMesh(
            np.asarray(found.points),
            np.asarray(block.data, dtype=np.int64),
            {},
            None if part is None else part.astype(np.int64),
        )
    except Exception as error:  # what meshio and its parsers raise is not documented
        rule = f"cannot be read ({type(error).__name__}: {error})"
        raise InvalidValue("RUN", str(path), rule, "Repeat the run: fea run study.toml.") from error
    return mesh, Fields({name: np.asarray(values) for name, values in found.point_data.items()}, cells)
