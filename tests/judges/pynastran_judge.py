# requires: pyNastran==1.4.1
"""PyNastran reads our bulk data as a complete deck, its default, and writes it in three widths of fields."""

import numpy as np
import pyNastran
from pyNastran.bdf.bdf import BDF
from rows import judge, mesh, of_mesh, volumes


def deck(path):
    """Read a deck; return it with its points and tetrahedra, whose order is VTK's in Nastran, too."""
    model = BDF(debug=None)
    model.read_bdf(str(path), punch=False, xref=False)
    model.cross_reference(xref_elements=False, xref_properties=False)
    place = {number: row for row, number in enumerate(model.nodes)}
    points = np.array([node.xyz for node in model.nodes.values()])
    return model, points, np.array([[place[n] for n in each.nodes] for each in model.elements.values()])


def reads(folder, known):
    yield from of_mesh("run.bdf → pyNastran", known, *deck(folder / "run.bdf")[1:])


def writes(folder, size):
    old, points, tets = deck(folder.parents[1] / "run.bdf")
    for nodes in (4, 10):
        model = BDF(debug=None)
        for number, element in old.elements.items():
            model.add_ctetra(number, 1, element.nodes[:nodes])
        for number in {number for element in model.elements.values() for number in element.nodes}:
            model.add_grid(number, old.nodes[number].xyz * size)
        volume = volumes(points, tets[:, :nodes]).sum()
        for width, double, name in ((8, False, "small"), (16, False, "large"), (16, True, "double")):
            file = f"tetra{nodes}-{name}.bdf"
            model.write_bdf(str(folder / file), size=width, is_double=double)
            yield mesh(file, f"CTETRA of {nodes} nodes, {name} fields", volume)


judge(pyNastran.__version__, reads, writes)
