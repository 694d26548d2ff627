"""The jobs behind `fea export` and `fea report`: a stored run for another program, or as a report."""

import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.analysis.film import films_at
from fea.analysis.forces import drawn_solid
from fea.analysis.life_figures import EnvelopeFigures
from fea.analysis.motion import SolvedInstant, agreeing, motion
from fea.analysis.pipeline import prepare
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.result import ELSEWHERE
from fea.analysis.summary_figures import FilmFigures
from fea.apps.what_if.solve import REFUSALS, what_if
from fea.base.choices import UnitSystem
from fea.base.note import Note, warning
from fea.base.units import DEG
from fea.machine.clock import Clock, Listener
from fea.output.folder import REPORT, SHEET, SUMMARY, StorageError, require_target
from fea.output.inp import Step, write_deck
from fea.output.json_file import governing_run
from fea.output.pictures.picture import ready_to_draw
from fea.output.report.page import write_pdf, write_report, write_sheet
from fea.output.report.sections import marks
from fea.output.stored_run import StoredRun, read_run
from fea.output.units import shown_in
from fea.output.vtu import COMPONENTS
from fea.rod.given import PART, meshed_rod
from fea.solid.stress import matrices
from fea.solid.supports import clamped, determinate_restraints
from fea.study.option_tables import PINS
from fea.study.study import Study
from geometry.errors import InvalidValue, require
from geometry.surfaces import Surface
from loads.instants import Instants
from mesh.files.given import named_mesh
from mesh.tetmesh import FACET_CHILDREN, TET_TURN, MeshError, TetMesh, boundary_facets

# Largest relative difference between the forces of a run and those worked out again.
_SAME_FORCES = 1e-6
_OF_ASSEMBLY = (
    "Export its results as .vtu or .med instead of a deck; fea run study.toml --cycle --report writes a "
    "report with its cycle."
)


def prepared_again(run: StoredRun) -> PreparedRod:
    """Prepare the study of a run on the run's own mesh.

    Raises `InvalidValue`: the rod is an assembly: a run's mesh does not say where its parts touch;
    `MeshError`: the bores of the run's mesh were not found.
    """
    study, rule = run.study, "holds a rod of separate parts, and its mesh does not say where they touch"
    require(study.assembly is None, "RUN", str(run.folder), rule, _OF_ASSEMBLY)
    dimensions = study.rod.dimensions
    known = (None, None) if dimensions is None else (dimensions.big_end_bore, dimensions.small_end_bore)
    mesh, bores = named_mesh(run.mesh, known)
    names = _part_names(study, 1 if mesh.part is None else int(mesh.part.max()) + 1)
    return prepare(study, mesh=meshed_rod(mesh, bores, names))


def _part_names(study: Study, count: int) -> Sequence[str]:
    if count == 1:
        return [next(iter(sorted(study.part_material.keys() - PINS)), PART)]
    if study.rod.cad is None:
        return ["rod", "bushing"]
    return [part.name for part in drawn_solid(study.rod).parts]


def require_same_loads(run: StoredRun, cases: Iterable[Instants]) -> Mapping[str, Instants]:
    """Return load cases by name, if their loads are those of the run. Raises `InvalidValue`: they are not."""
    again = {case.name: case for case in cases}
    remedy = "Repeat the run: fea run study.toml."
    loads = run.summary.loads
    rule = f"holds the cases {', '.join(loads)}, but its study gives {', '.join(again)}"
    require(set(loads) == set(again), "RUN", str(run.folder), rule, remedy)
    for name, case in again.items():
        then = np.array([loads[name].pin_axial_N, loads[name].crank_axial_N])
        now = np.array([case.pin_axial, case.crank_axial])
        if np.abs(then - now).max() > _SAME_FORCES * case.largest_force:
            rule = f"was loaded with {then[0]:.6g} N at the pin in {name}, but its study gives {now[0]:.6g} N"
            raise InvalidValue("RUN", str(run.folder), rule, remedy)
    return again


