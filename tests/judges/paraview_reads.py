# requires: pip>=21.0.0
"""ParaView finds the figures of runs by the clicks of docs/do/paraview.md: paraview_reads.py FOLDER

FOLDER holds runs, such as one with places that are left out, and one with oil films:

    fea run leon-2001-bolted --size 12 --out FOLDER/bolted
    fea run leon-2001 --rpm 6000 --size 10 --film --out FOLDER/film

pvpython must be on the PATH (Debian: python3-paraview).
"""

import csv
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

try:
    from paraview import simple
except ImportError:
    pvpython = shutil.which("pvpython")
    if pvpython is None or "--inside" in sys.argv:
        sys.exit("There is no ParaView with Python on the PATH. Install it (Debian: python3-paraview).")
    command = [pvpython, __file__, *sys.argv[1:], "--inside"]
    sys.exit(subprocess.run(command, check=False).returncode)


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


def rows(run):
    """Yield file, what, figure and expected one of a run, and the relative difference that is allowed."""
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    results = {name: case["max_von_mises_MPa"] for name, case in summary["results"].items()}
    if summary.get("envelope"):
        results["envelope"] = summary["envelope"]["max_von_mises_MPa"]
    for name, stress in results.items():
        yield f"{run.name}/{name}.vtu", "largest stress", largest_stress(run / f"{name}.vtu"), stress, 2e-6
    angles = [load["crank_deg"] for load in summary["loads"].values()]
    times = sorted(-1.0 if angle is None else angle for angle in angles)
    for found, time in zip(opened(run / "cases.pvd").TimestepValues, times, strict=True):
        yield f"{run.name}/cases.pvd", "crank angle", found, time, 1e-5
    loads = [*csv.DictReader((run / "loads.csv").read_text(encoding="utf-8").splitlines())]
    for end, film in (summary.get("film") or {}).items():
        axis, place = ("crank", "") if end == "big_end" else ("pin", "_small_end")
        for what in ("h_min", "p_max"):
            (row,) = [row for row in loads if float(row["crank_deg"]) == film[f"{what}_deg"]]
            load = math.hypot(*(float(row[f"{axis}_{way}_N"]) for way in ("axial", "transverse")))
            file = f"film{place}_{what}.vtu"
            yield f"{run.name}/{file}", "force of the film", force(run / file), load, 1e-3


def main(folder):
    wrong = 0
    for path in sorted(Path(folder).glob("*/summary.json")):
        for file, what, found, expected, allowed in rows(path.parent):
            right = abs(found - expected) <= allowed * abs(expected)
            wrong += not right
            said = "yes" if right else "no"
            sys.stdout.write(f"{file} | {what} | {found:.7g} | {expected:.7g} | {said}\n")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
