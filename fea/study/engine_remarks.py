"""Remarks on an engine of the library: what is assumed of it, and where a study departs from it."""

import math

from fea.study.engine_presets import EnginePreset
from fea.study.engine_table import EngineTable

_SAME_LENGTH = 2e-3  # relative difference up to which two rods count as equally long
# The gas models that need a key; the others do without.
_NEEDED_BY = {"compression_ratio": {"boyle", "otto", "motored"}, "peak_pressure_bar": {"otto"}}


def engine_remarks(table: EngineTable, rod_length: float, rpm: float) -> list[str]:
    """Return remarks on an engine of the library; none on other engines.

    Parameters
    ----------
    table
        What the study says of its engine.
    rod_length
        Of the study's rod, mm.
    rpm
        Engine speed.
    """
    preset = table.library()
    if preset is None:
        return []
    said = []
    if assumed := _assumed(table, preset):
        said.append(f"engine {preset.name}: assumed are {', '.join(assumed)}")
    if not math.isclose(rod_length, preset.rod_length, rel_tol=_SAME_LENGTH):
        own = f"the rod of the {preset.name} engine is {preset.rod_length:g} mm long"
        said.append(f"{own}, the one of this study {rod_length:.4g} mm")
    if rpm > preset.redline_rpm:
        limit = f"the redline of the {preset.name} engine, {preset.redline_rpm:g} rpm"
        said.append(f"{rpm:g} rpm is above {limit}")
    return said


def layout_remarks(table: EngineTable) -> list[str]:
    """Return what the sums over all cylinders leave out if the engine is not an in-line one."""
    preset = table.library()
    if preset is None or preset.layout == "in-line" or table.cylinders == 1:
        return []
    summed = f"the shaking forces of the whole engine are those of {table.cylinders} cylinders in line"
    real = f"the {preset.name} engine is of {preset.layout} layout"
    return [f"{summed}, but {real}; the torque does not depend on the layout"]


def _assumed(table: EngineTable, preset: EnginePreset) -> list[str]:
    """Estimates that a study takes from the library, each with what it rests on."""
    used = {
        key: figure
        for key, figure in preset.engine.items()
        if figure.assumed and getattr(table, key) == figure.value
        if table.gas in _NEEDED_BY.get(key, {table.gas})
    }
    return [
        f"{key} = {value if isinstance(value, str) else f'{value:g}'} ({origin})"
        for key, (value, origin, _) in used.items()
    ]