# Relative change of a film's highest pressure up to which it is the same.
_SAME = 1e-3


def report_run(
    folder: Path,
    listener: Listener | None = None,
    units: UnitSystem | None = None,
    out: Path | None = None,
    *,
    sheet: bool = False,
    pdf: bool = False,
) -> list[Path]:
    """Write the report of a run into its folder, or of each run of one at several speeds; return their files.

    A run at one speed may have its report in another file, `out`.

    The listener receives the name of each stage as it begins. The figures are in the given units, or in those
    of the run. `sheet`: write the builder's sheet alone; `pdf`: print each page as well. Raises
    `InvalidValue`: the folder is not that of a run, or its files are damaged; `StorageError`: the disk, a
    permission or the file system refused; `PictureError`: no browser could print, the pages are written.
    """
    require(folder.is_dir(), "RUN", str(folder), "is not a directory", "Name a folder that fea run wrote.")
    clock = Clock(listener)
    speeds = sorted({place.parent for place in folder.glob(f"*/{SUMMARY}")})
    runs = [folder] if (folder / SUMMARY).is_file() or not speeds else speeds
    rule, remedy = "would hold a report of each speed", f"Name one of the runs, such as {runs[0]}."
    require(out is None or runs == [folder], "--out", None if out is None else str(out), rule, remedy)
    with nullcontext() if sheet else ready_to_draw():
        worst = governing_run(folder)[0]
        pages = [_page(run, clock, units, out, sheet=sheet, governs=run == worst) for run in runs]
    if not pdf:
        return pages
    for page in pages:
        with clock("pdf"):
            write_pdf(page, page.with_suffix(".pdf"))
    return [*pages, *(page.with_suffix(".pdf") for page in pages)]


def _page(
    folder: Path, clock: Clock, units: UnitSystem | None, out: Path | None, *, sheet: bool, governs: bool
) -> Path:
    with clock("read"):
        run = read_run(folder)
        cycle = run.summary.cycle if run.fields and not sheet else None
    if cycle is not None:
        run = _with_motion(run, cycle, clock)
    if run.fields and run.summary.film and not sheet:
        run = _with_films(run, run.summary.film, clock)
    run = replace(run, what_if=what_if(run, clock) if governs else ELSEWHERE)
    page = out or folder / (SHEET if sheet else REPORT)
    with clock("report"), shown_in(units or run.study.output.units):
        (write_sheet if sheet else write_report)(page, run, folder)
    return page


def _with_motion(run: StoredRun, cycle: EnvelopeFigures, clock: Clock) -> StoredRun:
    """The run with its cycle, solved again on the run's own mesh: unit solutions are not kept on disk."""
    try:
        with clock("cycle"):
            rod = prepared_again(run)
            require_same_loads(run, rod.loading.at(rod.mass, run.summary.rpm).cases)
            again = motion(rod, run.summary.rpm or 0.0, cycle.max_von_mises_MPa)
    except REFUSALS as error:
        return replace(run, without_motion=f"the cycle could not be solved again: {error}")
    same, why = agreeing(again, _known(run))
    return replace(run, motion=same, without_motion=f"solved again, {why}" if why else "")


def _with_films(run: StoredRun, known: Mapping[str, FilmFigures], clock: Clock) -> StoredRun:
    """The run with the oil films of its bearings, solved again, where they are what they were."""
    with suppress(*REFUSALS), clock("film"):
        films, _ = films_at(prepared_again(run), run.summary.rpm or 0.0)
        changes = [film.figures.p_max_MPa / known[film.end.value].p_max_MPa - 1 for film in films]
        return replace(run, films=films) if np.abs(changes).max() < _SAME else run
    return run


