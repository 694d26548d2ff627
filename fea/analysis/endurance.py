"""From the limit of polished specimens to that of every region of a part's surface."""

from collections.abc import Iterable, Sequence

from fea.analysis.cycle_figures import EnduranceFigures, SurfaceFigures
from fea.material import Material


def endurance_figures(parts: Iterable[str], materials: Sequence[Material]) -> dict[str, EnduranceFigures]:
    """Return the factors of every part, by its name, whose endurance limit is known."""
    return {
        part: _of_part(material, material.endurance_limit)
        for part, material in zip(parts, materials, strict=True)
        if material.endurance_limit is not None
    }


def _of_part(material: Material, limit: float) -> EnduranceFigures:
    marin = material.marin
    return EnduranceFigures(
        specimen_MPa=limit / (marin.size * marin.load * marin.reliability),
        estimated=material.endurance_estimated,
        size_factor=marin.size,
        load_factor=marin.load,
        reliability_factor=marin.reliability,
        regions={
            region.value: SurfaceFigures(
                finish=skin.finish,
                surface_factor=skin.factor,
                endurance_MPa=limit * skin.factor,
                assumed=skin.assumed or None,
            )
            for region, skin in marin.surfaces.items()
        },
    )
