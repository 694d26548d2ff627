# requires: gmsh==4.15.2 numpy==2.4.6
"""Gmsh: reads our meshes and our STEP file; draws the rod, and writes it and one mesh of it in each format."""

from pathlib import Path

import gmsh
import numpy as np
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
    of_names,
    of_stress,
    row,
)

TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


def opened(path):
    gmsh.clear()
    gmsh.open(str(path))


def own_volume():
    """The integral of gmsh's own Jacobians, mm³."""
    total = 0.0
    for kind in gmsh.model.mesh.getElementTypes(3):
        points, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss4")
        _, determinants, _ = gmsh.model.mesh.getJacobians(kind, points)
        total += (determinants.reshape(-1, len(weights)) * weights).sum()
    return float(total)


def reads(folder, known):
    for ending in ("msh", "med", "bdf"):
        crossing = f"run.{ending} → gmsh"
        opened(folder / f"run.{ending}")
        tags, points, _ = gmsh.model.mesh.getNodes()
        points = points.reshape(-1, 3)
        place = np.zeros(int(tags.max()) + 1, dtype=int)
        place[tags.astype(int)] = np.arange(len(tags))
        _, cells = gmsh.model.mesh.getElementsByType(11)
        yield from of_mesh(crossing, known, points, place[cells.astype(int)].reshape(-1, 10)[:, TO_VTK])
        yield row(crossing, "its own volume, mm³", own_volume(), known["volume_mm3"], "scaled", 1e-6)
        views = {gmsh.view.option.getString(tag, "Name"): tag for tag in gmsh.view.getTags()}
        if "tension_stress" in views:
            _, nodes, data, _, count = gmsh.view.getHomogeneousModelData(views["tension_stress"], 0)
            # Of MED's six components gmsh makes nine, the last three zero: their order is that of the file.
            columns = [0, 1, 2, 3, 4, 5] if ending == "med" else [0, 4, 8, 1, 5, 2]
            stress = np.reshape(data, (len(nodes), count))[:, columns]
            yield from of_stress(crossing, known, points[place[nodes.astype(int)]], stress)
        found = {}
        for _, group in gmsh.model.getPhysicalGroups(2):
            pieces = gmsh.model.getEntitiesForPhysicalGroup(2, group)
            triangles = sum(len(gmsh.model.mesh.getElements(2, piece)[1][0]) for piece in pieces)
            found[gmsh.model.getPhysicalName(2, group)] = triangles
        if found:
            yield from of_names(crossing, known, found)
    for ending in ("stl",):
        crossing = f"run.{ending} → gmsh"
        opened(folder / f"run.{ending}")
        _, corners = gmsh.model.mesh.getElementsByType(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        points = points.reshape(-1, 3)[np.argsort(tags)]
        a, b, c = points[np.searchsorted(np.sort(tags), corners)].reshape(-1, 3, 3).swapaxes(0, 1)
        volume = (a * np.cross(b, c)).sum() / 6
        yield row(crossing, "volume in its triangles, mm³", volume, known["volume_mm3"], "scaled", 2e-3)
    opened(folder / "rod.step")
    (solid,) = gmsh.model.getEntities(3)
    measured = gmsh.model.occ.getMass(*solid)
    yield row("rod.step → gmsh", "volume of the solid, mm³", measured, known["step_mm3"], "unit", 1e-4)


def drawn(scale, *, two=False, mirrored=False, split=False):
    """Draw the rod, in mm times `scale`; return its volume."""
    gmsh.clear()
    occ = gmsh.model.occ
    gmsh.option.setNumber("Geometry.OCCBooleanPreserveNumbering", 1)
    gmsh.option.setNumber("Geometry.OCCUnionUnify", 0 if split else 1)
    low, high = -WIDTH / 2, WIDTH
    pins = [(0.0, RINGS[0], BORES[0]), (LENGTH, RINGS[1], BORES[1])]
    rings = [(3, occ.addCylinder(x, 0, low, 0, 0, high, radius)) for x, radius, _ in pins]
    length, height, depth = BAR
    bar = occ.addBox(MIDDLE_OF_BAR - length / 2, -height / 2, -depth / 2, *BAR)
    rod, _ = occ.fuse(rings[:1], [*rings[1:], (3, bar)])
    rod, _ = occ.cut(rod, [(3, occ.addCylinder(x, 0, low - 1, 0, 0, high + 2, bore)) for x, _, bore in pins])
    if two or split:
        across = occ.addBox(-100, -100, -100, 100, 200, 200) if two else occ.addBox(-100, 0, -100, 400, 100, 200)
        pieces, _ = occ.fragment(rod, [(3, across)])
        occ.synchronize()
        outside = [piece for piece in pieces if occ.getMass(*piece) > 3e5]
        occ.remove(outside, recursive=True)
        pieces = [piece for piece in pieces if piece not in outside]
        rod = occ.fuse(pieces[:1], pieces[1:])[0] if split else pieces
    if mirrored:
        occ.mirror(rod, 1, 0, 0, 0)
    volume = sum(occ.getMass(*piece) for piece in rod)
    occ.dilate(rod, 0, 0, 0, scale, scale, scale)
    occ.removeAllDuplicates() if two else None
    occ.synchronize()
    return volume


MESHES = (
    *((f"rod{order}-{version}{'b' * binary}.msh", order, version, binary)
      for order in (1, 2) for version, binary in ((1, 0), (2.2, 0), (2.2, 1), (4, 0), (4.1, 0), (4.1, 1))),
    *((f"rod{order}.{ending}", order, 0, 0) for order in (1, 2) for ending in ("med", "unv", "bdf", "inp", "mesh", "vtk")),
    *((f"rod{order}b.vtk", order, 0, 1) for order in (1, 2)),
)  # fmt: skip


def writes(folder: Path, spoil: bool):
    wrong = 1.01 if spoil else 1.0
    # Measured before any face becomes a spline, which gmsh measures less well.
    expected = {"volume_mm3": drawn(1.0), "length_mm": LENGTH}
    for name, tried, how in (
        ("part", "part", {}),
        ("two", "rod and cap", {"two": True}),
        ("mirrored", "part, mirrored", {"mirrored": True}),
        ("split", "part with split faces", {"split": True}),
    ):
        drawn(wrong, **how)
        for ending in ("step", "brep"):
            gmsh.write(str(folder / f"{name}.{ending}"))
            yield Item(f"{name}.{ending}", f"{tried}, mm", "scaled", expected)
    for unit, scale in (("m", 1e-3), ("in", 1 / INCH)):
        drawn(wrong * scale)
        gmsh.write(str(folder / f"{unit}.brep"))
        yield Item(f"{unit}.brep", f"part, {unit}", "scaled", expected, options=["--unit", unit])
        gmsh.write(str(folder / f"{unit}.step"))
        yield Item(f"{unit}.step", f"part, {unit}", "scaled", expected, options=["--unit", unit])
    for order in (1, 2):
        drawn(wrong)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 8)
        gmsh.option.setNumber("Mesh.ElementOrder", order)
        gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="rod")
        gmsh.model.mesh.generate(3)
        volume = own_volume() / wrong**3
        for name, of, version, binary in MESHES:
            if of != order:
                continue
            gmsh.option.setNumber("Mesh.Binary", binary)
            if version:
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.write(str(folder / name))
            tried = f"order {order}{f', format {version}' if version else ''}{', binary' * binary}"
            yield Item(name, tried, "scaled", {"volume_mm3": volume, "length_mm": LENGTH}, 1e-4)


gmsh.initialize(["", "-v", "1"], readConfigFiles=False)
judge(gmsh.__version__, reads, writes)
