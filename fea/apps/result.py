"""The Python interface to an analysis: `analyse` computes, a `Result` shows and writes what was found."""

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from fea.analysis.pipeline import prepare as prepared
from fea.analysis.pipeline import refined_rod
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.result import RunResult, run_result
from fea.machine.clock import Clock
from fea.output.folder import run_folder
from fea.output.json_file import JsonObject, as_dict
from fea.output.run_files import write_run
from fea.output.target import PictureError
from fea.output.units import shown_in
from fea.output.vtu import vtk_grid, write_vtu
from fea.study.flags import python_flags
from fea.study.study import DEFAULT_STUDY, Study, load_study
from geometry.errors import require

if TYPE_CHECKING:
    import pyvista


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

    def to_pyvista(self, case: str) -> "pyvista.UnstructuredGrid":
        """Return a case, or ``"envelope"``, as a PyVista grid with the VTU's arrays; else `InvalidValue`."""
        import pyvista as pv  # noqa: PLC0415 - only who asks for a grid needs it

        names = [*self.cases, *(["envelope"] if self.cycle is not None else [])]
        require(case in names, "case", case, f"must be one of {', '.join(names)}")
        if case == "envelope":
            points, cells = self.envelope or {}, {}
        else:
            points, cells = self.fields[case], self.cases[case].cell_data(self.materials)
        return pv.wrap(vtk_grid(self.mesh.points, self.mesh.tets, points, cells))

    def write(self, folder: str | Path, *, screenshot: bool | None = None, report: bool = False) -> Path:
        """Write what ``fea run`` writes into a folder, all or nothing, and return it.

        The folder is new, or holds nothing but an earlier run, which is replaced. Each result is drawn on
        request, or where the study asks for it; a report shows the crank cycle if it was analysed with
        ``report=True``. Raises `OccupiedError`: the folder holds something other than an earlier run;
        `StorageError`: the disk, a permission or the file system refused; `PictureError`: this machine cannot
        draw; the folder is as it was before.
        """
        asked = self.study.output.screenshot if screenshot is None else screenshot
        output = replace(self.study.output, screenshot=asked, report=report)
        drawn = replace(self, study=replace(self.study, output=output))
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
        return f"<{self.summary.title}: {self.summary.survival.text}{trusted}>"

    def _repr_html_(self) -> str:
        from fea.output.report.page import head, still  # noqa: PLC0415 - only a notebook needs it

        worst = self.summary.worst_case
        with shown_in(self.study.output.units), TemporaryDirectory() as scratch:
            if worst not in self.cases:
                return head(self)
            place = Path(scratch)
            cells = self.cases[worst].cell_data(self.materials)
            write_vtu(place / f"{worst}.vtu", self.mesh, self.fields[worst], cells)
            return head(self, still(place, self.summary))


def analyse(study: str | Path | Study = DEFAULT_STUDY, **flags: Any) -> Result:
    """Analyse a study at one speed and return what was found; nothing is written to disk.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
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
    adapted = refined_rod(asked, speeds, Clock())
    run = run_result(asked, adapted, adapted.at(speeds[0]))
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
