"""`fea init`."""

from importlib import resources
from pathlib import Path

from rich.console import Console

from geometry.invalid import InvalidValue, require


def init(file: Path = Path("study.toml")) -> None:
    """Write a commented study to edit.

    Parameters
    ----------
    file
        The file to write (.toml); one that exists is never overwritten.
    """
    require(not file.is_dir(), "FILE", str(file), "is a directory", "Name a file.")
    if not file.suffix:
        file = file.with_suffix(".toml")
    text = (resources.files("fea") / "studies" / "template.toml.txt").read_text(encoding="utf-8")
    try:
        with file.open("x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        raise InvalidValue(
            "FILE", str(file), "exists and is never overwritten", "Name another file."
        ) from None
    except FileNotFoundError:
        raise InvalidValue("FILE", str(file), "lies in a directory that does not exist") from None
    console = Console(soft_wrap=True, highlight=False)
    console.print(f"Wrote {file}. Edit it, then: fea run {file}", markup=False)
