"""What a search leaves: the study of the lighter rod, the figures, the history and pictures."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from fea.analysis.summary_file import OPTIMISED
from fea.assess.safety import CAP
from fea.optimise.figures import OptimiseFigures
from fea.output.columns_csv import write_columns
from fea.output.errors import PictureError
from fea.output.json_file import json_text
from fea.output.pictures.described import Picture
from fea.output.pictures.picture import draw_pictures
from fea.output.plots.saving import save
from fea.output.text import write_text
from fea.output.vtu import write_vtu
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh

if TYPE_CHECKING:
    from fea.optimise.run_optimise import Checked

STUDY, HISTORY, COURSE, RODS = "study.toml", "history.csv", "history.png", "rods.png"
FILES = (STUDY, OPTIMISED, HISTORY, COURSE, RODS)
YIELDING, FATIGUE = "safety_factor", "fatigue_safety_factor"
# Between the two rods in the picture, relative to their widths.
_APART = 1.15


def write_files(folder: Path, figures: OptimiseFigures, before: "Checked", after: "Checked") -> str:
    """Write the files into an empty folder; return why there is no picture of the rods, empty if there is.

    Raises
    ------
    StorageError, PictureError
        Another one could not be written.
    """
    write_text(folder / STUDY, after.study.text())
    write_text(folder / OPTIMISED, json_text(figures))
    write_columns(folder / HISTORY, _columns(figures))
    plot_course(folder / COURSE, figures)
    try:
        _draw_rods(folder / RODS, figures, before, after)
    except PictureError as error:  # a search is not lost for it
        return str(error)
    return ""


def _columns(figures: OptimiseFigures) -> dict[str, Any]:
    tried = figures.history
    fixed = {
        "number": [design.number for design in tried],
        "mass_kg": [design.mass_kg for design in tried],
        "margin": [design.margin for design in tried],
        "new_mesh": [int(design.new_mesh) for design in tried],
    }
    keys = tried[0].dimensions_mm
    return fixed | {key: [design.dimensions_mm[key] for design in tried] for key in keys}


def plot_course(path: Path, figures: OptimiseFigures) -> None:
    """Plot mass and margin of all designs.

    Raises
    ------
    PictureError
        The file could not be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a plot needs it
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(9, 6), layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True)
    number = np.array([design.number for design in figures.history])
    mass = 1000 * np.array([design.mass_kg for design in figures.history])
    margin = 100 * np.array([design.margin for design in figures.history])
    holds = margin >= 0
    above.plot(number[holds], mass[holds], "o", color="C0", ms=4, label="holds")
    above.plot(number[~holds], mass[~holds], "x", color="C3", ms=5, label="does not hold")
    lightest = np.minimum.accumulate(np.where(holds, mass, np.inf))
    known = np.isfinite(lightest)
    above.step(number[known], lightest[known], where="post", color="0.4", lw=1, label="lightest that holds")
    above.set_ylabel("mass, g")
    above.set_title(f"{figures.study}: designs that were tried", fontsize=11)
    above.legend(frameon=False)
    below.axhline(0, color="0.3", lw=1)
    below.plot(number, margin, ".-", color="C0", lw=0.7)
    below.set_ylabel("least margin, %")
    below.set_xlabel("design")
    for panel in (above, below):
        panel.grid(alpha=0.3)
    save(figure, path, 110)


def _draw_rods(path: Path, figures: OptimiseFigures, before: "Checked", after: "Checked") -> None:
    """Draw both rods at one scale, the earlier one above, in the least safety factors of all speeds."""
    field = FATIGUE if all(FATIGUE in _factors(rod) for rod in (before, after)) else YIELDING
    first, second = (rod.outcomes[0].mesh for rod in (before, after))
    shift = _APART * (np.ptp(first.points[:, 1]) + np.ptp(second.points[:, 1])) / 2
    both = TetMesh(
        np.concatenate([first.points + np.array([0.0, shift, 0.0]), second.points]),
        np.concatenate([first.tets, second.tets + len(first.points)]),
    )
    values = np.concatenate([_factors(rod)[field] for rod in (before, after)])
    old, new = 1000 * figures.mass_before_kg, 1000 * figures.mass_after_kg
    title = f"{figures.study}: before, {old:.0f} g (above), and after, {new:.0f} g"
    with TemporaryDirectory() as scratch:
        vtu = Path(scratch, "rods.vtu")
        write_vtu(vtu, both, {"displacement": np.zeros_like(both.points), field: values})
        draw_pictures([Picture(vtu=vtu, png=path, title=title, field=field)])


def _factors(rod: "Checked") -> dict[str, Floats]:
    """Least safety factors (n_nodes,) of all speeds, by the names of their arrays."""
    cases = [case.safety_factor for outcome in rod.outcomes for case in outcome.cases.values()]
    cycles = [outcome.cycle.envelope for outcome in rod.outcomes if outcome.cycle is not None]
    found = {YIELDING: np.min([*cases, *(cycle.safety_factor for cycle in cycles)], axis=0)}
    fatigue = [cycle.fatigue_factor for cycle in cycles if cycle.fatigue_factor is not None]
    if cycles and len(fatigue) == len(cycles):
        found[FATIGUE] = np.nan_to_num(np.min(fatigue, axis=0), nan=CAP)
    return found
