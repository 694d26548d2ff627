# requires: debian:python3-paraview
"""ParaView's pvpython finds our figures by the clicks of docs/do/paraview.md, and writes a mesh in each way.

It reads every run in the folder. Others than that of run.py may be put there, such as one with places that
are left out, and one with oil films:

    fea run leon-2001-bolted --size 12 --out FOLDER/bolted
    fea run leon-2001 --rpm 6000 --size 10 --film --out FOLDER/film
"""

import csv
import json
import math

import numpy as np
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy
from rows import FLAT, judge, mesh, of_mesh, of_stress, row, volumes

WAYS = (("Ascii", "None"), ("Binary", "ZLib"), ("Appended", "None"), ("Appended", "LZMA"))


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
    """Yield the figures of a run."""
    cases = summary["results"] | ({"envelope": summary["envelope"]} if summary.get("envelope") else {})
    for name, case in cases.items():
        file, known = run / f"{name}.vtu", case["max_von_mises_MPa"]
        if file.exists():
            said = f"{run.name}/{name}.vtu → ParaView", "largest stress by the clicks, MPa"
            yield row(*said, largest_stress(file), known, "tensor", allowed=2e-6)
    angles = (-1.0 if load["crank_deg"] is None else load["crank_deg"] for load in summary["loads"].values())
    times = [round(float(time), 3) for time in opened(run / "cases.pvd").TimestepValues]
    said = f"{run.name}/cases.pvd → ParaView", "crank angles as times"
    yield row(*said, times, sorted(round(angle, 3) for angle in angles), "times")
    for end, film in (summary.get("film") or {}).items():
        loads = [*csv.DictReader((run / "loads.csv").read_text(encoding="utf-8").splitlines())]
        axis, place = ("crank", "") if end == "big_end" else ("pin", "_small_end")
        for what in ("h_min", "p_max"):
            (line,) = [line for line in loads if float(line["crank_deg"]) == film[f"{what}_deg"]]
            load = math.hypot(*(float(line[f"{axis}_{way}_N"]) for way in ("axial", "transverse")))
            name = f"film{place}_{what}.vtu"
            said = f"{run.name}/{name} → ParaView", "force of the film, N"
            yield row(*said, force(run / name), load, "scaled", allowed=1e-3)


def reads(folder, known):
    for file, name in (
        ("run/tension.vtu", "stress"),
        ("run.vtk", "tension_stress"),
        ("run.xdmf", "tension_stress"),
    ):
        crossing, data = f"{file} → ParaView", servermanager.Fetch(opened(folder / file))
        points = vtk_to_numpy(data.GetPoints().GetData())
        cells = vtk_to_numpy(data.GetCells().GetConnectivityArray()).reshape(-1, 10)
        yield from of_mesh(crossing, known, points, cells)
        stress = vtk_to_numpy(data.GetPointData().GetArray(name))
        yield of_stress(
            crossing, known, points, stress[:, [0, 4, 8, 1, 5, 2]] if stress.shape[1] == 9 else stress
        )
    for ending in ("stl", "ply"):
        skin = servermanager.Fetch(simple.Clean(Input=opened(folder / f"run.{ending}")))
        points = vtk_to_numpy(skin.GetPoints().GetData()).astype(float)
        corners = points[vtk_to_numpy(skin.GetPolys().GetConnectivityArray()).reshape(-1, 3)]
        volume = np.einsum("ni,ni", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        said = f"run.{ending} → ParaView", "volume, mm³"
        yield row(*said, volume, known["volume_mm3"], "scaled", allowed=FLAT)
    for path in sorted(folder.glob("*/cases.pvd")):
        summary = path.parent / "summary.json"
        if not summary.exists():  # of a spoiled run
            summary = folder.parents[1] / path.parent.name / "summary.json"
        yield from of_run(path.parent, json.loads(summary.read_text(encoding="utf-8")))


def writes(folder, size):
    source = opened(folder.parents[1] / "run" / "tension.vtu")
    data = servermanager.Fetch(source)
    points, cells = data.GetPoints().GetData(), data.GetCells().GetConnectivityArray()
    volume = volumes(vtk_to_numpy(points), vtk_to_numpy(cells).reshape(-1, 10)).sum()
    scaled = simple.Transform(Input=source)
    scaled.Transform.Scale = [size] * 3
    ways = {f"{mode}-{pack}.vtu": {"DataMode": mode, "CompressorType": pack} for mode, pack in WAYS}
    ways |= {f"{kind}.vtk": {"FileType": kind} for kind in ("Ascii", "Binary")}
    for name, options in ways.items():
        simple.SaveData(str(folder / name), proxy=scaled, **options)
        yield mesh(name, ", ".join(options.values()), volume)


judge(str(simple.GetParaViewSourceVersion()).removeprefix("paraview version "), reads, writes)
