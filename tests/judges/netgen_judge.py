# requires: ngsolve==6.2.2608 netgen-mesher==6.2.2608
"""Netgen and NGSolve read our mesh and our STEP file; draw the rod, and write it and a mesh."""

import ngsolve
from netgen.occ import Axes, Box, Cylinder, OCCGeometry, Pnt, X, Y, Z
from netgen.read_gmsh import ReadGmsh
from rows import BAR, ENDS, LENGTH, MIDDLE, WIDTH, judge, mesh, of_names, row, solid

# File and Netgen's name of its format, by the order of the elements.
FORMATS = {
    1: {"rod1.vol": "", "rod1.msh": "Gmsh2 Format", "rod1.inp": "Abaqus Format"},
    2: {"rod2.vol": "", "rod2.msh": "Gmsh2 Format"},
}


def measured(read):
    """NGSolve's integral over the curved elements, mm³."""
    return ngsolve.Integrate(ngsolve.CF(1), ngsolve.Mesh(read), order=6)


def reads(folder, known):
    crossing, read = "run.msh as text → Netgen", ReadGmsh(str(folder / "run-text.msh"))
    yield row(crossing, "elements", len(read.Elements3D()), known["elements"], "lost")
    yield row(crossing, "its own volume, mm³", measured(read), known["volume_mm3"], "scaled", allowed=1e-6)
    surfaces = ngsolve.Mesh(read).GetBoundaries()
    names = [surfaces[facet.index - 1] for facet in read.Elements2D()]
    yield of_names(crossing, known, {name: names.count(name) for name in set(names)})
    found = OCCGeometry(str(folder / "rod.step")).shape.mass
    yield row("rod.step → Netgen", "volume, mm³", found, known["step_mm3"], "unit", allowed=1e-4)


def drawn():
    x, y, z = (side / 2 for side in BAR)
    rod = Box(Pnt(MIDDLE - x, -y, -z), Pnt(MIDDLE + x, y, z))
    for end, ring, _ in ENDS:
        rod += Cylinder(Pnt(end, 0, -WIDTH / 2), Z, r=ring, h=WIDTH)
    for end, _, bore in ENDS:
        rod -= Cylinder(Pnt(end, 0, -WIDTH), Z, r=bore, h=2 * WIDTH)
    return rod


def writes(folder, size):
    part = drawn().Scale(Pnt(0, 0, 0), size)
    for name, shape in {"part": part, "mirrored": part.Mirror(Axes(Pnt(0, 0, 0), X, Y))}.items():
        shape.WriteStep(str(folder / f"{name}.step"))
        shape.WriteBrep(str(folder / f"{name}.brep"))
        yield solid(f"{name}.step", f"{name}, mm")
        yield solid(f"{name}.brep", f"{name}, mm")
    for order, formats in FORMATS.items():
        made = OCCGeometry(part).GenerateMesh(maxh=10)
        if order == 2:
            made.SecondOrder()
        for name, form in formats.items():
            if form:
                made.Export(str(folder / name), form)
            else:
                made.Save(str(folder / name))
            yield mesh(name, f"order {order}", measured(made) / size**3, LENGTH)


judge(ngsolve.__version__, reads, writes)
