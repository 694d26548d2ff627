"""The files of a run: every output format is one writer of `WRITERS`.

A writer yields the files that it has for a run. The names of all that were written are the manifest in
`summary.json`, by which `fea.output.folder` recognises a run: a new format needs nothing but its writer.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.analysis.fretting import RubbedSurfaces
from fea.analysis.result import RunResult
from fea.analysis.summary_figures import Summary
from fea.base.note import omission
from fea.film.cycle import FilmCycle
from fea.judge.case_result import CaseResult
from fea.machine.clock import Clock
from fea.output.folder import REPORT, SUMMARY, PictureError, csv_text, picture_name, write_columns, write_text
from fea.output.json_file import json_text
from fea.output.pictures.picture import take_pictures
from fea.output.plots import joint
from fea.output.plots.fretting import plot_fretting
from fea.output.vtu import write_cells, write_pvd, write_result
from fea.pins.yielding import End
from geometry.arrays import Floats
from geometry.surfaces import INTERFACES

ENVELOPE, BUCKLING = "envelope.vtu", "buckling.vtu"
CASES, CYCLE = "cases.pvd", "cycle.pvd"


class RunFiles(NamedTuple):
    """Files to be written: their names in the folder of the run, and what writes them into that folder."""

    names: tuple[str, ...]
    write: Callable[[Path], object]


class Writer(NamedTuple):
    """An output format: the stage that its time counts for, and the files that it has for a run."""

    stage: str
    files: Callable[[RunResult], Iterator[RunFiles]]


def _one(name: str, write: Callable[[Path], object]) -> RunFiles:
    return RunFiles((name,), lambda folder: write(folder / name))


def _cases(run: RunResult) -> Iterator[RunFiles]:
    def write(path: Path, case: CaseResult, *, exact: bool) -> None:
        write_result(path, run.mesh, case.point_data(), case.cell_data(run.materials), exact=exact)

    for number, (name, case) in enumerate(run.cases.items()):
        yield _one(f"{name}.vtu", partial(write, case=case, exact=number == 0))
    touched = {name: case for name, case in run.cases.items() if case.seats}
    if touched:
        yield _one("contact.vtu", partial(write_seats, cases=touched))
    if run.cases:
        angles = {f"{name}.vtu": load.crank_deg for name, load in run.summary.loads.items()}
        yield _one(CASES, lambda path: write_pvd(path, case_times(angles)))


def case_times(angles: Mapping[str, float | None]) -> dict[str, float]:
    """Return a time for each file: its crank angle, degrees, or -1 where it has none.

    No two times are the same, as ParaView would show one of their files only: more files without an angle
    stand at -2, -3 and so on, and those at an angle that is taken 0.001° later.
    """
    times: dict[str, float] = {}
    for name, angle in angles.items():
        time, step = (-1.0, -1.0) if angle is None else (float(angle), 1e-3)
        while time in times.values():
            time += step
        times[name] = time
    return times


# Surfaces on which the same presses as on those opposite to them.
_OPPOSITE = {second for _, second in INTERFACES}


def write_seats(path: Path, cases: Mapping[str, CaseResult]) -> None:
    """Write the pressed surfaces, one side of every interface.

    For each load case, `pressure_CASE`, MPa, and `traction_CASE`: force over area on the part that the
    surface bounds, MPa. Pressures are linear over a facet. Of the elements, an array by the name of each
    surface is 1 on it. Raises `StorageError`: the file could not be written.
    """
    first = next(iter(cases.values()))
    surfaces = [surface for surface in first.seats if surface not in _OPPOSITE]
    facets = [first.mesh.facets[surface] for surface in surfaces]
    nodes = [first.seats[surface].nodes for surface in surfaces]
    starts = np.cumsum([0, *map(len, nodes)])
    cells = [at + np.searchsorted(here, own) for at, here, own in zip(starts, nodes, facets, strict=False)]
    arrays = {}
    for name, case in cases.items():
        seats = [case.seats[surface] for surface in surfaces]
        arrays[f"pressure_{name}"] = np.concatenate([seat.pressure for seat in seats])
        arrays[f"traction_{name}"] = np.concatenate([seat.traction for seat in seats])
    number = np.repeat(np.arange(len(surfaces)), [len(own) for own in facets])
    masks = {surface.value: (number == k).astype(np.uint8) for k, surface in enumerate(surfaces)}
    write_cells(path, first.mesh.points[np.concatenate(nodes)], np.concatenate(cells), arrays, masks)


def _instants(run: RunResult) -> Iterator[RunFiles]:
    if run.instants is not None:
        instants = run.instants
        times = {f"cycle-{degrees:03g}.vtu": degrees for degrees in instants.degrees}

        def write(folder: Path) -> None:
            for name, data in zip(times, instants.fields(), strict=True):
                write_result(folder / name, run.mesh, data, exact=False)

        yield RunFiles(tuple(times), write)
        yield _one(CYCLE, lambda path: write_pvd(path, times))


def _texts(run: RunResult) -> Iterator[RunFiles]:
    yield _one("study.toml", lambda path: write_text(path, run.study.text()))
    files = {"loads.csv": run.forces, "contact.csv": run.contact, "film.csv": run.film, "log.csv": run.log}
    for name, columns in files.items():
        if columns is not None:
            yield _one(name, partial(write_columns, columns=columns))


def _gauges(run: RunResult) -> Iterator[RunFiles]:
    if run.summary.gauges:
        yield _one("gauges.csv", lambda path: write_text(path, csv_text(_gauge_rows(run.summary))))


def _gauge_rows(summary: Summary) -> Iterator[tuple[object, ...]]:
    yield "gauge", "case", "crank_deg", "strain_um_m", "error_um_m", "measured_um_m"
    for gauge in summary.gauges or ():
        for case, one in gauge.cases.items():
            values = summary.loads[case].crank_deg, *vars(one).values()
            yield gauge.name, case, *(None if value is None else f"{value:.6g}" for value in values)
        for degree, strain in enumerate(gauge.history_um_m or ()):
            yield gauge.name, "cycle", degree, f"{strain:.6g}", None, None


def _films(run: RunResult) -> Iterator[RunFiles]:
    for film in run.films:
        cycle, x = film.cycle, 0.0 if film.end is End.BIG else run.summary.rod.length_mm
        for name, number in (("h_min", cycle.thinnest.argmin()), ("p_max", cycle.highest.argmax())):
            yield _one(f"{film.name}_{name}.vtu", partial(_write_film, cycle=cycle, number=int(number), x=x))


def _write_film(path: Path, cycle: FilmCycle, number: int, x: float) -> None:
    """Write the bore at x with pressure, MPa, and thickness, mm, of its film at an instant.

    Nodes are in the middles of the film's cells and on the edges between them, with the mean of both sides
    there, so that the pressure over the triangles has the film's force. A polygon is smaller than its circle:
    the nodes are outside the bore by a share of its radius that makes up for it, .05 % with 96 cells.
    """
    state, grid = cycle.states[number], cycle.bearing.reynolds.grid
    edges, columns = grid.edges, np.arange(grid.n_width)
    if grid.halved:
        edges, columns = np.concatenate([-edges[:0:-1], edges]), np.concatenate([columns[::-1], columns])
    long = np.diff(edges)

    def at_nodes(cells: Floats, ends: Floats) -> Floats:
        values = np.empty((2 * grid.n_angle, len(edges) + len(long)))
        values[::2, 1::2] = cells = cells[:, columns]
        shares = cells * long
        values[::2, 2:-1:2] = (shares[:, 1:] + shares[:, :-1]) / (long[1:] + long[:-1])
        values[::2, 0], values[::2, -1] = ends[:, 0], ends[:, -1]
        values[1::2] = (values[::2] + np.roll(values[::2], -1, axis=0)) / 2
        return values.ravel()

    z = np.sort(np.concatenate([edges, (edges[1:] + edges[:-1]) / 2]))
    half = np.pi / grid.n_angle
    radius = grid.radius * 2 * half / (np.sin(half) * (1 + np.cos(half)))
    angle = half * np.arange(2 * grid.n_angle)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius + [x, 0.0]
    points = np.column_stack([np.repeat(around, len(z), axis=0), np.tile(z, len(around))])
    corner = np.arange(len(points)).reshape(-1, len(z))
    first, second = (each[:, :-1].ravel() for each in (corner, np.roll(corner, -1, axis=0)))
    halves = ([first, second, first + 1], [second, second + 1, first + 1])
    triangles = np.concatenate([np.stack(each, axis=1) for each in halves])
    values = {
        "film_pressure": at_nodes(state.pressure, state.pressure[:, columns[[0, -1]]]),
        "film_thickness": at_nodes(state.gap, state.edge),
    }
    write_cells(path, points, triangles, values, {})


def _fretting(run: RunResult) -> Iterator[RunFiles]:
    if run.fretting is not None:
        yield _one("fretting.vtu", partial(_write_fretting, surfaces=run.fretting))


def _write_fretting(path: Path, surfaces: RubbedSurfaces) -> None:
    """Write the first surface of every pair that rubs; of its elements, an array by its name is 1 on it."""
    masks = {name.value: (surfaces.pair == k).astype(np.uint8) for k, name in enumerate(surfaces.surfaces)}
    write_cells(path, surfaces.points, surfaces.triangles, surfaces.fields, masks)


def _envelope_and_buckling(run: RunResult) -> Iterator[RunFiles]:
    every = {ENVELOPE: run.envelope, BUCKLING: run.buckling and run.buckling.shapes}
    every |= {f"{name}.vtu": arrays for name, arrays in run.left.items()}
    for name, data in every.items():
        if data:
            yield _one(name, partial(write_result, mesh=run.mesh, point_data=data, exact=False))


def _plots(run: RunResult) -> Iterator[RunFiles]:
    title, films = run.summary.title, run.films
    if run.cycle is not None:
        from fea.output.plots.chart import plot_stress_history  # noqa: PLC0415 - only a plot needs it

        yield _one("history.png", lambda path: plot_stress_history(path, run))
    if run.fretting is not None:
        length, rubbed = run.summary.rod.length_mm, run.fretting
        yield _one("fretting.png", lambda path: plot_fretting(path, rubbed, length, title))
    touched = run.pictured and any(case.touch for case in run.cases.values())
    joined = any(case.assembly for case in run.cases.values())
    if not films and not touched and not joined:
        return
    for film in films:
        yield _one(f"{film.name}.png", partial(joint.plot_film, film=film, title=title))
    if touched:
        length = run.summary.rod.length_mm
        yield _one("bores.png", lambda path: joint.plot_bores(path, run.cases, length, title))
    if joined:
        yield _one("joint.png", lambda path: joint.plot_joint(path, run.cases, title, run.cycle))


def _pictures(run: RunResult) -> Iterator[RunFiles]:
    """All pictures together: one process draws them."""
    if run.pictured and run.speed is not None:
        results = [f"{name}.vtu" for name in run.cases]
        results += [ENVELOPE] if run.cycle is not None else []
        results += [f"{name}.vtu" for name in run.left]
        results += [BUCKLING] if run.buckling is not None and run.buckling.shapes else []
        names = tuple(picture_name(name) for name in results)
        yield RunFiles(names, lambda folder: take_pictures(folder, run.summary, results))


def _report(run: RunResult) -> Iterator[RunFiles]:
    if run.study.output.report:
        from fea.output.report.page import write_report  # noqa: PLC0415 - only a report needs it

        yield _one(REPORT, lambda path: write_report(path, run))


WRITERS = (
    Writer("write", _cases),
    Writer("write", _instants),
    Writer("write", _texts),
    Writer("write", _gauges),
    Writer("write", _films),
    Writer("write", _fretting),
    Writer("write", _envelope_and_buckling),
    Writer("plot", _plots),
    Writer("picture", _pictures),
    Writer("report", _report),
)


def pays_to_draw(run: RunResult, clock: Clock) -> bool:
    """Return whether pictures that were not requested add at most a quarter to the time of a run until now.

    Starting the process that draws takes about 2.5 s, and a picture .25 s and 2 µs a node.
    """
    drawing = 2.5 + len(run.cases) * (0.25 + 2e-6 * run.summary.model.nodes)
    return clock.total > 4 * drawing


def write_run(
    folder: Path, run: RunResult, clock: Clock, *, shared_files: tuple[str, ...] | None = None
) -> tuple[Summary, str]:
    """Write all files of a run into a directory that exists, the summary last.

    Of one speed of several, the shared files are those beside its folder. Returned are the summary that was
    written, and why a picture that was asked for is missing (empty where none is): a machine that cannot draw
    keeps the rest. Raises `StorageError`: the disk, a permission or the file system refused.
    """
    asked, names, without_pictures = run.study.output.screenshot, [SUMMARY], ""
    pictured = shared_files is None and pays_to_draw(run, clock) if asked is None else asked
    run = replace(run, pictured=pictured)
    for writer in WRITERS:
        for files in writer.files(run):
            try:
                with clock(writer.stage):
                    files.write(folder)
            except PictureError as error:
                without_pictures = without_pictures or str(error)
            else:
                names += files.names
    left_out = run.summary.left_out
    if without_pictures and not (asked or run.study.output.report):
        left_out, without_pictures = (*left_out, omission("pictures", without_pictures)), ""
    summary = replace(
        run.summary,
        left_out=left_out,
        note_kinds=tuple((note.kind.value, note.topic) for note in run.summary.notes),
        timings_s=run.summary.timings_s | dict(clock.seconds),
        total_s=max(clock.total, run.summary.total_s),
        files=tuple(sorted(names)),
        shared_files=shared_files,
    )
    write_text(folder / SUMMARY, json_text(summary))
    return summary, without_pictures