def _known(run: StoredRun) -> Iterator[SolvedInstant]:
    for name, angle in marks(run.summary).items():
        yield SolvedInstant(angle * DEG, run.fields[name]["von_mises"], run.fields[name]["displacement"])


Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Format:
    """Capabilities of a file format."""

    module: str  #: meshio's module that writes it
    #: points, cells: whether it takes arrays of the nodes, and of the elements
    points: bool = False
    cells: bool = False
    surfaces: bool = False  #: whether it takes the named surfaces, as triangles
    skin: bool = False  #: whether it is of triangles only
    options: Mapping[str, Any] | None = None  #: for meshio

    @property
    def without(self) -> str:
        """The content that it cannot carry, in words; empty for nothing."""
        if self.skin:
            return "the solid elements and the results: the file holds the boundary as flat triangles"
        if not self.points:
            return "the results and the names of the bores: the file holds the mesh only"
        left = [] if self.cells else ["the arrays of the elements"]
        return " and ".join([*left, *([] if self.surfaces else ["the names of the bores"])])


FORMATS = {
    ".vtu": Format("vtu", points=True, cells=True),
    ".vtk": Format("vtk", points=True, cells=True),
    ".xdmf": Format("xdmf", points=True, cells=True),
    ".msh": Format("gmsh", points=True, surfaces=True, options={"fmt_version": "2.2", "binary": True}),
    ".med": Format("med", points=True, surfaces=True),
    ".bdf": Format("nastran"),
    ".nas": Format("nastran"),
    ".stl": Format("stl", skin=True),
    ".ply": Format("ply", skin=True),
}


def write_mesh(
    path: Path, mesh: TetMesh, point_data: Mapping[str, Array], cell_data: Mapping[str, Array]
) -> tuple[Path, ...]:
    """Write a mesh with as much of its results as the format of the suffix carries (see `Format.without`).

    Returned are the files written: XDMF keeps its numbers in a second one, ``.h5``. Raises `StorageError`:
    the disk or a permission refused, or an installed library lacks.
    """
    form = FORMATS[path.suffix.lower()]
    try:
        write = import_module(f"meshio.{form.module}").write
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".export-") as scratch:
            place = Path(scratch) / path.name
            write(str(place), _content(form, mesh, point_data, cell_data), **dict(form.options or {}))
            if form.module == "nastran":
                _complete_deck(place)
            if form.module == "med":
                _name_components(place)
            made = sorted(Path(scratch).iterdir())
            for file in made:
                file.replace(path.parent / file.name)
    except OSError as error:
        reason = error.strerror or str(error)
        raise StorageError(f"{path} could not be written: {reason}. Choose another path.") from error
    except ImportError as error:
        remedy = f"Type: pip install {error.name}" if error.name else "Install it"
        raise StorageError(f"{path} could not be written: {error}. {remedy}") from error
    return tuple(path.parent / file.name for file in made)


def _complete_deck(place: Path) -> None:
    """Give bulk data of meshio what readers insist on: executive control, and Nastran's name of elements."""
    text = place.read_bytes().replace(b"\nCTETRA_ ", b"\nCTETRA  ")
    place.write_bytes(text.replace(b"\nBEGIN BULK\n", b"\nSOL 101\nCEND\nBEGIN BULK\n", 1))


# Letters of each name of a component, and of its unit; of the name of a mesh.
_MED_WORD, _MED_NAME = 16, 64
_AXES = ("X", "Y", "Z")
_STRESSES = ("stress", "von_mises", "principal_1", "principal_2", "principal_3", "contact_pressure")


def _name_components(place: Path) -> None:
    """Name the mesh of a MED file, the components of its fields, and their units, as meshio does not."""
    from h5py import File  # noqa: PLC0415 - only an export to MED needs it

    short = place.stem.isascii() and len(place.stem) <= _MED_NAME
    mesh = place.stem if short else "mesh"  # FreeCAD looks for a mesh that is called as its file
    with File(place, "r+") as file:
        for meshes in (file["ENS_MAA"], file["FAS"]):
            meshes[mesh] = meshes.pop("mesh")
        for name, field in file.get("CHA", {}).items():
            field.attrs["MAI"] = np.bytes_(mesh)
            number = int(field.attrs["NCO"])
            names = {3: _AXES, 6: COMPONENTS["stress"]}.get(number, ("",) * number)
            unit = "MPa" if name.endswith(_STRESSES) else "mm" if name.endswith("displacement") else ""
            for key, words in (("NOM", names), ("UNI", (unit,) * number)):
                field.attrs[key] = np.bytes_("".join(word.ljust(_MED_WORD) for word in words))


