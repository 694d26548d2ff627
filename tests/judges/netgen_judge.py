# requires: ngsolve==6.2.2608 netgen-mesher==6.2.2608
"""Netgen and NGSolve: read our mesh, surface and STEP file; draw the rod, and write it and one mesh in each format."""

import ngsolve
from netgen.meshing import Mesh
from netgen.occ import Axes, Box, Cylinder, OCCGeometry, Pnt, X, Y, Z
from netgen.read_gmsh import ReadGmsh
from rows import BAR, BORES, LENGTH, MIDDLE_OF_BAR, RINGS, WIDTH, Item, judge, of_mesh, of_names, row

# File and Netgen's name of its format, by the order of the elements.
FORMATS = {
    1: (("rod1.vol", ""), ("rod1.msh", "Gmsh2 Format"), ("rod1.inp", "Abaqus Format")),
    2: (("rod2.vol", ""), ("rod2.msh", "Gmsh2 Format")),
}


def measured(mesh):
    """Netgen's own integral over its curved elements, mm³."""
    return ngsolve.Integrate(ngsolve.CF(1), ngsolve.Mesh(mesh), order=6)


def reads(folder, known):
    crossing, mesh = "run.msh as text → Netgen", ReadGmsh(str(folder / "run-text.msh"))
    yield row(crossing, "elements", len(mesh.Elements3D()), known["elements"], "lost")
    yield row(crossing, "its own volume, with its sign, mm³", measured(mesh), known["volume_mm3"], "scaled", 1e-6)
    surfaces = ngsolve.Mesh(mesh)
    names = [surfaces.GetBoundaries()[facet.index - 1] for facet in mesh.Elements2D()]
    yield from of_names(crossing, known, {name: names.count(name) for name in set(names)})
    solid = OCCGeometry(str(folder / "rod.step")).shape
    yield row("rod.step → Netgen", "volume of the solid, mm³", solid.mass, known["step_mm3"], "unit", 1e-4)


def drawn(scale):
    length, height, depth = BAR
    low = Pnt(MIDDLE_OF_BAR - length / 2, -height / 2, -depth / 2)
    rod = Box(low, Pnt(low.x + length, -low.y, -low.z))
    for x, radius in zip((0, LENGTH), RINGS, strict=True):
        rod += Cylinder(Pnt(x, 0, -WIDTH / 2), Z, r=radius, h=WIDTH)
    for x, radius in zip((0, LENGTH), BORES, strict=True):
        rod -= Cylinder(Pnt(x, 0, -WIDTH), Z, r=radius, h=2 * WIDTH)
    return rod.Scale(Pnt(0, 0, 0), scale)


def writes(folder, spoil):
    shapes = {
        "part": drawn(1.01 if spoil else 1.0),
        "mirrored": drawn(1.01 if spoil else 1.0).Mirror(Axes(Pnt(0, 0, 0), X, Y)),
    }
    expected = {"volume_mm3": drawn(1.0).mass, "length_mm": LENGTH}
    for name, shape in shapes.items():
        for ending, write in (("step", shape.WriteStep), ("brep", shape.WriteBrep)):
            write(str(folder / f"{name}.{ending}"))
            yield Item(f"{name}.{ending}", f"{name}, mm", "scaled", expected)
    for order in (1, 2):
        mesh = OCCGeometry(shapes["part"]).GenerateMesh(maxh=10)
        if order == 2:
            mesh.SecondOrder()
        volume = measured(mesh) / (1.01**3 if spoil else 1.0)
        for name, form in FORMATS[order]:
            mesh.Export(str(folder / name), form) if form else mesh.Save(str(folder / name))
            known = {"volume_mm3": volume, "length_mm": LENGTH}
            yield Item(name, f"order {order}", "scaled", known, 1e-4)


judge(ngsolve.__version__, reads, writes)
