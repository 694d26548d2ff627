"""The commented study of an engine of the library, with a parametric rod of the engine's length."""

from pathlib import Path
from typing import Any

from fea.analysis.rod_report import fitted
from fea.study.documents import commented, template
from fea.study.engine_library import EnginePreset, Figure, engine_preset
from fea.study.files import toml_text
from fea.study.rod_table import LEAST, MASS_KEYS, rod_of_kind
from fea.study.study import parse_study
from geometry.dimensions import dimensions, key

_MATERIAL = """[material]
preset = "forged-steel-2005"  # not published for this engine: assumed
"""
# Adjusted to what is published of the rod's mass: as many as there can be targets.
_FREE = ("big_end_ring_mm", "small_end_ring_mm", "shank_width_mm")
# Keys that say how much charge the engine has, where its figures do not.
_CHARGE = {"boost_bar", "intake_pressure_bar", "atmosphere_bar", "gas_scale", "full_load"}
_COMMENT = 27  # the column where comments begin


def engine_study(name: str, kind: str | None = None, **given: Any) -> str:
    """Return a study of an engine of the library as TOML that runs as it is, with the source of every figure.

    The rod has the length of the engine's own. Its other dimensions follow in usual proportions from its
    bores, and are fitted to what is published of its mass; or they are those of a `kind` of rod, with a cap,
    whose length, bores, mm, and thread may be `given` as for `fea.study.rod_table.rod_of_kind`. Raises
    `InvalidValue`: there is no engine or no kind of that name, or a dimension breaks a rule.
    """
    preset, text = engine_preset(name, "--engine"), template()
    head = text[: text.index("\n\n")]
    cited = "".join(f"# {key}: {source}\n" for key, source in preset.sources.items())
    head = f"{head}\n# `fea init` without an engine writes a study that explains every key."
    title = f"{head}\n\n# {preset.title}\n# Sources, by the names that stand beside the figures:\n{cited}"
    speed = f"[speed]\n{_line('rpm', preset.redline, 'redline, ')}\n"
    rest = text[text.index("[mesh]\n") :]
    rod = [_rod(preset), _MATERIAL] if kind is None else [_of_kind(preset, kind, given)]
    return "\n".join((title, *rod, _engine(preset), speed, rest))


def _rod(preset: EnginePreset) -> str:
    bores = "".join(f"{_line(key, preset.rod[key])}\n" for key in LEAST)
    targets = {key: preset.rod[key] for key in MASS_KEYS if key in preset.rod and not preset.rod[key].assumed}
    if not targets:
        said = "# Not published, and assumed: all other dimensions follow from these in usual proportions.\n"
        return f"[rod]\n{bores}{said}"
    goals = "".join(f"{_line(f'# {key}', figure)}\n" for key, figure in targets.items())
    start = parse_study(f"[rod]\n{bores}\n{_MATERIAL}", preset.name, Path())
    goal = [float(targets[key].value) if key in targets else None for key in MASS_KEYS]
    table, found = fitted(start, _FREE, *goal)
    rest = {
        key: value if isinstance(value, str) else float(f"{value:.6g}")
        for key, value in table.as_dict().items()
        if key not in LEAST
    }
    said = f"# These are published as well; {found.text()} with the dimensions below, which are assumed:\n"
    return f"[rod]\n{bores}{said}{goals}{toml_text(rest)}"


def _of_kind(preset: EnginePreset, kind: str, given: dict[str, Any]) -> str:
    own = {name.removesuffix("_mm"): float(preset.rod[name].value) for name in LEAST}
    made = rod_of_kind(kind, **own | {name: value for name, value in given.items() if value is not None})
    kept = {key(name): float(f"{getattr(made.rod, name):.6g}") for name in dimensions()}
    rows = {name: value for name, value in kept.items() if value} | {"shank_section": made.rod.shank_section}
    return (
        f"# {made.title}; dimensions in this program's proportions of the kind, not a maker's.\n"
        f"[rod]\n{toml_text(rows)}\n"
        f'[material]\npreset = "{made.material}"\n\n'
        f'[assembly]\nbolt_thread = "{made.thread.name}"\nbolt_grade = "{made.grade}"\n'
        f"bolt_engaged_mm = {1.25 * made.thread.diameter:.4g}\n"
    )


def _engine(preset: EnginePreset) -> str:
    figures = "".join(f"{_line(f'# {key}', figure)}\n" for key, figure in preset.engine.items())
    said = "# It stands for these figures. A key that is written here as well overrides its figure.\n"
    more = commented("engine", _CHARGE - preset.engine.keys())
    charge = "# Boost and full load; with boost or fuel the peak pressure is computed, unless it is given.\n"
    return f'[engine]\npreset = "{preset.name}"\n{said}{figures}{charge}{more}'


def _line(key: str, figure: Figure, what: str = "") -> str:
    assumed = "assumed: " if figure.assumed else ""
    entry = f"{key} = {toml_text({'x': figure.value}).removeprefix('x = ').rstrip()}"
    return f"{entry:<{_COMMENT - 1}} # {what}{assumed}{figure.origin}"
