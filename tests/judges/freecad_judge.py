# requires: debian:freecad-python3
"""FreeCAD reads our meshes, surfaces and STEP file; draws the rod, nests it, and writes it and a mesh."""

# ruff: noqa: E402
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
from rows import BAR, ENDS, FLAT, LENGTH, MIDDLE, TURN, WIDTH, judge, mesh, of_mesh, row, solid, volumes

UNITS = {"m": 1e-3, "in": 1 / 25.4}


def arrays(read, *, turned=True):
    place = {number: row for row, number in enumerate(read.Nodes)}
    points = np.array([list(node) for node in read.Nodes.values()])
    cells = np.array([[place[n] for n in read.getElementNodes(volume)] for volume in read.Volumes])
    return points, cells[:, TURN[cells.shape[1]]] if turned else cells


def reads(folder, known):
    for name in ("run.med", "run.bdf", "run.inp", "run.vtk", "run/tension.vtu"):
        # FreeCAD turns elements as SMESH wants them, but not those of VTK's files.
        turned = not name.endswith(("vtk", "vtu"))
        yield from of_mesh(f"{name} → FreeCAD", known, *arrays(Fem.read(str(folder / name)), turned=turned))
    for name in ("run.stl", "run.ply"):
        skin = Mesh.Mesh(str(folder / name))
        found = skin.Volume if skin.isSolid() else 0.0
        yield row(f"{name} → FreeCAD", "volume, mm³", found, known["volume_mm3"], "scaled", allowed=FLAT)
    found = Part.read(str(folder / "rod.step")).Volume
    yield row("rod.step → FreeCAD", "volume, mm³", found, known["step_mm3"], "unit", allowed=1e-4)


def drawn():
    length, height, depth = BAR
    rod = Part.makeBox(*BAR, Vector(MIDDLE - length / 2, -height / 2, -depth / 2))
    for x, ring, _ in ENDS:
        rod = rod.fuse(Part.makeCylinder(ring, WIDTH, Vector(x, 0, -WIDTH / 2)))
    for x, _, bore in ENDS:
        rod = rod.cut(Part.makeCylinder(bore, 2 * WIDTH, Vector(x, 0, -WIDTH)))
    return rod.removeSplitter().Solids[0]


def nested(document, pieces):
    """A part in a part: each is turned and moved, and the solids are not."""
    outer, inner = (document.addObject("App::Part", name) for name in ("crank_drive", "rod_assembly"))
    outer.Placement = Placement(Vector(1, 2, 3), Rotation(Vector(1, 2, 3), 40))
    inner.Placement = Placement(Vector(-7, 0, 11), Rotation(Vector(3, 1, 0), 65))
    outer.addObject(inner)
    for name, piece in pieces.items():
        feature = document.addObject("Part::Feature", name)
        feature.Shape = piece
        inner.addObject(feature)
    document.recompute()
    return outer


def solids(folder, size):
    rod, mirror = drawn(), Matrix()
    mirror.scale(-1, 1, 1)
    right = Part.makeBox(4 * LENGTH, 100, 100, Vector(-100, 0, -50))
    shapes = {
        "part": rod,
        "mirrored": rod.transformGeometry(mirror),
        "split": rod.cut(right).fuse(rod.common(right)),
        "splines": rod.toNurbs(),
    }
    for name, shape in shapes.items():
        scaled = shape.scaled(size)
        scaled.exportStep(str(folder / f"{name}.step"))
        scaled.exportIges(str(folder / f"{name}.igs"))
        scaled.exportBrep(str(folder / f"{name}.brep"))
        yield from (solid(f"{name}.{ending}", f"{name}, mm") for ending in ("step", "igs", "brep"))
    for unit, scale in UNITS.items():
        rod.scaled(scale * size).exportStep(str(folder / f"{unit}.step"))
        yield solid(f"{unit}.step", f"part, {unit}", "--unit", unit)
    half = Part.makeBox(100, 200, 100, Vector(-100, -100, -50))
    cap = rod.common(half).Solids[0]
    pieces = {"body": rod.cut(half).Solids[0], "cap": cap if size == 1 else cap.translated(Vector(-2, 0, 0))}
    document = FreeCAD.newDocument("nested")
    Import.export([nested(document, pieces)], str(folder / "nested.step"))
    document.saveAs(str(folder / "nested.FCStd"))
    for ending in ("step", "FCStd"):
        yield solid(f"nested.{ending}", "rod and cap, in a part of a part", fault="placed")


def writes(folder, size):
    yield from solids(folder, size)
    read = Fem.read(str(folder.parents[1] / "run.bdf"))
    points, tets = arrays(read)
    for nodes in (4, 10):
        made = Fem.FemMesh()
        for number, place in read.Nodes.items():
            made.addNode(*(place * size), number)
        for volume in read.Volumes:
            made.addVolume(list(read.getElementNodes(volume)[:nodes]), volume)
        for ending in ("unv", "med", "inp", "vtk", "vtu"):
            made.write(str(folder / f"tetra{nodes}.{ending}"))
            said = f"{nodes}-node tetrahedra"
            yield mesh(f"tetra{nodes}.{ending}", said, volumes(points, tets[:, :nodes]).sum())


judge(".".join(FreeCAD.Version()[:3]), reads, writes)
