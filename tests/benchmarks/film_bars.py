"""Error bars of oil films: random rods on a run's grids and mesh, against finer ones of both.

    python tests/benchmarks/film_bars.py --count 15 --resume bars.json --report results/film-bars.md

Rods, engines and oils are those of `film_campaign.py`, on a run's mesh with contact. The reference has twice
as many elements around the bores and 144 by 10 cells in 216 steps. Both changes, of the mesh and of the
film's grid, are listed apart: the film of a run's grid on the finer mesh is between the two.
"""

import dataclasses
import statistics
import sys

from film_campaign import drawn
from scripts import Row, campaign, command, table

from fea.analysis.film import FilmResult, film_at
from fea.analysis.pipeline import prepare
from fea.base.units import UM
from fea.film.cycle import FilmCycle
from fea.pins import lubrication
from fea.pins.yielding import End
from fea.rod import discretise
from fea.solid.errors import FilmError
from fea.study.option_tables import AnalysisTable, MeshTable
from fea.study.study import Study
from geometry.errors import GeometryError, InvalidValue
from mesh.sizing import PER_TOUCHED_BORE
from mesh.tetmesh import MeshError

FINER = (144, 10, 216)
FIGURES = ("h_min_um", "p_max_MPa")
SOLVED = ("hydrodynamic", "mixed", "starved")
OF_A_RUN = (lubrication.FINE, lubrication.COARSE)


def films(study: Study, per_bore: int, grids: tuple[tuple[int, int, int], ...]) -> dict[End, FilmResult]:
    """Films of both ends on a mesh with so many elements around the bores, or why there is none."""
    discretise.PER_TOUCHED_BORE = per_bore
    lubrication.FINE, lubrication.COARSE = grids
    rod, found = prepare(study), {}
    for end, of_end in ((End.BIG, rod.films), (End.SMALL, rod.small_end_films)):
        try:
            found[end] = film_at(rod, study.speed.speeds()[0], of_end)
        except FilmError as error:
            print(study.name, end, error, file=sys.stderr)
    return found


def outcome(seed: int) -> Row | None:
    """Figures of the films of both ends: of a run with their bars, and on finer meshes and grids."""
    study = drawn(seed)
    if study is None:
        return None
    study = dataclasses.replace(study, mesh=MeshTable(), analysis=AnalysisTable())
    try:
        ours = films(study, PER_TOUCHED_BORE, OF_A_RUN)
        finer = films(study, 2 * PER_TOUCHED_BORE, (FINER, OF_A_RUN[0])) if ours else {}
    except (InvalidValue, GeometryError, MeshError) as error:
        print(seed, error, file=sys.stderr)
        return None
    return {"seed": seed} | {
        end: {
            "verdict": film.verdict.value,
            "run": dataclasses.asdict(film.figures),
            "mesh": extremes(finer[end].coarse),
            "reference": extremes(finer[end].cycle),
        }
        for end, film in ours.items()
        if end in finer
    }


def extremes(film: FilmCycle) -> dict[str, float]:
    """Smallest gap and largest pressure."""
    return dict(zip(FIGURES, (float(film.thinnest.min()) / UM, float(film.highest.max())), strict=True))


def films_of(rods: list[Row]) -> list[tuple]:
    """Seed, end, verdict, figure and in per cent the bar, the change, and those of mesh and grid."""
    found = []
    for rod in rods:
        for end, film in ((end, rod[end]) for end in End if end in rod):
            for name in FIGURES:
                run, mesh, finer = (film[key][name] for key in ("run", "mesh", "reference"))
                bar = film["run"][f"{name.rsplit('_', 1)[0]}_error_percent"]
                changes = [100 * (a - b) / run for a, b in ((finer, run), (mesh, run), (finer, mesh))]
                found.append((str(rod["seed"]), end, film["verdict"], name.rsplit("_", 1)[0], bar, *changes))
    return found


def report_text(rods: list[Row]) -> str:
    """The report."""
    found = films_of(rods)
    lines = ["# Error bars of oil films", "", f"Made by `{command()}`: {len(rods)} random rods.", ""]
    sums = []
    for end in End:
        for name in (figure.rsplit("_", 1)[0] for figure in FIGURES):
            some = [row for row in found if row[1] == end and row[3] == name and row[2] in SOLVED]
            if some:
                held = sum(abs(row[5]) <= row[4] for row in some)
                ratio = statistics.median(row[4] / max(abs(row[5]), 1e-3) for row in some)
                bar, change = (statistics.median(abs(row[k]) for row in some) for k in (4, 5))
                sums.append(
                    (end.words, name, f"{held} of {len(some)}", f"{ratio:.1f}", f"{bar:.2g}", f"{change:.2g}")
                )
    head = ("end", "figure", "held", "bar over change, median:", "bar, %, median:", "change, %, median:")
    lines += [f"Films that are {', '.join(SOLVED)}:", "", *table(head, sums), ""]
    head = ("rod", "end", "verdict", "figure", "bar, %:", "change, %:", "of the mesh:", "of the grid:")
    each = [(*row[:4], *(f"{value:.2f}" for value in row[4:])) for row in found]
    return "\n".join([*lines, *table(head, each), ""])


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=15, first=2000, what="count", patience=3600.0)
