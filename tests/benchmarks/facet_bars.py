"""Whether the error bars of rods from STL surfaces contain the largest stress of the curved solid.

    python tests/benchmarks/facet_bars.py FOLDER [ROD:FACETS ...]

Each rod of the library is written as STL with that many triangles around a turn, and analysed at 6000 rpm as
the solid is; printed are the largest von Mises stress of both and the bar of the STL's. A load case is
compared where both have it at the same crank angle: bending is as large at two, and the mass decides.
"""

import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from damage import write_surface

from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

# Rods of the library, by the study that runs them.
STUDIES = {"leon-2001": "leon-2001", "molina-2000cc": "molina-2024"}
RODS = [*(f"leon-2001:{n}" for n in (12, 16, 20, 24, 32)), *(f"molina-2000cc:{n}" for n in (12, 16, 24))]
SIZE_MM = 12.0  # largest side of the triangles
SAME_DEG = 1.0  # between crank angles of one load case


def solved(study: str, out: Path) -> dict[str, dict[str, float]]:
    """Results of the load cases of a study and their crank angles. `CalledProcessError`: it was refused."""
    command = [sys.executable, "-m", "fea", "run", study, "--rpm", "6000", "--quiet", "--out", str(out)]
    if not (out / "summary.json").exists():
        subprocess.run(command, check=True)
    summary = json.loads((out / "summary.json").read_text())
    loads, results = summary["loads"], summary["results"]
    return {name: found | {"crank_deg": loads[name]["crank_deg"]} for name, found in results.items()}


def main(folder: Path, rods: list[str]) -> None:
    """Run the rods and print a line for each load case."""
    folder.mkdir(parents=True, exist_ok=True)
    print("rod, triangles around, load case, solid MPa, STL MPa, off %, bar %")
    outside = count = 0
    for each in rods:
        rod, around = each.split(":")
        right = solved(STUDIES[rod], folder / rod)
        text = (folder / rod / "study.toml").read_text()
        study = folder / f"{rod}-{around}.toml"
        with session():
            build(PRESETS[rod], Mirror.NONE)
            write_surface(study.with_suffix(".stl"), SIZE_MM, int(around))
        study.write_text(f'[rod]\nmesh = "{study.stem}.stl"\n\n{text[text.index("[material]") :]}')
        for case, found in solved(str(study), folder / study.stem).items():
            largest, true = found["max_von_mises_MPa"], right[case]["max_von_mises_MPa"]
            if abs(found["crank_deg"] - right[case]["crank_deg"]) > SAME_DEG:
                print(f"{rod}, {around}, {case}: at another crank angle")
                continue
            off, bar = 100 * abs(largest - true) / largest, found["error_percent"]
            count, outside = count + 1, outside + (off > bar)
            print(f"{rod}, {around}, {case}, {true:.1f}, {largest:.1f}, {off:.1f}, {bar:.1f}")
    print(f"{count - outside} of {count} bars contain the stress of the solid")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:] or RODS)
