#!/bin/bash
# CalculiX 2.20 (Debian 12, calculix-ccx 2.20-1) reading, meshio 5.3.5 writing, Abaqus/CalculiX input decks.
# CalculiX takes the first twenty characters of each number of *NODE and drops the rest. A coordinate of 21 characters
# that ends in a two-digit exponent loses its last digit without a word: 1.499759782661857E-12 is read as ...E-1.
# Where the cut leaves "e+" behind, the card is refused; so is every deck of meshio, whose default is 22 characters.
# Seen: volume of a tetrahedron of height 1.499759782661857E-12 printed as 2.499600E-02 instead of 2.4996E-13;
# "*ERROR reading *NODE" for the deck that meshio writes of one unit tetrahedron.
set -eu
[ "$(dpkg-query -W -f '${Version}' calculix-ccx)" = 2.20-1 ] || { echo "needs Debian 12's calculix-ccx 2.20-1"; exit 2; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q meshio==5.3.5 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import re
import subprocess

import meshio

STEP = """*MATERIAL,NAME=M
*ELASTIC
1000.,.3
*SOLID SECTION,ELSET=E,MATERIAL=M
*BOUNDARY
1,1,3
2,1,3
3,1,3
4,1,2
*STEP
*STATIC
*BOUNDARY
4,3,3,.001
*EL PRINT,ELSET=E
EVOL
*END STEP
"""


def run(name, deck):
    """The volume that CalculiX prints, or its first error."""
    with open(f"{name}.inp", "w") as file:
        file.write(deck + STEP)
    log = subprocess.run(["ccx", name], capture_output=True, text=True).stdout
    if error := re.search(r"\*ERROR.*", log):
        return error[0].strip().split(".")[0]
    return float(open(f"{name}.dat").read().split()[-1])


def tetrahedron(height):
    nodes = f"*NODE\n1,0,0,0\n2,1.,0,0\n3,0,1.,0\n4,0,0,{height}\n"
    return nodes + "*ELEMENT,TYPE=C3D4,ELSET=E\n1,1,2,3,4\n"


volumes = {}
for height in ("1.49975978266185E-3", "1.499759782661857E-3", "1.499759782661857E-12"):
    volumes[height] = run("height", tetrahedron(height))
    print(f"{height} ({len(height)} characters): {volumes[height]:.6e}, true {float(height) / 6:.6e}")
meshio.write(
    "unit.inp",
    meshio.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]], [("tetra", [[0, 1, 2, 3]])]),
    file_format="abaqus",
)
deck = open("unit.inp").read().replace("TYPE=C3D4", "TYPE=C3D4,ELSET=E")
said = run("meshio", deck)
print("meshio's deck:", said)
first, second, cut = volumes.values()
assert abs(first / 2.4996e-4 - 1) < 1e-4 and abs(second / 2.4996e-4 - 1) < 1e-4
assert abs(cut / 2.4996e-2 - 1) < 1e-4, "the exponent is read whole"
assert said == "*ERROR reading *NODE", "meshio's deck is read"
PYTHON
