# requires: medcoupling==9.15.0
"""MEDCoupling, the library of SALOME and Code_Aster, reads the MED file of a run."""

import json
import sys
import tomllib
from pathlib import Path

import medcoupling as mc

_COMPONENTS, _GROUPS = "XX YY ZZ XY YZ XZ", "big_end_bore free rod small_end_bore"


def main(folder: Path) -> int:
    """Judge the file; return the exit code."""
    file = str(folder / "run.med")
    model = json.loads((folder / "run" / "summary.json").read_text())
    mesh = mc.MEDFileUMesh(file)
    volume = mesh.getMeshAtLevel(0).getMeasureField(isAbs=False).getArray()
    stress = mc.MEDFileFieldMultiTS(file, "tension_stress")
    study = tomllib.loads((folder / "run" / "study.toml").read_text())
    density = model["rod"]["mass_kg"] / volume.accumulate()[0] * 1e9  # kg/m³
    known = study["material"]["density_kg_m3"]
    names = [word.partition(" ")[0] for word in stress.getInfo()]
    known_elements, groups = model["model"]["elements"], " ".join(sorted(mesh.getGroupsNames()))
    rows = [
        ("least volume of an element, mm³", volume.getMinValue()[0], "> 0", volume.getMinValue()[0] > 0),
        # MEDCoupling takes the sides of curved elements as straight.
        ("mass over volume, kg/m³", round(density), f"{known} ± 1 %", abs(density / known - 1) < 0.01),
        ("elements", volume.getNbOfElems(), known_elements, volume.getNbOfElems() == known_elements),
        ("components", " ".join(names), _COMPONENTS, " ".join(names) == _COMPONENTS),
        ("groups", groups, _GROUPS, groups == _GROUPS),
    ]
    for what, found, expected, right in rows:
        print(f"run.med | {what} | {found} | {expected} | {'yes' if right else 'NO'}")
    return 0 if all(right for *_, right in rows) else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
