# requires: debian:python3-paraview
"""ParaView's pvpython finds our figures by the clicks of docs/do/paraview.md, and writes a mesh."""

import json

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


def of_run(run, summary):
    for name, case in summary["results"].items():
        if (run / f"{name}.vtu").exists():
            said, known = "largest stress by the clicks, MPa", case["max_von_mises_MPa"]
            found = largest_stress(run / f"{name}.vtu")
            yield row(f"run/{name}.vtu → ParaView", said, found, known, "tensor", allowed=2e-6)
    angles = sorted(round(load["crank_deg"], 3) for load in summary["loads"].values())
    times = [round(float(time), 3) for time in opened(run / "cases.pvd").TimestepValues]
    yield row("run/cases.pvd → ParaView", "crank angles as times", times, angles, "times")


def reads(folder, known):
    for file in ("run/tension.vtu", "run.vtk", "run.xdmf"):
        crossing, data = f"{file} → ParaView", servermanager.Fetch(opened(folder / file))
        points = vtk_to_numpy(data.GetPoints().GetData())
        cells = vtk_to_numpy(data.GetCells().GetConnectivityArray()).reshape(-1, 10)
        yield from of_mesh(crossing, known, points, cells)
        stress = vtk_to_numpy(data.GetPointData().GetArray("stress" if "/" in file else "tension_stress"))
        stress = stress[:, [0, 4, 8, 1, 5, 2]] if stress.shape[1] == 9 else stress
        yield of_stress(crossing, known, points, stress)
    for ending in ("stl", "ply"):
        skin = servermanager.Fetch(simple.Clean(Input=opened(folder / f"run.{ending}")))
        points = vtk_to_numpy(skin.GetPoints().GetData()).astype(float)
        corners = points[vtk_to_numpy(skin.GetPolys().GetConnectivityArray()).reshape(-1, 3)]
        volume = np.einsum("ni,ni", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        said = f"run.{ending} → ParaView", "volume, mm³"
        yield row(*said, volume, known["volume_mm3"], "scaled", allowed=FLAT)
    whole = folder if (folder / "known.json").exists() else folder.parents[1]  # of spoiled files
    yield from of_run(
        folder / "run", json.loads((whole / "run" / "summary.json").read_text(encoding="utf-8"))
    )


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
