# requires: pyNastran==1.4.1
"""PyNastran reads our bulk data as a complete deck, the way it reads files by default, and writes it in each form."""

from pathlib import Path

import numpy as np
import pyNastran
from pyNastran.bdf.bdf import BDF
from rows import Item, judge, of_mesh, row, volumes


def deck(path: Path) -> BDF:
    model = BDF(debug=None)
    model.read_bdf(str(path), punch=False, xref=False)
    model.cross_reference(xref_elements=False, xref_properties=False)
    return model


def arrays(model):
    """Points and tetrahedra, whose order is VTK's in Nastran, too."""
    place = {number: row for row, number in enumerate(model.nodes)}
    points = np.array([node.xyz for node in model.nodes.values()])
    return points, np.array([[place[n] for n in element.nodes] for element in model.elements.values()])


def reads(folder, known):
    crossing, model = "run.bdf → pyNastran", deck(folder / "run.bdf")
    yield row(crossing, "elements", model.card_count["CTETRA"], known["elements"], "lost")
    yield from of_mesh(crossing, known, *arrays(model))


def writes(folder, spoil):
    source = folder.parents[1] / "run.bdf"
    for nodes in (4, 10):
        old, model = deck(source), BDF(debug=None)
        points, tets = arrays(old)
        for number, element in old.elements.items():
            model.add_ctetra(number, 1, element.nodes[:nodes])
        for number in {number for element in model.elements.values() for number in element.nodes}:
            model.add_grid(number, old.nodes[number].xyz * (1.01 if spoil else 1.0))
        volume = volumes(points, tets[:, :nodes]).sum()
        for size, double, name in ((8, False, "small"), (16, False, "large"), (16, True, "double")):
            file = f"tetra{nodes}-{name}.bdf"
            model.write_bdf(str(folder / file), size=size, is_double=double)
            # Fields of eight letters leave five digits of a coordinate.
            expected = {"volume_mm3": volume, "length_mm": 141.0}
            yield Item(file, f"CTETRA of {nodes} nodes, {name} fields", "scaled", expected, 1e-4)


judge(pyNastran.__version__, reads, writes)
