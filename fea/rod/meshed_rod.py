"""The mesh of a rod: the symmetry cell that is solved, and the whole rod that it represents."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fea.base.material import Material
from fea.base.note import MODEL, OTHER_RODS, Note, assumption, doubt, omission, remark, warning
from geometry.arrays import Ints
from geometry.assembly import BoltAxis
from geometry.faces import Bore
from geometry.imports import ImportReport
from geometry.solid import Solid
from geometry.surfaces import Mirror, Surface
from mesh.creases import Creases
from mesh.generate import Repair
from mesh.quality import Quality
from mesh.sizing import PER_ARC, default_size
from mesh.tetmesh import MirroredMesh, TetMesh, numbered, reflect, separated, unmirrored

if TYPE_CHECKING:
    from mesh.moving import MovableMesh


def file_notes(read: ImportReport) -> tuple[Note, ...]:
    """What a reader must know of a rod's file."""
    doubts = [doubt(text, MODEL) for text in read.doubts]
    doubts += [doubt(read.carried, OTHER_RODS)] if read.carried else []
    return (*doubts, *map(assumption, read.assumed))


@dataclass(frozen=True)
class Bores:
    """What the pressures need of the rod."""

    rod_length: float  #: between the bores, mm
    #: big_radius, big_width, small_radius, small_width: mm, the widths in the mean
    big_radius: float
    big_width: float
    small_radius: float
    small_width: float
    #: The small end's width at the angle φ from +x is small_width + small_taper cos φ, mm
    small_taper: float = 0.0

    @property
    def between(self) -> tuple[float, float]:
        """X where the big end's bore ends and where the small end's begins, mm."""
        return self.big_radius, self.rod_length - self.small_radius

    @property
    def lengths(self) -> dict[str, float]:
        """Lengths, mm, by their keys in a study."""
        return {
            "rod.length_mm": self.rod_length,
            "rod.big_end_bore_mm": 2 * self.big_radius,
            "rod.small_end_bore_mm": 2 * self.small_radius,
            "rod.small_end_width_mm": self.small_width,
        }

    @classmethod
    def of(cls, bores: tuple[Bore, Bore]) -> "Bores":
        """Take the dimensions of the big and the small end's bore."""
        big, small = bores
        return cls(
            rod_length=small.x,
            big_radius=big.radius,
            big_width=big.width,
            small_radius=small.radius,
            small_width=small.width,
            small_taper=small.taper,
        )


# Parts of gmsh's warnings that need not concern a reader: distorted elements are repaired afterwards, and the
# mesh quality measures what remains; edges that no face needs are left where holes lie on a mirror plane, and
# edges shorter than the kernel's tolerance cannot be divided.
_HARMLESS = ("worst distortion", "BOPAlgo_AlertFaceBuilderUnusedEdges", "BOPAlgo_AlertNotSplittableEdge")


@dataclass(frozen=True)
class Meshing:
    """How a mesh came about."""

    size: float  #: element size asked for, mm
    quality: Quality  #: of the elements
    repair: Repair  #: what was done differently from what this size asks for
    warnings: tuple[str, ...]  #: of gmsh
    follows_errors: bool = False  #: whether errors of solutions set the sizes
    refined: bool = False  #: whether errors of a solution have set them
    #: Of a mesh from a file, what a reader must know of it; empty for a mesh of our own
    given: tuple[str, ...] = ()

    def notes(self, rod_length: float) -> tuple[Note, ...]:
        """Return what a reader must know of the mesh: coarse elements, repairs, warnings of gmsh."""
        coarser = self.size / default_size(rod_length)
        count = self.quality.straightened
        limits, done = [*self.given], [*self.repair.notes]
        if coarser > 1.01 and not self.follows_errors and not self.given:
            limits.append(
                f"elements of {self.size:g} mm are {coarser:.2g} times the default size: with only "
                f"{PER_ARC / coarser:.1f} of them along a fillet's arc, peak stresses may be too low"
            )
        if count:
            elements = "1 element has" if count == 1 else f"{count} elements have"
            why = "because curved edges would have distorted the shape"
            done.append(f"{elements} straightened edges, {why}")
        of_gmsh = (text for text in self.warnings if not any(known in text for known in _HARMLESS))
        return (*map(warning, limits), *map(remark, done), *(remark(text, "gmsh") for text in of_gmsh))


