"""`fea view`."""

from pathlib import Path

from rich.console import Console


def view(file: Path, *, field: str | None = None, out: Path | None = None) -> None:
    """A picture of a result: a load case, the crank cycle's envelope, a mode of buckling or vibration.

    Parameters
    ----------
    file
        The .vtu file of a run or of `fea modes`.
    field
        What the colours show: von_mises, principal_1, principal_3, safety_factor or displacement of a load
        case; also mean, amplitude, fatigue_safety_factor or crossland_safety_factor of an envelope.vtu;
        mode_1, mode_2, … of modes. By default the first of these that the file has.
    out
        The .png file to write; beside the result by default.
    """
    from fea.output.pictures.picture import picture_of
    from fea.output.target import require_target

    require_target("--out", out, (".png",))
    picture = picture_of(file, out or file.with_suffix(".png"), field)
    Console(soft_wrap=True, highlight=False).print(f"Wrote {picture}", markup=False)
