# requires: debian:python3-paraview
"""ParaView's pvpython: finds our figures by the clicks of docs/do/paraview.md, and writes one mesh in each way.

It reads every run in the folder. Others than that of run.py may be put there, such as one with places that are left
out, and one with oil films:

    fea run leon-2001-bolted --size 12 --out FOLDER/bolted
    fea run leon-2001 --rpm 6000 --size 10 --film --out FOLDER/film
"""

import csv
import json
import math
from pathlib import Path

import numpy as np
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy
from rows import Item, judge, of_mesh, of_stress, row, volumes


def opened(path):
    reader = simple.OpenDataFile(str(path))
    reader.UpdatePipeline()
    return reader


def largest_stress(path):
    """The largest von Mises stress of what counts: Calculator, then the range of its result."""
    reader = opened(path)
    masked = reader.GetPointDataInformation().GetArray("masked") is not None
    function = "von_mises*(1-masked)" if masked else "von_mises"
    found = simple.Calculator(Input=reader, Function=function, ResultArrayName="Result")
    found.UpdatePipeline()
    return found.PointData["Result"].GetRange()[1]


def force(path):
    """Of the pressure of a film over its bore: Integrate Variables."""
    surface = simple.ExtractSurface(Input=opened(path))
    normals = simple.GenerateSurfaceNormals(Input=surface, ComputeCellNormals=1, FeatureAngle=180)
    means = simple.PointDatatoCellData(Input=normals, ProcessAllArrays=1)
    pressing = simple.Calculator(
        Input=means, AttributeType="Cell Data", Function="film_pressure*Normals", ResultArrayName="pressing"
    )
    total = simple.IntegrateVariables(Input=pressing)
    total.UpdatePipeline()
    return math.hypot(*(total.CellData["pressing"].GetRange(axis)[0] for axis in range(3)))


def of_run(run, summary):
    """Yield the figures of a run, each with the relative difference that is allowed."""
    results = {name: case["max_von_mises_MPa"] for name, case in summary["results"].items()}
    if summary.get("envelope"):
        results["envelope"] = summary["envelope"]["max_von_mises_MPa"]
    for name, stress in results.items():
        file = run / f"{name}.vtu"
        if file.exists():
            said = f"{run.name}/{name}.vtu → ParaView", "largest stress by the clicks, MPa"
            yield row(*said, largest_stress(file), stress, "scaled", 2e-6)
    angles = sorted(-1.0 if load["crank_deg"] is None else load["crank_deg"] for load in summary["loads"].values())
    found = [round(float(time), 3) for time in opened(run / "cases.pvd").TimestepValues]
    expected = [round(angle, 3) for angle in angles]
    yield row(f"{run.name}/cases.pvd → ParaView", "crank angles as times", found, expected, "times")
    for end, film in (summary.get("film") or {}).items():
        loads = [*csv.DictReader((run / "loads.csv").read_text(encoding="utf-8").splitlines())]
        axis, place = ("crank", "") if end == "big_end" else ("pin", "_small_end")
        for what in ("h_min", "p_max"):
            (line,) = [line for line in loads if float(line["crank_deg"]) == film[f"{what}_deg"]]
            load = math.hypot(*(float(line[f"{axis}_{way}_N"]) for way in ("axial", "transverse")))
            file = f"film{place}_{what}.vtu"
            yield row(f"{run.name}/{file} → ParaView", "force of the film, N", force(run / file), load, "", 1e-3)


def reads(folder, known):
    for ending, name in (("vtu", "stress"), ("vtk", "tension_stress"), ("xdmf", "tension_stress")):
        file = folder / ("run/tension.vtu" if ending == "vtu" else f"run.{ending}")
        crossing, data = f"{file.relative_to(folder)} → ParaView", servermanager.Fetch(opened(file))
        points = vtk_to_numpy(data.GetPoints().GetData())
        cells = vtk_to_numpy(data.GetCells().GetConnectivityArray()).reshape(-1, 10)
        yield from of_mesh(crossing, known, points, cells)
        stress = vtk_to_numpy(data.GetPointData().GetArray(name))
        if stress.shape[1] == 9:
            stress = stress[:, [0, 4, 8, 1, 5, 2]]
        yield from of_stress(crossing, known, points, stress)
    for ending in ("stl", "ply"):
        file = opened(folder / f"run.{ending}")
        merged = simple.Clean(Input=file)
        whole = servermanager.Fetch(simple.Triangulate(Input=merged))
        points = vtk_to_numpy(whole.GetPoints().GetData()).astype(float)
        corners = points[vtk_to_numpy(whole.GetPolys().GetConnectivityArray()).reshape(-1, 3)]
        volume = np.einsum("ni,ni", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        said = f"run.{ending} → ParaView", "volume in its triangles, mm³"
        yield row(*said, volume, known["volume_mm3"], "scaled", 2e-3)
    for path in sorted(Path(folder).glob("*/cases.pvd")):
        summary = json.loads((folder / ".." / ".." / "run" / "summary.json" if "spoiled" in path.parts
                              else path.parent / "summary.json").read_text(encoding="utf-8"))  # fmt: skip
        yield from of_run(path.parent, summary)


def writes(folder, spoil):
    source = opened(folder.parents[1] / "run" / "tension.vtu")
    data = servermanager.Fetch(source)
    points = vtk_to_numpy(data.GetPoints().GetData())
    volume = volumes(points, vtk_to_numpy(data.GetCells().GetConnectivityArray()).reshape(-1, 10)).sum()
    moved = simple.Transform(Input=source)
    moved.Transform.Scale = [1.01 if spoil else 1.0] * 3
    ways = [
        *((f"{mode}-{pack}.vtu".lower(), {"DataMode": mode, "CompressorType": pack})
          for mode, pack in (("Ascii", "None"), ("Binary", "ZLib"), ("Appended", "None"), ("Appended", "LZMA"))),
        *((f"{kind}.vtk".lower(), {"FileType": kind}) for kind in ("Ascii", "Binary")),
    ]  # fmt: skip
    for name, options in ways:
        simple.SaveData(str(folder / name), proxy=moved, **options)
        tried = ", ".join(f"{value}" for value in options.values())
        yield Item(name, tried, "scaled", {"volume_mm3": volume, "length_mm": 141.0}, 1e-4)


judge(str(simple.GetParaViewSourceVersion()).removeprefix("paraview version "), reads, writes)