@dataclass(frozen=True, kw_only=True)
class MeshedRod:
    """A meshed rod."""

    cell: TetMesh  #: the part that is solved
    mirrored: MirroredMesh  #: the whole rod, put together from the cell
    drawn: TetMesh  #: what gmsh meshed: the smallest symmetry cell
    drawn_node: Ints  #: (n_nodes,) node of `drawn` behind each node of the whole
    bores: Bores  #: dimensions the pressures need
    parts: dict[str, float]  #: volume of each part of the whole solid by the CAD kernel, mm³, by name
    symmetry: Mirror  #: which symmetry cell is solved
    meshing: Meshing  #: size, quality and repairs
    #: What was made of the CAD file; None for a rod drawn from dimensions
    imported: ImportReport | None = None
    #: Of `drawn`; None for a mesh from a file, where the turns of its facets tell sharp edges
    creases: Creases | None = None
    #: Of the whole rod; empty without an assembly. Parts that only touch have nodes of their own in `cell`
    #: and `mirrored`, not in `drawn`.
    bolts: tuple[BoltAxis, ...] = ()
    #: `drawn`, ready to follow other dimensions; None where that was not asked for
    movable: "MovableMesh | None" = None

    @property
    def whole(self) -> TetMesh:
        """Mesh of the whole rod."""
        return self.mirrored.mesh

    @property
    def cell_creases(self) -> Creases | None:
        """The creases for `cell`; None where they are not known."""
        if self.creases is None:
            return None
        drawn = np.empty(len(self.cell.points), dtype=np.int64)
        drawn[self.mirrored.source] = self.drawn_node
        return self.creases.on(drawn)

    @property
    def notes(self) -> tuple[Note, ...]:
        """What a reader must know of the mesh."""
        read = self.imported
        of_file = () if read is None else file_notes(read)
        return (*of_file, *self.meshing.notes(self.bores.rod_length))

    @property
    def omissions(self) -> tuple[Note, ...]:
        """What the symmetry spares."""
        half = omission("elements at z < 0", "rod and loads are symmetric about z = 0")
        quarter = omission(
            "elements at y < 0",
            "the rod is symmetric about y = 0; loads are split into a symmetric and an antisymmetric part",
        )
        return {Mirror.QUARTER: (half, quarter), Mirror.HALF: (half,), Mirror.NONE: ()}[self.symmetry]

    @property
    def cut_y(self) -> bool:
        """Whether the cell is cut at y = 0."""
        return Surface.SYMMETRY_Y in self.symmetry.planes

    def mass_error(self, meshed: float, materials: Sequence[Material]) -> float:
        """Relative difference of the meshed mass (whole rod, t) from the solid's."""
        return mass_error(meshed, self.parts.values(), materials)


def mass_error(meshed: float, volumes: Iterable[float], materials: Sequence[Material]) -> float:
    """Relative difference of the meshed mass (whole rod, t) from that of the solid's parts, mm³."""
    solid = sum(m.density * volume for m, volume in zip(materials, volumes, strict=True))
    return abs(meshed / solid - 1)


class Drawn(NamedTuple):
    """What leaves the session of gmsh."""

    solid: Solid
    mesh: TetMesh
    meshing: Meshing
    creases: Creases | None
    movable: "MovableMesh | None" = None


def put_together(drawn: Drawn, symmetry: Mirror) -> MeshedRod:
    """Return the cell of a symmetry that is solved and the whole rod, from the drawn cell."""
    solid, base = drawn.solid, drawn.mesh
    bodies, origin = base, np.arange(len(base.points))
    if solid.interfaces:  # nodes of its own for each body
        doubled, drawn_node = separated(base, {one.parts: one.sides for one in solid.interfaces})
        bodies, order = numbered(doubled)
        origin = drawn_node[order]
    cell = unmirrored(bodies)
    for plane in solid.mirror.planes:
        if plane not in symmetry.planes:
            cell = reflect(cell, plane)
    whole = unmirrored(cell.mesh)
    for plane in symmetry.planes:
        whole = reflect(whole, plane)
    return MeshedRod(
        cell=cell.mesh,
        mirrored=whole,
        drawn=base,
        drawn_node=origin[cell.source[whole.source]],
        creases=drawn.creases,
        bores=Bores.of(solid.bores),
        parts={part.name: part.mass.mass for part in solid.parts},
        symmetry=symmetry,
        meshing=drawn.meshing,
        imported=solid.imported,
        bolts=solid.bolts,
        movable=drawn.movable,
    )
