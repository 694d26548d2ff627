"""What `fea` writes, right and spoiled, and what it reads: run.py calls this in the environment of `fea`.

`our_files.py write FOLDER` makes a run, its exports, what is known of them (`known.json`), and the same with
each fault of `rows.FAULTS`. `our_files.py read` takes items of judges as lines of JSON and prints rows.
"""

import contextlib
import io
import json
import re
import shutil
import sys
from dataclasses import asdict, replace
from pathlib import Path

import gmsh
import numpy as np
import pyvista as pv
from rows import FAULTS, Item, Row, row, volumes

from fea.__main__ import call
from fea.apps import export_run
from fea.output.stored_run import read_run
from fea.study.traces import read_trace
from geometry.errors import InvalidValue
from geometry.session import session
from geometry.surfaces import Surface
from mesh.files.given import named_mesh
from mesh.tetmesh import TET_TURN, TetMesh

EXPORTS = ("med", "bdf", "msh", "vtk", "xdmf", "stl", "ply", "inp")
RUN = ("run", "leon-2001", "--pressure", "cosine-180", "--size", "12", "--tolerance", "0", "--quiet")
# The exports that a fault of the mesh or its fields changes.
SPOILED = {
    **dict.fromkeys(("scaled", "lost"), EXPORTS),
    **dict.fromkeys(("turned", "middles"), ("med", "bdf", "msh", "vtk", "xdmf")),
    "tensor": ("med", "msh", "vtk", "xdmf"),
    "names": ("med", "msh"),
}
BAR, DEG = 0.1, np.pi / 180  # MPa, rad


def spoiled(fault: str, mesh: TetMesh, points: dict[str, np.ndarray]) -> TetMesh:
    """Return a mesh with a fault, and give its nodal arrays one."""
    tets = mesh.tets.copy()
    if fault == "turned":
        return replace(mesh, tets=tets[:, TET_TURN[10]])
    if fault == "middles":
        return replace(mesh, tets=tets[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]])
    if fault == "scaled":
        return replace(mesh, points=mesh.points * 1.01)
    if fault == "lost":  # one with a node of its own
        alone = np.flatnonzero((np.bincount(tets.ravel())[tets] == 1).any(axis=1))[0]
        return replace(mesh, tets=np.delete(tets, alone, axis=0))
    if fault == "tensor":
        for name in points:
            if name.endswith("stress"):
                points[name] = points[name][:, [0, 1, 2, 3, 5, 4]]
    if fault == "names" and mesh.facets:
        facets = dict(mesh.facets)
        big, small = Surface.BIG_END_BORE, Surface.SMALL_END_BORE
        facets[big], facets[small] = facets[small], facets[big]
        return replace(mesh, facets=facets)
    return mesh


def known(folder: Path) -> dict[str, object]:
    """Return what readers must find in the files of a run."""
    run = read_run(folder / "run")
    mesh, _ = named_mesh(run.mesh, (None, None))
    fields = run.fields["tension"]
    node = int(fields["von_mises"].argmax())
    moved = {name: float(np.abs(each["displacement"]).max()) for name, each in run.fields.items()}
    return {
        "nodes": len(mesh.points),
        "elements": len(mesh.tets),
        "volume_mm3": float(volumes(mesh.points, mesh.tets).sum()),
        "at_mm": mesh.points[node].tolist(),
        "stress_MPa": fields["stress"][node].tolist(),
        "displaced_mm": moved,
        "surfaces": {name.value: len(facets) for name, facets in mesh.facets.items()},
        "bore_nodes": len(np.unique(mesh.facets[Surface.BIG_END_BORE])),
        "step_mm3": _figures(["leon-2001"])["volume_mm3"],
    }


def _figures(arguments: list[str]) -> dict[str, float]:
    """What `fea rod --json` prints. Raises `ValueError`: it ends with an error."""
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = call(["rod", *arguments, "--json"])
    if code:
        raise ValueError(" ".join(err.getvalue().split()))
    return json.loads(out.getvalue())


