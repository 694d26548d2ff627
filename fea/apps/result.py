"""The Python interface to an analysis: `analyse` computes, a `Result` shows and writes what was found."""

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from fea.analysis.pipeline import prepare as prepared
from fea.analysis.pipeline import refined_rod
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.result import RunResult, run_result
from fea.apps.frames import case_rows, frame
from fea.judge.case_result import CaseResult
from fea.machine.clock import Clock, duration, in_words, progress_shown
from fea.output.folder import PictureError, run_folder
from fea.output.json_file import JsonObject, as_dict
from fea.output.pictures.picture import draw_pictures
from fea.output.pictures.shown import chosen_field, described_by
from fea.output.run_files import write_run
from fea.output.units import shown_in
from fea.output.vtu import vtk_grid, write_vtu
from fea.study.changes import in_python, python_words
from fea.study.flags import python_flags
from fea.study.study import DEFAULT_STUDY, Study, load_study
from geometry.errors import InvalidValue, require
from mesh.tetmesh import TetMesh

if TYPE_CHECKING:
    import pandas as pd
    import pyvista
    from PIL.Image import Image


class Result(RunResult):
    """Results of an analysis at one speed; frozen, in memory only until `write` is called.

    Fields are arrays on the whole rod, mm and MPa; figures are in ``summary``, in the units their names say.

    Examples
    --------
    >>> from fea import analyse
    >>> result = analyse("leon-2001", rpm=6000, size=14)
    >>> sorted(result.cases)
    ['bending', 'compression', 'gas', 'side', 'tension']
    >>> tension = result.cases["tension"]
    >>> 500 < tension.max_von_mises < 800
    True
    >>> tension.stress.shape == (len(result.mesh.points), 6)
    True
    >>> result.checks["force_balance"].passed
    True
    >>> print(result.to_pyvista("tension").array_names[:2])
    ['displacement', 'stress']
    """

    @property
    def cases(self) -> Mapping[str, CaseResult]:
        """One result per load case, by its name; none of a result without its fields."""
        return super().cases if self.speed is not None else _NoFields()

    def to_pyvista(self, case: str) -> "pyvista.UnstructuredGrid":
        """Return a case, or ``"envelope"``, as a PyVista grid with the VTU's arrays; else `InvalidValue`."""
        import pyvista as pv  # noqa: PLC0415 - only who asks for a grid needs it

        return pv.wrap(vtk_grid(self.mesh.points, self.mesh.tets, *self._arrays(case)))

    def _arrays(self, case: str) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        """Return the arrays of the nodes and of the elements of a case, or of ``"envelope"``."""
        if self.speed is None:
            raise _without_fields(f"case {case!r}")
        names = [*self.cases, *(["envelope"] if self.cycle is not None else [])]
        require(case in names, "case", case, f"must be one of {', '.join(names)}")
        if case == "envelope":
            return self.envelope or {}, {}
        return self.fields[case], self.cases[case].cell_data(self.materials)

    @python_words()
    def plot(self, case: str | None = None, field: str | None = None) -> "Image":
        """Return a picture of a case, or ``"envelope"``, by default of what governs; a notebook shows it.

        `field` is one of `fea view`: ``von_mises``, ``safety_factor``, ``displacement``, … The picture is a
        ``PIL.Image.Image``, which ``.save("tension.png")`` writes. Raises `InvalidValue`: there is no such
        case or field; `PictureError`: this machine cannot draw.
        """
        from PIL import Image  # noqa: PLC0415 - only a picture needs it

        name = case or self.summary.governing_result
        points, cells = self._arrays(name)
        if field is not None:
            field = chosen_field(field, points, name)
        with shown_in(self.study.output.units), TemporaryDirectory() as scratch:
            vtu, png = Path(scratch, f"{name}.vtu"), Path(scratch, f"{name}.png")
            write_vtu(vtu, self.mesh, points, cells)
            draw_pictures([replace(described_by(self.summary, vtu, field), png=png)])
            with Image.open(png) as picture:
                return picture.copy()

    def to_frame(self) -> "pd.DataFrame":
        """Return a row for each load case, with the columns of ``summary.json``: results, then loads.

        Raises `ImportError`: pandas is not installed.
        """
        return frame(case_rows(self.summary), "case")

    def without_fields(self) -> "Result":
        """Return the result with its figures alone, less than 2 MB, as it is pickled; `write` keeps fields.

        Mesh, cases and envelope are empty; figures stand in `summary`, forces in `forces`.
        """
        empty = TetMesh(np.zeros((0, 3)), np.zeros((0, 10), np.int64))
        left = replace(self, speed=None, motion=None, instants=None, life=None, buckling=None)
        return replace(left, mesh=empty, without_motion=_LEFT_OUT)

    def __getstate__(self) -> dict[str, Any]:
        return vars(self.without_fields())

    def __copy__(self) -> "Result":
        return self

    def __deepcopy__(self, _memo: object) -> "Result":
        return self

    @python_words()
    def write(self, folder: str | Path, *, screenshot: bool | None = None, report: bool = False) -> Path:
        """Write what ``fea run`` writes into a folder, all or nothing, and return it.

        The folder is new, or holds nothing but an earlier run, which is replaced. Each result is drawn on
        request, or where the study asks for it; a report solves what assumptions change, which takes about as
        long as a refined analysis, and shows the crank cycle if it was analysed with ``report=True``. Raises
        `OccupiedError`: the folder holds something other than an earlier run; `StorageError`: the disk, a
        permission or the file system refused; `PictureError`: this machine cannot draw; the folder is as it
        was before.
        """
        asked = self.study.output.screenshot if screenshot is None else screenshot
        output = replace(self.study.output, screenshot=asked, report=report)
        drawn = replace(self, study=replace(self.study, output=output))
        if report:
            from fea.apps.what_if.solve import what_if  # noqa: PLC0415 - only a report needs it

            drawn = replace(drawn, what_if=what_if(drawn, Clock()))
        with shown_in(output.units), run_folder(Path(folder)) as place:
            _, without_pictures = write_run(place, drawn, Clock())
            if without_pictures:
                raise PictureError(without_pictures)
        return Path(folder)

    def as_dict(self) -> JsonObject:
        """Return the figures as dictionaries and lists: what ``summary.json`` holds."""
        return dict(as_dict(self.summary))

    def __repr__(self) -> str:
        trusted = "" if self.trusted else ", NOT TO BE TRUSTED"
        return f"<{self.summary.title}: {in_python(self.summary.survival.text)}{trusted}>"

    def _repr_html_(self) -> str:
        from fea.output.report.page import head, still  # noqa: PLC0415 - only a notebook needs it

        worst = self.summary.worst_case
        with shown_in(self.study.output.units), TemporaryDirectory() as scratch:
            if worst not in self.cases:
                return in_python(head(self))
            place = Path(scratch)
            write_vtu(place / f"{worst}.vtu", self.mesh, *self._arrays(worst))
            return in_python(head(self, still(place, self.summary)))


