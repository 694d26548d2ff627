"""`fea view`."""

from pathlib import Path

from rich.console import Console


def view(file: Path, *, field: str | None = None, out: Path | None = None) -> None:
    """Draw a result: a load case, the envelope of the crank cycle, or a buckling or vibration mode.

    Parameters
    ----------
    file
        The .vtu file of a run or of `fea modes`.
    field
        Field to draw. Load case: von_mises, principal_1, principal_3, safety_factor or displacement;
        envelope.vtu: also mean, amplitude, fatigue_safety_factor or crossland_safety_factor; modes: mode_1,
        mode_2, …. Default: the first of these that the file has.
    out
        The .png file to write; default: next to the result.
    """
    from fea.output.pictures.picture import picture_of
    from fea.output.target import require_target

    require_target("--out", out, (".png",))
    picture = picture_of(file, out or file.with_suffix(".png"), field)
    Console(soft_wrap=True, highlight=False).print(f"Wrote {picture}", markup=False)