def _content(
    form: Format, mesh: TetMesh, point_data: Mapping[str, Array], cell_data: Mapping[str, Array]
) -> Any:
    from meshio import Mesh  # noqa: PLC0415 - only an export needs it

    if form.skin:
        facets = boundary_facets(mesh.tets)
        if mesh.order == 2:
            facets = facets[:, FACET_CHILDREN].reshape(-1, 3)
        used, local = np.unique(facets, return_inverse=True)
        return Mesh(mesh.points[used], [("triangle", local.reshape(-1, 3).astype(np.int32))])
    kind = "tetra" if mesh.order == 1 else "tetra10"
    # MED numbers the nodes of tetrahedra in the other sense, and meshio leaves them as they are.
    tets = mesh.tets[:, TET_TURN[mesh.tets.shape[1]]] if form.module == "med" else mesh.tets
    if form.module == "nastran":
        part = np.ones(len(mesh.tets), dtype=int) if mesh.part is None else mesh.part + 1
        property_numbers = {"nastran:ref": [part]}
        # Coordinates as Nastran's fields of sixteen letters hold them, with a sign and one digit of exponent.
        short = [float(f"{x:.10e}") if abs(x) > 1e-9 else 0.0 for x in mesh.points.ravel().tolist()]
        return Mesh(np.reshape(short, mesh.points.shape), [(kind, mesh.tets)], cell_data=property_numbers)
    points = dict(point_data)
    if form.module in {"gmsh", "xdmf"}:  # the one takes no six components, the other orders them differently
        tensors = [name for name, values in points.items() if values.shape[1:] == (6,)]
        points |= {name: matrices(points[name]).reshape(-1, 9) for name in tensors}
    if not form.surfaces or not mesh.facets:
        # VTK has no name for integers that meshio writes.
        plain = {name: values.astype(float) for name, values in cell_data.items()}
        cell_data = plain if form.module == "vtk" else cell_data
        of_cells = {name: [values] for name, values in cell_data.items() if form.cells}
        of_points = points if form.points else {}
        return Mesh(mesh.points, [(kind, tets)], point_data=of_points, cell_data=of_cells)
    # One number for the solid, and one for each named surface.

    names = list(mesh.facets)
    triangles = np.concatenate([mesh.facets[name] for name in names])
    marks = np.repeat(np.arange(1, len(names) + 1), [len(mesh.facets[name]) for name in names])
    cells = [(f"triangle{'' if mesh.order == 1 else '6'}", triangles), (kind, tets)]
    solid = np.full(len(mesh.tets), len(names) + 1)
    if form.module == "gmsh":
        marked = {f"gmsh:{what}": [marks, solid] for what in ("physical", "geometrical")}
        named = {name.value: np.array([number, 2]) for number, name in enumerate(names, start=1)}
        named |= {"rod": np.array([len(names) + 1, 3])}
        return Mesh(mesh.points, cells, point_data=points, cell_data=marked, field_data=named)
    made = Mesh(mesh.points, cells, point_data=points, cell_data={"cell_tags": [-marks, -solid]})
    tags = [*(name.value for name in names), "rod"]
    made.cell_tags = {-number: [name] for number, name in enumerate(tags, start=1)}
    return made


SUFFIXES = (".inp", *FORMATS)


@dataclass(frozen=True)
class Exported:
    """Result of an export."""

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
    points = {  # formats other than VTK's have no arrays of small integers at the nodes
        f"{case}_{name}": values if values.dtype.kind == "f" else values.astype(float)
        for case, file in stored
        for name, values in file.point.items()
    }
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
