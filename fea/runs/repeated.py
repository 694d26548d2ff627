"""The rod of a run on disk, ready to be loaded as the run was."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from fea.analysis.prepare import PreparedRod, prepare
from fea.output.left_run import LeftRun
from fea.rod.given import PART, meshed_rod
from fea.study.contact_table import PINS
from fea.study.study import Study
from geometry.invalid import InvalidValue, require
from loads.cases import LoadCase
from mesh.files.given import named_mesh

# Largest relative difference between the forces of a run and those worked out again.
_SAME_FORCES = 1e-6
_OF_ASSEMBLY = (
    "Export its results as .vtu or .med instead of a deck; fea run study.toml --cycle --report writes a "
    "report with its cycle."
)


def prepared_again(run: LeftRun, study: Study) -> PreparedRod:
    """Prepare the study of a run on the run's own mesh.

    Raises
    ------
    InvalidValue
        The rod is an assembly: a run's mesh does not say where its parts touch.
    MeshError
        The bores of the run's mesh were not found.
    """
    rule = "holds a rod of separate parts, and its mesh does not say where they touch"
    require(study.assembly is None, "RUN", str(run.folder), rule, _OF_ASSEMBLY)
    dimensions = study.rod.dimensions
    known = (None, None) if dimensions is None else (dimensions.big_end_bore, dimensions.small_end_bore)
    mesh, bores = named_mesh(run.mesh, known)
    names = _part_names(study, 1 if mesh.part is None else int(mesh.part.max()) + 1)
    return prepare(study, mesh=meshed_rod(mesh, bores, names))


def _part_names(study: Study, count: int) -> Sequence[str]:
    """Names of the parts in the order of their numbers."""
    if count == 1:
        return [next(iter(sorted(study.part_material.keys() - PINS)), PART)]
    if study.rod.cad is None:
        return ["rod", "bushing"]
    from fea.analysis.study_forces import drawn_solid  # noqa: PLC0415 - only several parts need their solid

    return [part.name for part in drawn_solid(study.rod).parts]


def require_same_loads(run: LeftRun, cases: Iterable[LoadCase]) -> Mapping[str, LoadCase]:
    """Return load cases by their names, if their loads are those of the run.

    Raises
    ------
    InvalidValue
        They are not.
    """
    found = {case.name: case for case in cases}
    remedy = "Repeat the run: fea run study.toml."
    told = run.summary["loads"]
    rule = f"holds the cases {', '.join(told)}, but its study gives {', '.join(found)}"
    require(set(told) == set(found), "RUN", str(run.folder), rule, remedy)
    for name, case in found.items():
        then = np.array([told[name][key] for key in ("pin_axial_N", "crank_axial_N")])
        now = np.array([case.pin_axial, case.crank_axial])
        if np.abs(then - now).max() > _SAME_FORCES * case.largest_force:
            rule = f"was loaded with {then[0]:.6g} N at the pin in {name}, but its study gives {now[0]:.6g} N"
            raise InvalidValue("RUN", str(run.folder), rule, remedy)
    return found
