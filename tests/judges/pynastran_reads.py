# requires: pyNastran==1.4.1
"""PyNastran reads the bulk data file of a run as a complete deck, the way it reads files by default."""

import json
import sys
from pathlib import Path

from pyNastran.bdf.bdf import BDF


def main(folder: Path) -> int:
    """Judge the file; return the exit code."""
    known = json.loads((folder / "run" / "summary.json").read_text())["model"]
    model = BDF(debug=None)
    model.read_bdf(str(folder / "run.bdf"), punch=False, xref=False)
    solids = [element for element in model.elements.values() if element.type == "CTETRA"]
    model.cross_reference(xref_elements=False, xref_properties=False)
    volumes = []
    for element in solids:
        a, b, c, d = (model.nodes[node].xyz for node in element.nodes[:4])
        ab, ac, ad = b - a, c - a, d - a
        volumes.append(float((ab[1] * ac[2] - ab[2] * ac[1]) * ad[0] + (ab[2] * ac[0] - ab[0] * ac[2]) * ad[1]
                             + (ab[0] * ac[1] - ab[1] * ac[0]) * ad[2]) / 6)  # fmt: skip
    rows = [
        ("nodes", len(model.nodes), known["nodes"], len(model.nodes) == known["nodes"]),
        ("CTETRA", len(solids), known["elements"], len(solids) == known["elements"]),
        ("nodes of each", len(solids[0].nodes), 10, len(solids[0].nodes) == 10),
        ("least volume, mm³", min(volumes), "> 0", min(volumes) > 0),
    ]
    for what, found, expected, right in rows:
        print(f"run.bdf | {what} | {found} | {expected} | {'yes' if right else 'NO'}")
    return 0 if all(right for *_, right in rows) else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
