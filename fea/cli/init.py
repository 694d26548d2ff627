"""`fea init`."""

from pathlib import Path

from rich.console import Console

from fea.cli.options import print_json
from geometry.errors import InvalidValue, require


def init(file: Path = Path("study.toml"), *, engine: str | None = None) -> None:
    """Write a study file with comments, ready to edit.

    Parameters
    ----------
    file
        The file to write (.toml); an existing file is never overwritten.
    engine
        Write the study of an engine of the library: toyota-2jz, jeep-4.0, …; any other name lists all.
    """
    from fea.study.documents import template

    require(not file.is_dir(), "FILE", str(file), "is a directory", "Name a file.")
    if not file.suffix:
        file = file.with_suffix(".toml")
    if engine is None:
        text = template()
    else:
        from fea.run.engine_study import engine_study

        text = engine_study(engine)
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
    if schema := _schema_beside(file):
        console.print(f"Wrote {schema}, from which editors complete and check the keys.", markup=False)


def _schema_beside(study: Path) -> Path | None:
    """Write the schema that the study's first line names, unless a file of the user's has that name."""
    from fea.output.json_file import json_text
    from fea.output.text import write_text
    from fea.study.documents import SCHEMA_FILE, is_schema, study_schema

    path = study.parent / SCHEMA_FILE
    if path.exists() and not is_schema(path.read_text(encoding="utf-8", errors="replace")):
        return None
    write_text(path, json_text(study_schema()))
    return path


def schema() -> None:
    """Print the JSON Schema of a study, for editors and other programs."""
    from fea.study.documents import study_schema

    print_json(study_schema())
