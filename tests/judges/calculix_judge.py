# requires: debian:calculix-ccx numpy==2.4.6
"""CalculiX solves our deck: it prints volume and sets, and has the same displacement in every load case."""

import re
import subprocess
import tempfile
from pathlib import Path

from rows import judge, row

# CalculiX prints the volume with seven digits; its displacement has another solver and six digits behind it.
PRINTED, SOLVED = 1e-6, 1e-4


def solved(deck: str) -> tuple[str, str]:
    """Solve a deck that asks for the volume and the nodes of a bore as well; return .dat and .frd."""
    asked = "*EL PRINT, ELSET=EALL, TOTALS=ONLY\nEVOL\n*NODE PRINT, NSET=BIG_END_BORE\nU\n*END STEP"
    with tempfile.TemporaryDirectory() as scratch:
        Path(scratch, "run.inp").write_text(deck.replace("*END STEP", asked, 1))
        command = ["ccx", "-i", "run"]
        told = subprocess.run(command, cwd=scratch, capture_output=True, text=True, check=False).stdout
        assert "*ERROR" not in told, told[told.index("*ERROR") :][:300]
        return Path(scratch, "run.dat").read_text(), Path(scratch, "run.frd").read_text()


def largest(block: str) -> float:
    """The largest component of displacement in a block of a .frd file, mm."""
    lines = re.findall(r"(?m)^ -1.{10}(.{12})(.{12})(.{12})", block)
    return max(abs(float(word)) for line in lines for word in line)


def reads(folder, known):
    crossing = "run.inp → CalculiX"
    data, fields = solved((folder / "run.inp").read_text())
    volume = float(re.search(r"total volume.*\n\s*\n\s*(\S+)", data)[1])
    yield row(crossing, "volume, mm³", volume, known["volume_mm3"], "scaled", allowed=PRINTED)
    bore = re.search(r"displacements.*set BIG_END_BORE.*\n\s*\n((?:\s+\d+(?:\s+\S+){3}\n)+)", data)
    yield row(
        crossing, "nodes of BIG_END_BORE", bore[1].count("\n") if bore else 0, known["bore_nodes"], "names"
    )
    blocks = re.split(r"(?m)^ -4  (\w+)", fields)
    steps = [
        largest(block.split("\n -3")[0])
        for name, block in zip(blocks[1::2], blocks[2::2], strict=True)
        if name == "DISP"
    ]
    expected = known["displaced_mm"]
    yield row(crossing, "steps", len(steps), len(expected), "turned")
    for (name, moved), found in zip(expected.items(), steps, strict=True):
        yield row(crossing, f"largest displacement in {name}, mm", found, moved, "scaled", allowed=SOLVED)


version = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False).stdout
judge(version.split()[-1], reads, faults=("turned", "scaled", "names"))