_LEFT_OUT = "the result was kept without its fields"


def _without_fields(what: str) -> InvalidValue:
    remedy = "Its figures are in result.summary; analyse(result.study) computes its fields again."
    return InvalidValue(what, None, f"is not there: {_LEFT_OUT}", remedy)


class _NoFields(dict[str, CaseResult]):
    """The cases of a result without fields: none."""

    def __missing__(self, case: str) -> CaseResult:
        raise _without_fields(f"case {case!r}")


def analyse(
    study: str | Path | Study = DEFAULT_STUDY, *, progress: bool | None = None, **flags: Any
) -> Result:
    """Analyse a study at one speed and return what was found; nothing is written to disk.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
    progress
        Whether the stages are shown as they begin; by default in notebooks alone.
    **flags
        Those of ``fea run`` that ask for figures, by their Python names: ``rpm`` (a number), ``size``,
        ``element``, ``support``, ``symmetry``, ``pressure``, ``solver``, ``matrix_assembly``,
        ``cycle``, ``fatigue``, ``buckling``, ``tolerance``, ``min_safety``, ``material``, ``engine``,
        ``unusual``; of a rod from a file ``unit``, ``solids``, ``cap``, ``big_end_bore``,
        ``small_end_bore``, ``swap_ends``; and
        ``report``, which keeps what a report needs to show every crank angle.

    Raises
    ------
    InvalidValue
        A value breaks a rule, or the study has several speeds and none is chosen.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    UnderconstrainedError, SingularMatrixError, SolverUnavailableError
        The equations could not be solved.

    Examples
    --------
    >>> from fea import analyse, load_study
    >>> thin = load_study("leon-2001").with_rod(web_thickness_mm=4.0)
    >>> analyse(thin, rpm=6000, size=14).summary.rod.mass_kg < 0.785
    True
    """
    asked = _asked(study, flags)
    speeds = asked.speeds()
    rule = f"has {len(speeds)} speeds, and a result is of one"
    require(len(speeds) == 1, "STUDY", asked.name, rule, "Choose one: analyse(study, rpm=6000).")
    with progress_shown(progress, f"{asked.name}: starting") as show:
        clock = Clock(lambda stage: show(f"{asked.name}: {in_words(stage)}"))
        adapted = refined_rod(asked, speeds, clock)
        run = run_result(asked, adapted, adapted.at(speeds[0]))
        show(f"{asked.name}: done in {duration(clock.total)}")
    return Result(**{field.name: getattr(run, field.name) for field in fields(run)})


def prepare(study: str | Path | Study = DEFAULT_STUDY, **flags: Any) -> PreparedRod:
    """Draw and mesh the rod of a study, and prepare stiffness, loads and recovery: what `analyse` solves.

    Parameters and errors are those of `analyse`; the mesh is not refined.

    Examples
    --------
    >>> from fea import prepare
    >>> rod = prepare("leon-2001", size=14)
    >>> sorted(rod.mesh.cell.facets)[:2]
    [<Surface.BIG_END_BORE: 'big_end_bore'>, <Surface.FREE: 'free'>]
    """
    return prepared(_asked(study, flags))


def _asked(study: str | Path | Study, flags: Mapping[str, Any]) -> Study:
    found = study if isinstance(study, Study) else load_study(study)
    return python_flags(flags, writes=False).applied(found)
