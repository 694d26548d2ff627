"""The endurance limit of every part as a line: that of specimens, its factors, what is left of it."""

from collections.abc import Mapping

from fea.analysis.cycle_figures import CycleFigures, EnduranceFigures, SurfaceFigures
from fea.output.terminal.figures import number


def endurance_lines(envelope: CycleFigures) -> list[str]:
    """Return a line per part, which names the part where there are several."""
    parts = envelope.endurance or {}
    return [_line(f" of {part}" if len(parts) > 1 else "", found) for part, found in parts.items()]


def _line(of_part: str, found: EnduranceFigures) -> str:
    limit = f"{number(found.specimen_MPa, '.4g')} MPa"
    said = f"Endurance limit{of_part}: {limit}{' (estimated)' if found.estimated else ''}"
    factors = {"size": found.size_factor, "load": found.load_factor, "reliability": found.reliability_factor}
    surfaces = found.regions.values()
    if all(factor == 1 for factor in (*factors.values(), *(skin.surface_factor for skin in surfaces))):
        return f"{said}, not reduced for surface, size, load or reliability."
    product = " × ".join(f"{factor:.3g} ({name})" for name, factor in factors.items())
    regions = "; ".join(_region(*item) for item in _alike(found.regions).items())
    return f"{said} × {product} × surface: {regions}."


def _alike(regions: Mapping[str, SurfaceFigures]) -> dict[SurfaceFigures, list[str]]:
    """Gather the names of the regions that are alike."""
    names: dict[SurfaceFigures, list[str]] = {}
    for name, skin in regions.items():
        names.setdefault(skin, []).append(name)
    return names


def _region(skin: SurfaceFigures, names: list[str]) -> str:
    assumed = ", assumed" if skin.assumed else ""
    made = f"{skin.surface_factor:.3g} ({skin.finish}{assumed})"
    return f"{' and '.join(names)} {made} = {number(skin.endurance_MPa, '.4g')} MPa"
