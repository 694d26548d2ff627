"""`fea init`."""

from importlib import resources
from pathlib import Path

from rich.console import Console

from geometry.invalid import InvalidValue, require


def init(file: Path = Path("study.toml")) -> None:
    """Write a study file with comments, ready to edit.

    Parameters
    ----------
    file
        The file to write (.toml); an existing file is never overwritten.
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
            "FILE", str(file), "already exists and is not overwritten", "Name another file."
        ) from None
    except FileNotFoundError:
        rule, remedy = "is in a directory that does not exist", "Create the directory first."
        raise InvalidValue("FILE", str(file), rule, remedy) from None
    console = Console(soft_wrap=True, highlight=False)
    console.print(f"Wrote {file}. Edit it, then run: fea run {file}", markup=False)