def write(folder: Path) -> None:
    """Write the run, its exports and its solid; then all of them with each fault."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "run" / "summary.json").is_file():
        call([*RUN, "--out", str(folder / "run")])
    call(["rod", "leon-2001", "--step", str(folder / "rod.step"), "--quiet"])
    (folder / "known.json").write_text(json.dumps(known(folder)))
    plain = export_run.write_mesh
    for fault in ("", *FAULTS):
        place = folder / "spoiled" / fault if fault else folder
        place.mkdir(parents=True, exist_ok=True)

        def written(path, mesh, points, cells, fault=fault):
            mesh = spoiled(fault, mesh, points)
            return plain(path, mesh, points, {name: cells[name][: len(mesh.tets)] for name in cells})

        export_run.write_mesh = written
        for ending in EXPORTS[:-1] if fault else EXPORTS:
            if ending in SPOILED.get(fault, "" if fault else EXPORTS):
                export_run.export_run(folder / "run", place / f"run.{ending}")
                continue
            for other in (ending, "h5") if ending == "xdmf" else (ending,):
                shutil.copy(folder / f"run.{other}", place)
        _as_text(place / "run.msh")
        if fault:
            _spoil_others(fault, folder, place)


def _as_text(path: Path) -> None:
    """Convert a gmsh file to text in gmsh, for programs that read no binary ones: Netgen."""
    with session():
        gmsh.open(str(path))
        gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
        gmsh.write(str(path.with_name("run-text.msh")))


def _spoiled_deck(fault: str, deck: str) -> str:
    """Give the nodes and elements of an Abaqus deck a fault, and leave the rest as it is."""
    heads = "*NODE, NSET=NALL\n", "*ELEMENT, TYPE=C3D10, ELSET=EALL\n", "*NSET"
    before, nodes, elements, after = re.split("|".join(map(re.escape, heads)), deck, maxsplit=3)
    points = np.loadtxt(nodes.split(), delimiter=",")[:, 1:]
    mesh = spoiled(fault, TetMesh(points, np.loadtxt(elements.split(), int, delimiter=",")[:, 1:] - 1), {})
    written = io.StringIO(newline="")
    for head, rows, form in ((heads[0], mesh.points, "%.12e"), (heads[1], mesh.tets + 1, "%d")):
        written.write(head)
        numbered = np.column_stack([np.arange(len(rows)) + 1, rows])
        np.savetxt(written, numbered, ["%d", *[form] * rows.shape[1]], ",")
    return f"{before}{written.getvalue()}{heads[2]}{after}"


def _spoil_others(fault: str, folder: Path, place: Path) -> None:
    """Spoil the deck, the series, the VTU files and the solid."""
    (place / "run").mkdir(exist_ok=True)
    deck = (folder / "run.inp").read_text()
    if fault == "names":
        deck = deck.replace("NSET=BIG_END_BORE", "NSET=OTHER")
    elif fault in {"turned", "middles", "scaled", "lost"}:
        deck = _spoiled_deck(fault, deck)
    (place / "run.inp").write_text(deck)
    for path in (folder / "run").glob("*.vtu" if fault == "tensor" else "tension.vtu"):
        grid = pv.read(path)
        arrays = dict(grid.point_data)
        mesh = spoiled(fault, TetMesh(np.asarray(grid.points, float), grid.cells_dict[24]), arrays)
        if fault == "tensor":
            arrays["von_mises"] = 1.01 * arrays["von_mises"]
        other = pv.UnstructuredGrid({24: mesh.tets}, mesh.points)
        other.point_data.update(arrays)
        other.save(place / "run" / path.name)
    series = (folder / "run" / "cases.pvd").read_text()
    (place / "run" / "cases.pvd").write_text(re.sub(r'timestep="', 'timestep="1', series))
    step = (folder / "rod.step").read_text()
    (place / "rod.step").write_text(step.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.CENTI.,.METRE.)"))


def read(item: Item, folder: Path) -> Row:
    """Read a file of another program; return its row."""
    path, refused = folder / item.file, ""
    try:
        if "peak_bar" in item.expected:
            trace = read_trace(path).trace
            found = {
                "peak_bar": float(trace.pressures.max()) / BAR,
                "peak_deg": float(trace.crank_angles[trace.pressures[0].argmax()]) / DEG,
            }
        else:
            found = _figures([str(path), *(word.replace("FOLDER", str(folder)) for word in item.options)])
    except (ValueError, InvalidValue) as error:
        refused, found = str(error).replace(f"{folder}/", "")[:120], {}
    each = [
        row("", "", found.get(name, 0.0), value, "", allowed=item.allowed)
        for name, value in item.expected.items()
    ]
    right = not refused and all(one.right for one in each)
    said = refused or ", ".join(one.found for one in each)
    words = " and ".join(name.replace("_", ", ") for name in item.expected)
    expected = ", ".join(f"{value:.7g}" for value in item.expected.values())
    crossing = f"{item.file} → fea"
    return Row(crossing, f"{item.tried}: {words}", said, f"{expected} ± {item.allowed:g}", right, item.fault)


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(Path(sys.argv[2]))
    else:
        for line in sys.stdin:
            told = json.loads(line)
            place = Path(told.pop("folder"))
            print(json.dumps(asdict(read(Item(**told), place))), flush=True)
