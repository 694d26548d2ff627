"""`fea export`."""

import sys
from pathlib import Path


def export(run: Path, file: Path, *, json: bool = False, quiet: bool = False) -> None:
    """Write a run for another program: a CalculiX deck with its loads, or its mesh with the results.

    Parameters
    ----------
    run
        The folder of a run at one speed, such as results/leon-2001-6000rpm.
    file
        The file to write. .inp: a deck for CalculiX and Abaqus with every load case as a step; .vtu, .vtk,
        .xdmf, .msh, .med: mesh and results; .bdf, .nas: the mesh; .stl, .ply: its surface.
    json
        Print what was written as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.runs.export_run import export_run

    made = export_run(run, file)
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text({"files": [str(path) for path in made.files], "notes": list(made.notes)}))
    elif not quiet:
        for path in made.files:
            sys.stdout.write(f"Wrote {path}\n")
        for note in made.notes:
            sys.stdout.write(f"Note: {note}.\n")
