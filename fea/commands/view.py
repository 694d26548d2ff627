"""`fea view`."""

from pathlib import Path

from rich.console import Console


def view(file: Path, *, out: Path | None = None) -> None:
    """A picture of a result.

    Parameters
    ----------
    file
        The .vtu file of a run.
    out
        The .png file to write; beside the result by default.
    """
    from fea.pictures.picture import picture_of

    picture = picture_of(file, out or file.with_suffix(".png"))
    Console(soft_wrap=True, highlight=False).print(f"Wrote {picture}", markup=False)
