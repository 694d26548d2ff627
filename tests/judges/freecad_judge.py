# requires: debian:freecad-python3
"""FreeCAD: reads our meshes, surfaces and STEP file; draws the rod, nests it, and writes it in each format and unit."""

import sys

sys.path[:0] = [f"/usr/lib/{place}" for place in ("freecad-python3/lib", "freecad/lib", "freecad/Mod/Fem")]
import FreeCAD  # before its modules, which end the program where it is not there

# isort: split
import Fem
import Import
import Mesh
import numpy as np
import Part
from FreeCAD import Matrix, Placement, Rotation, Vector
from rows import (
    BAR,
    BORES,
    INCH,
    LENGTH,
    MIDDLE_OF_BAR,
    RINGS,
    WIDTH,
    Item,
    judge,
    of_mesh,
    row,
    volumes,
)

# From SMESH's order of nodes, which is turned as MED's is, to VTK's.
TURN = {4: [0, 2, 1, 3], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
MESHES = ("unv", "med", "inp", "vtk", "vtu")


def arrays(mesh, *, turned=True):
    place = {number: row for row, number in enumerate(mesh.Nodes)}
    points = np.array([list(node) for node in mesh.Nodes.values()])
    cells = np.array([[place[n] for n in mesh.getElementNodes(volume)] for volume in mesh.Volumes])
    return points, cells[:, TURN[cells.shape[1]]] if turned else cells


def reads(folder, known):
    for name in ("run.bdf", "run.inp", "run.vtk", "run/tension.vtu"):
        mesh = Fem.read(str(folder / name))
        # FreeCAD does not turn the elements of VTK's files: there they stand as in the file.
        turned = name.endswith(("bdf", "inp"))
        yield from of_mesh(f"{name} → FreeCAD", known, *arrays(mesh, turned=turned))
    for name in ("run.stl", "run.ply"):
        mesh = Mesh.Mesh(str(folder / name))
        yield row(f"{name} → FreeCAD", "closed", mesh.isSolid(), True, "lost")
        volume = known["volume_mm3"]
        yield row(f"{name} → FreeCAD", "volume in its triangles, mm³", mesh.Volume, volume, "scaled", 2e-3)
    solid = Part.read(str(folder / "rod.step"))
    found = solid.Volume if solid.isValid() else 0.0
    yield row("rod.step → FreeCAD", "volume of the solid, mm³", found, known["step_mm3"], "unit", 1e-4)


def drawn():
    down, axis = Vector(0, 0, -WIDTH / 2), Vector(0, 0, 1)
    ends = [(Vector(x, 0, 0), ring, bore) for x, ring, bore in zip((0, LENGTH), RINGS, BORES)]
    length, height, depth = BAR
    rod = Part.makeBox(*BAR, Vector(MIDDLE_OF_BAR - length / 2, -height / 2, -depth / 2))
    for place, ring, _ in ends:
        rod = rod.fuse(Part.makeCylinder(ring, WIDTH, place + down, axis))
    for place, _, bore in ends:
        rod = rod.cut(Part.makeCylinder(bore, WIDTH, place + down, axis))
    return rod.removeSplitter().Solids[0]


def nested(document, solids, scale):
    """A part in a part: each is turned and moved, and the solids are not."""
    outer, inner = document.addObject("App::Part", "crank_drive"), document.addObject("App::Part", "rod_assembly")
    outer.Placement = Placement(Vector(1, 2, 3) * scale, Rotation(Vector(1, 2, 3), 40))
    inner.Placement = Placement(Vector(-7, 0, 11) * scale, Rotation(Vector(3, 1, 0), 65))
    outer.addObject(inner)
    for name, solid in solids.items():
        feature = document.addObject("Part::Feature", name)
        feature.Shape = solid
        inner.addObject(feature)
    document.recompute()
    return outer


def writes(folder, spoil):
    rod = drawn()
    expected = {"volume_mm3": rod.Volume, "length_mm": LENGTH}
    half = Part.makeBox(100, 200, 100, Vector(-100, -100, -50))
    across = Part.makeBox(400, 100, 100, Vector(-100, 0, -50))
    bodies = {"body": rod.cut(half).Solids[0], "cap": rod.common(half).Solids[0]}
    if spoil:
        bodies["cap"] = bodies["cap"].translated(Vector(-2, 0, 0))
    wrong = 1.01 if spoil else 1.0
    mirror = Matrix()
    mirror.scale(-1, 1, 1)
    shapes = {
        "part": rod.scaled(wrong),
        "mirrored": rod.transformGeometry(mirror).scaled(wrong),
        "split": rod.cut(across).fuse(rod.common(across)).scaled(wrong),
        "splines": rod.toNurbs().scaled(wrong),
    }
    for name, shape in shapes.items():
        shape.exportStep(str(folder / f"{name}.step"))
        shape.exportIges(str(folder / f"{name}.igs"))
        shape.exportBrep(str(folder / f"{name}.brep"))
        for ending in ("step", "igs", "brep"):
            yield Item(f"{name}.{ending}", f"{name}, mm", "scaled", expected)
    for unit, scale in (("m", 1e-3), ("in", 1 / INCH)):
        rod.scaled(scale * wrong).exportStep(str(folder / f"{unit}.step"))
        yield Item(f"{unit}.step", f"part, {unit}", "scaled", expected, options=["--unit", unit])
    for name, solids in (("nested", bodies), ("nested-part", {"rod": rod.scaled(wrong)})):
        document = FreeCAD.newDocument(name)
        top = nested(document, solids, 1.0)
        Import.export([top], str(folder / f"{name}.step"))
        document.saveAs(str(folder / f"{name}.FCStd"))
        for ending in ("step", "FCStd"):
            yield Item(f"{name}.{ending}", f"{name}: placed twice", "placed", expected)
    source = folder.parents[1] / "run.bdf"
    for nodes in (4, 10):
        mesh, read = Fem.FemMesh(), Fem.read(str(source))
        points, tets = arrays(read)
        for number, place in read.Nodes.items():
            mesh.addNode(*(place * wrong), number)
        for volume in read.Volumes:
            mesh.addVolume(list(read.getElementNodes(volume)[:nodes]), volume)
        for ending in MESHES:
            mesh.write(str(folder / f"tetra{nodes}.{ending}"))
            known = {"volume_mm3": volumes(points, tets[:, :nodes]).sum(), "length_mm": 141.0}
            yield Item(f"tetra{nodes}.{ending}", f"{nodes}-node tetrahedra", "scaled", known, 1e-4)


judge(".".join(FreeCAD.Version()[:3]), reads, writes)
