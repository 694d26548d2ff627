"""Picture of fretting: the joint and the unrolled seats, in the colours of energy and of σ_T τ δ."""

from pathlib import Path

import numpy as np

from fea.analysis.fretting import PAIRS, RubbedSurfaces
from fea.output.plots.figure import label_axes, new_figure, save
from geometry.arrays import Floats
from geometry.surfaces import Surface

# Turn, degrees, beyond which a facet crosses the cut at which a seat is unrolled.
_ACROSS = 180.0
_DRAWN = {"energy": "energy of a cycle, mJ/mm²", "ruiz_2": "σ τδ, MPa²·mm (white: singular)"}


def plot_fretting(path: Path, rubbed: RubbedSurfaces, rod_length: float, title: str) -> None:
    """Draw what rubs in every pair. Raises `PictureError`: the file could not be written."""
    figure = new_figure(12, 3 * len(rubbed.surfaces) + 1)
    panels = figure.subplots(len(rubbed.surfaces), len(_DRAWN), squeeze=False)
    for number, (surface, row) in enumerate(zip(rubbed.surfaces, panels, strict=True)):
        triangles = rubbed.triangles[rubbed.pair == number]
        along, cut = _unrolled(rubbed.points, surface, rod_length)
        if cut:
            triangles = triangles[np.ptp(along[triangles], axis=1) < _ACROSS]
        singular = (rubbed.fields["masked"][triangles] > 0).any(axis=1)
        for axes, (name, words) in zip(row, _DRAWN.items(), strict=True):
            shown, values = triangles[~singular] if name == "ruiz_2" else triangles, rubbed.fields[name]
            axes.set(xlim=(along[triangles].min(), along[triangles].max()))
            if len(shown):
                drawn = axes.tripcolor(
                    along, rubbed.points[:, 2], shown, values, shading="gouraud", cmap="magma_r", vmin=0,
                    vmax=float(values[shown].max()) or 1.0,
                )  # fmt: skip
                figure.colorbar(drawn, ax=axes)
            else:
                axes.text(0.5, 0.5, "singular everywhere on this mesh", ha="center", transform=axes.transAxes)
            axes.set_title(f"{PAIRS[surface]}: {words}", fontsize=10)
            label_axes(axes, "angle from the rod's axis, °" if cut else "along the joint, mm", "z, mm")
    figure.suptitle(f"{title}: fretting over the crank cycle", fontsize=11)
    save(figure, path, 100)


def _unrolled(points: Floats, surface: Surface, rod_length: float) -> tuple[Floats, bool]:
    """Angle about the axis of a seat, degrees, or distance along the joint, mm; whether it is an angle."""
    x, y, _ = points.T
    if surface is Surface.JOINT:
        return np.copysign(np.hypot(x, y), y), False
    return np.degrees(np.arctan2(y, x - (rod_length if surface is Surface.BUSHING_SEAT else 0.0))), True
