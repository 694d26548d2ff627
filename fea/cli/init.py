"""`fea init`, `fea materials`, `fea schema` and `fea doctor`: what precedes a first run."""

import sys
from pathlib import Path

from fea.base.units import with_power
from fea.cli.options import Json, print_json, print_written
from fea.output.folder import require_target, write_text
from fea.output.json_file import json_text
from fea.output.terminal.prose import plain_table, terminal
from fea.study.documents import SCHEMA_FILE, is_schema, study_schema, template
from fea.study.tables import number_of, unit_of
from geometry.errors import InvalidValue, require, require_positive


def init(
    file: Path = Path("study.toml"),
    *,
    engine: str | None = None,
    kind: str | None = None,
    length: float | str | None = None,
    big_end_bore: float | str | None = None,
    small_end_bore: float | str | None = None,
    thread: str | None = None,
) -> None:
    """Write a study file with comments, ready to edit.

    Parameters
    ----------
    file
        The file to write (.toml); an existing file is never overwritten.
    engine
        Write the study of an engine of the library, by name or alias: toyota-2jz, k20, …; any other name
        lists all.
    kind
        Give the engine a rod of this kind, with cap and bolts: h-beam or i-beam.
    length
        Distance of the bores of that rod, mm or with a unit; by default as in the engine, like the bores.
    big_end_bore
        Diameter, without shells.
    small_end_bore
        Diameter, of the bushing.
    thread
        Of its bolts: 3/8-24 UNF, M9x1, …
    """
    require_target("FILE", file, (file.suffix.lower(),))
    if not file.suffix:
        file = file.with_suffix(".toml")
    if engine is None:
        require(kind is None, "--kind", kind, "needs an engine", "Add --engine NAME.")
        text = template()
    else:
        from fea.analysis.engine_study import engine_study

        lengths = {"length": length, "big_end_bore": big_end_bore, "small_end_bore": small_end_bore}
        given = {
            name: require_positive(flag := f"--{name.replace('_', '-')}", number_of(flag, value, "length_mm"))
            for name, value in lengths.items()
            if value is not None
        }
        rule, remedy = "is missing, and length, bores and thread belong to it", "Add --kind h-beam."
        require(kind is not None or not (given or thread), "--kind", None, rule, remedy)
        text = engine_study(engine, kind, **given, thread=thread)
    try:
        with file.open("x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        rule = "already exists and is not overwritten"
        raise InvalidValue("FILE", str(file), rule, "Name another file.") from None
    sys.stdout.write(f"Wrote {file}. Edit it, then run: fea run {file}\n")
    if schema := _schema_beside(file):
        sys.stdout.write(f"Wrote {schema}, from which editors complete and check the keys.\n")


def _schema_beside(study: Path) -> Path | None:

    path = study.parent / SCHEMA_FILE
    if path.exists() and not is_schema(path.read_text(encoding="utf-8", errors="replace")):
        return None
    write_text(path, json_text(study_schema()))
    return path


def materials(name: str | None = None, /, *, json: Json = False) -> None:
    """List the materials of the library, or show one with the source of each figure.

    Parameters
    ----------
    name
        A material, by one of its names.
    """
    from fea.study.material_table import LIBRARY, library_material

    shown = list(LIBRARY.values()) if name is None else [library_material("NAME", name)]
    if json:
        print_json([vars(material) | {"temperature_C": 20.0, "stress_ratio": -1.0} for material in shown])
        return
    if name is None:
        sys.stdout.write(_ROW.format("", "E", "yield", "ultimate", "endurance", "cycles", "also"))
        for material in shown:
            cells = (
                with_power(f"{material.figures[key]:g}") if key in material.figures else "–"
                for key in _LISTED
            )
            sys.stdout.write(_ROW.format(material.name, *cells, ", ".join(material.also)))
    else:
        (material,) = shown
        sys.stdout.write(
            f"{material.name}: {material.title}{''.join(f'; {also}' for also in material.also)}\n"
        )
        for key, value in material.figures.items():
            words, unit = unit_of(key)
            sys.stdout.write(f"  {words}: {with_power(f'{value:g}')} {unit}".rstrip() + "\n")
        sys.stdout.write(f"Source: {material.source}\n")
    sys.stdout.write(_CONDITIONS)


_LISTED = ("E_GPa", "yield_MPa", "ultimate_MPa", "endurance_MPa", "endurance_cycles")
_ROW = "{:<21}{:>6}{:>7}{:>10}{:>11}{:>8}  {}\n"
_CONDITIONS = """
GPa and MPa at room temperature. Endurance: polished specimens, R = -1; for those cycles where the metal has
no limit. A steel without one gets 0.425 times its ultimate strength. `fea materials NAME` gives sources.
"""


def schema(*, out: Path | None = None) -> None:
    """Print the JSON Schema of a study, for editors and other programs.

    Parameters
    ----------
    out
        The .json file to write it to instead.
    """
    require_target("--out", out, (".json",))
    if out is None:
        print_json(study_schema())
    else:
        write_text(out, json_text(study_schema()))
        print_written([out])


def doctor(*, json: Json = False) -> int:
    """Check what this machine needs to run fea, and what is installed."""
    from fea.machine.doctor import examine

    findings = examine()
    ready = all(finding.good or not finding.needed for finding in findings)
    if json:
        print_json([vars(finding) for finding in findings])
    else:
        headings = ["", "what", "found", *(["remedy"] if not all(each.good for each in findings) else [])]
        marks = ["ok" if each.good else "missing" if each.needed else "no" for each in findings]
        cells = [(each.what, each.found, "" if each.good else each.remedy) for each in findings]
        rows = ((mark, *texts)[: len(headings)] for mark, texts in zip(marks, cells, strict=True))
        console, missing = terminal(), "Something that fea needs is missing: see the remedies above."
        console.print(plain_table(headings, rows, left=headings))
        console.print("Everything that fea needs is installed." if ready else missing)
    return 0 if ready else 7
