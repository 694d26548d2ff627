"""`fea init`, `fea schema` and `fea doctor`: what precedes a first run."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from fea.cli.options import Json, print_json
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
        from fea.analysis.engine_study import engine_study

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


def doctor(*, json: Json = False) -> int:
    """Check what this machine needs to run fea, and what is installed."""
    from fea.machine.doctor import examine

    findings = examine()
    ready = all(finding.good or not finding.needed for finding in findings)
    if json:
        print_json([vars(finding) for finding in findings])
    else:
        console = Console(highlight=False)
        table = Table(box=None, pad_edge=False)
        headings = ["", "what", "found"]
        if not all(finding.good for finding in findings):
            headings.append("remedy")
        for heading in headings:
            table.add_column(heading, overflow="fold")
        for finding in findings:
            mark = "ok" if finding.good else "missing" if finding.needed else "no"
            cells = (mark, finding.what, finding.found, "" if finding.good else finding.remedy)
            table.add_row(*cells[: len(table.columns)])
        console.print(table)
        missing = "Something that fea needs is missing: see the remedies above."
        console.print("Everything that fea needs is installed." if ready else missing)
    return 0 if ready else 7
