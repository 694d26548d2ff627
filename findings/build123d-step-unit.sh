#!/bin/bash
# build123d 0.13.0 writing STEP (cadquery-ocp-novtk 8.0.1.1.0).
# The unit that export_step takes is not the unit of the file. Whatever it is, the file is in millimetres, and the
# coordinates are multiplied by it: the same box of 25.4 is 25.4 mm, 645.16 mm ("inch") or 25 400 mm ("metre").
# Who asks for an inch file of a part modelled in millimetres gets a part that is 25.4 times as large.
# Seen: three files whose only length unit is SI_UNIT(.MILLI.,.METRE.); largest x 12.7, 322.58 and 12 700.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q build123d==0.13.0 cadquery-ocp-novtk==8.0.1.1.0 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import re

from build123d import Box, Unit, export_step, import_step

box, sizes = Box(25.4, 25.4, 25.4), {}
for unit in (Unit.MM, Unit.IN, Unit.M):
    export_step(box, f"{unit.name}.step", unit=unit)
    text = open(f"{unit.name}.step").read()
    lengths = re.findall(r"SI_UNIT\((\.\w+\.|\$),\.METRE\.\)", text)
    sizes[unit.name] = import_step(f"{unit.name}.step").bounding_box().size.X
    print(unit.name, "length units in the file:", lengths, "inch" if "'INCH'" in text.upper() else "", "size read:", sizes[unit.name])
    assert set(lengths) == {".MILLI."} and "INCH" not in text.upper()
assert abs(sizes["MM"] - 25.4) < 1e-6
assert abs(sizes["IN"] - 25.4**2) < 1e-6 and abs(sizes["M"] - 25400) < 1e-6, "the unit no longer scales the part"
PYTHON
