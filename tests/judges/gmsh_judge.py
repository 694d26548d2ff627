# requires: gmsh==4.15.2 numpy==2.4.6
"""Gmsh reads our meshes and our STEP file; draws the rod, and writes it and a mesh in each format."""

import gmsh
import numpy as np
from rows import BAR, ENDS, FLAT, LENGTH, MIDDLE, WIDTH, judge, mesh, of_mesh, of_names, of_stress, row, solid

TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
VERSIONS = {1: (0,), 2.2: (0, 1), 4: (0,), 4.1: (0, 1)}  # of its own format, and whether binary


def own_volume():
    """Gmsh's own integral over its elements, mm³."""
    total = 0.0
    for kind in gmsh.model.mesh.getElementTypes(3):
        points, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss4")
        _, determinants, _ = gmsh.model.mesh.getJacobians(kind, points)
        total += float((determinants.reshape(-1, len(weights)) * weights).sum())
    return total


def opened(path, kind):
    """Open a mesh; return its points, and the rows of its elements of a kind."""
    gmsh.clear()
    gmsh.open(str(path))
    tags, points, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    _, nodes = gmsh.model.mesh.getElementsByType(kind)
    return points.reshape(-1, 3)[order], np.searchsorted(tags[order], nodes)


def reads(folder, known):
    for ending in ("msh", "med", "bdf"):
        crossing = f"run.{ending} → gmsh"
        points, cells = opened(folder / f"run.{ending}", 11)
        yield from of_mesh(crossing, known, points, cells.reshape(-1, 10)[:, TO_VTK])
        yield row(crossing, "its own volume, mm³", own_volume(), known["volume_mm3"], "scaled", allowed=1e-6)
        if ending == "bdf":
            continue
        views = {gmsh.view.option.getString(tag, "Name"): tag for tag in gmsh.view.getTags()}
        _, _, data, _, count = gmsh.view.getHomogeneousModelData(views["tension_stress"], 0)
        # Of MED's six components gmsh makes nine, the last three zero: their order is that of the file.
        columns = [0, 1, 2, 3, 4, 5] if ending == "med" else [0, 4, 8, 1, 5, 2]
        yield of_stress(crossing, known, points, np.reshape(data, (-1, count))[:, columns])
        found = {}
        for _, group in gmsh.model.getPhysicalGroups(2):
            (piece,) = gmsh.model.getEntitiesForPhysicalGroup(2, group)
            found[gmsh.model.getPhysicalName(2, group)] = len(gmsh.model.mesh.getElements(2, piece)[1][0])
        yield of_names(crossing, known, found)
    points, corners = opened(folder / "run.stl", 2)
    a, b, c = points[corners].reshape(-1, 3, 3).swapaxes(0, 1)
    volume = (a * np.cross(b, c)).sum() / 6
    yield row("run.stl → gmsh", "volume, mm³", volume, known["volume_mm3"], "scaled", allowed=FLAT)
    opened(folder / "rod.step", 2)
    measured = gmsh.model.occ.getMass(*gmsh.model.getEntities(3)[0])
    yield row("rod.step → gmsh", "volume, mm³", measured, known["step_mm3"], "unit", allowed=1e-4)


def drawn(scale, what):
    """Draw the rod as one part, as rod and cap, mirrored or with split faces."""
    gmsh.clear()
    occ = gmsh.model.occ
    gmsh.option.setNumber("Geometry.OCCUnionUnify", 0 if what == "split" else 1)
    rings = [(3, occ.addCylinder(x, 0, -WIDTH / 2, 0, 0, WIDTH, ring)) for x, ring, _ in ENDS]
    pins = [(3, occ.addCylinder(x, 0, -WIDTH, 0, 0, 2 * WIDTH, bore)) for x, _, bore in ENDS]
    length, height, depth = BAR
    bar = (3, occ.addBox(MIDDLE - length / 2, -height / 2, -depth / 2, *BAR))
    rod, _ = occ.cut(occ.fuse(rings, [bar])[0], pins)
    if what in {"rod and cap", "split"}:
        start, end = ((-100, -100), (100, 200)) if what == "rod and cap" else ((-100, 0), (400, 100))
        box = [(3, occ.addBox(*start, -100, *end, 200))]
        one = occ.intersect(rod, box, removeObject=False, removeTool=False)[0]
        other = occ.cut(rod, box)[0]
        rod = occ.fuse(one, other)[0] if what == "split" else [*one, *other]
    if what == "mirrored":
        occ.mirror(rod, 1, 0, 0, 0)
    occ.dilate(rod, 0, 0, 0, scale, scale, scale)
    occ.synchronize()


def writes(folder, size):
    for what in ("part", "rod and cap", "mirrored", "split"):
        drawn(size, what)
        for ending in ("step", "brep"):
            gmsh.write(str(folder / f"{what}.{ending}"))
            yield solid(f"{what}.{ending}", f"{what}, mm")
    for unit, scale in (("m", 1e-3), ("in", 1 / 25.4)):
        drawn(size * scale, "part")
        for ending in ("step", "brep"):
            gmsh.write(str(folder / f"{unit}.{ending}"))
            yield solid(f"{unit}.{ending}", f"part, {unit}", "--unit", unit)
    drawn(size, "part")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 8)
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="rod")
    gmsh.model.mesh.generate(3)
    for order in (1, 2):
        gmsh.model.mesh.setOrder(order)
        volume = own_volume() / size**3
        forms = [(f"-{version}{'b' * binary}.msh", version, binary)
                 for version, ways in VERSIONS.items() for binary in ways]  # fmt: skip
        forms += [(f".{ending}", 4.1, 0) for ending in ("med", "unv", "bdf", "inp", "mesh", "vtk")]
        for name, version, binary in (*forms, ("-binary.vtk", 4.1, 1)):
            gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.write(str(folder / f"rod{order}{name}"))
            yield mesh(f"rod{order}{name}", f"order {order}{', binary' * binary}", volume, LENGTH)


gmsh.initialize(["", "-v", "1"], readConfigFiles=False)
judge(gmsh.__version__, reads, writes)
