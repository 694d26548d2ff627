"""Mesh the rod of a study: the mirror cell that is solved, and the whole rod that it represents."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fea.choices import Symmetry
from fea.machine.clock import Clock
from fea.machine.forked import allow, apart, say
from fea.machine.guard import memory_limit
from fea.material import Material
from fea.rod.bores import Bores
from fea.rod.flaws import MaterialsOf, mass_error, mesh_flaws
from fea.rod.omission import Omission
from fea.study.rod_table import RodTable
from geometry.arrays import Ints
from geometry.assembly import Assembly, BoltAxis
from geometry.intake import Intake
from geometry.invalid import require
from geometry.mirror import Mirror
from geometry.session import session
from geometry.solid import Solid
from geometry.surfaces import Surface
from mesh.creases import Creases, creases
from mesh.estimate import estimate
from mesh.generate import tetrahedralise
from mesh.mirror import MirroredMesh, reflect, unmirrored
from mesh.numbering import numbered
from mesh.quality import Quality
from mesh.repair import Repair
from mesh.repaired import repaired
from mesh.separate import separated
from mesh.size_field import SizeField
from mesh.sizing import PER_ARC, PER_TOUCHED_BORE, Sizing, default_size, refinements
from mesh.tetmesh import TetMesh

if TYPE_CHECKING:
    from mesh.moving import MovableMesh

# Processor time, s, after which gmsh is assumed not to finish (on a damaged file), and more of it for each
# element to be made, several times what one takes.
_MESHING, _PER_ELEMENT = 120.0, 1.5e-4
# Estimated number of elements of the drawn cell that gmsh makes within that time.
_MOST_ELEMENTS = 1e7
# Parts of gmsh's warnings that need not concern a reader: distorted elements are repaired afterwards, and the
# mesh quality measures what remains; edges that no face needs are left where holes lie on a mirror plane.
_HARMLESS = ("worst distortion", "BOPAlgo_AlertFaceBuilderUnusedEdges")


@dataclass(frozen=True)
class Meshing:
    """How a mesh came about.

    Attributes
    ----------
    size
        Element size asked for, mm.
    quality
        Of the elements.
    repair
        What was done differently from what this size asks for.
    warnings
        Of gmsh.
    follows_errors
        Whether errors of solutions set the sizes.
    given
        Of a mesh from a file, what a reader must know of it; empty for a mesh of our own.
    """

    size: float
    quality: Quality
    repair: Repair
    warnings: tuple[str, ...]
    follows_errors: bool = False
    given: tuple[str, ...] = ()

    def notes(self, rod_length: float) -> tuple[str, ...]:
        """Return what a reader must know of the mesh: coarse elements, repairs, warnings of gmsh."""
        coarser = self.size / default_size(rod_length)
        count = self.quality.straightened
        notes = [*self.given]
        if coarser > 1.01 and not self.follows_errors and not self.given:
            notes.append(
                f"elements of {self.size:g} mm are {coarser:.2g} times the default size: with only "
                f"{PER_ARC / coarser:.1f} of them along a fillet's arc, peak stresses may be too low"
            )
        notes += self.repair.notes
        if count:
            elements = "1 element has" if count == 1 else f"{count} elements have"
            why = "because curved edges would have distorted the shape"
            notes.append(f"{elements} straight edges, {why}")
        warnings = (text for text in self.warnings if not any(known in text for known in _HARMLESS))
        return (*notes, *(f"gmsh: {warning}" for warning in warnings))


@dataclass(frozen=True, kw_only=True)
class MeshedRod:
    """A meshed rod.

    Attributes
    ----------
    cell
        The part that is solved.
    mirrored
        The whole rod, put together from the cell.
    drawn
        What gmsh meshed: the smallest mirror cell.
    drawn_node
        (n_nodes,) node of `drawn` behind each node of the whole.
    creases
        Of `drawn`; None for a mesh from a file, where the turns of its facets tell sharp edges.
    bores
        Dimensions the pressures need.
    parts
        Volume of each part of the whole solid by the CAD kernel, mm³, by name.
    symmetry
        Which mirror cell is solved.
    meshing
        Size, quality and repairs.
    intake
        What was made of the CAD file; None for a rod drawn from dimensions.
    bolts
        Of the whole rod; empty without an assembly. Parts that only touch have nodes of their own in `cell`
        and `mirrored`, not in `drawn`.
    movable
        `drawn`, ready to follow other dimensions; None where that was not asked for.
    """

    cell: TetMesh
    mirrored: MirroredMesh
    drawn: TetMesh
    drawn_node: Ints
    bores: Bores
    parts: dict[str, float]
    symmetry: Mirror
    meshing: Meshing
    intake: Intake | None = None
    creases: Creases | None = None
    bolts: tuple[BoltAxis, ...] = ()
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
    def notes(self) -> tuple[str, ...]:
        """What a reader must know of the mesh."""
        assumed = () if self.intake is None else self.intake.assumed
        return (*assumed, *self.meshing.notes(self.bores.rod_length))

    @property
    def left_out(self) -> tuple[Omission, ...]:
        """What the symmetry spares."""
        return _spared(self.symmetry)

    @property
    def cut_y(self) -> bool:
        """Whether the cell is cut at y = 0."""
        return Surface.SYMMETRY_Y in self.symmetry.planes

    def mass_error(self, meshed: float, materials: Sequence[Material]) -> float:
        """Relative difference of the meshed mass (whole rod, t) from the solid's."""
        return mass_error(meshed, self.parts.values(), materials)


class _Drawn(NamedTuple):
    """What leaves the session of gmsh."""

    solid: Solid
    mesh: TetMesh
    meshing: Meshing
    creases: Creases | None
    movable: "MovableMesh | None" = None


@dataclass(frozen=True, kw_only=True)
class MeshRequest:
    """What a mesh is asked for.

    Attributes
    ----------
    size
        Element size, mm; None for `coarser` times the default of the rod's length.
    order
        Of the elements, 1 or 2.
    symmetry
        Which mirror cell to solve.
    wanted
        Sizes that errors of earlier solutions ask for, on their `MeshedRod.drawn`.
    coarser
        Factor on the default size.
    touched
        Whether pins touch the bores, which need smaller elements then.
    assembly
        What is separate in the rod; None for a rod in one piece.
    movable
        Whether the mesh is to follow other dimensions of the rod.
    """

    size: float | None
    order: int
    symmetry: Symmetry = Symmetry.AUTO
    wanted: Sequence[SizeField] = ()
    coarser: float = 1.0
    touched: bool = False
    assembly: Assembly | None = None
    movable: bool = False

    @property
    def per_touched_bore(self) -> int:
        """Least number of elements around a bore that a pin touches; 0 where none does."""
        provisional = self.coarser != 1.0 and not self.wanted
        return int(self.touched) * (PER_TOUCHED_BORE // 2 if provisional else PER_TOUCHED_BORE)

    @property
    def follows_errors(self) -> bool:
        """Whether errors of solutions set the sizes: this mesh, or the one that it is the first for."""
        return bool(self.wanted) or self.coarser != 1.0


def discretise(rod: RodTable, materials: MaterialsOf, request: MeshRequest, clock: Clock) -> MeshedRod:
    """Draw and mesh a rod.

    The smallest mirror cell is meshed; larger cells are assembled from its reflections, so that the mesh of
    the whole rod does not depend on which part is solved.

    Parameters
    ----------
    rod
        Its dimensions or its file.
    materials
        Gives the material of each named part: a mesh whose mass is off is made again.
    request
        Size, order and symmetry.
    clock
        Times the stages ``geometry`` and ``mesh``.

    Raises
    ------
    InvalidValue
        The rod has no dimensions or not the requested symmetry, or its parts do not go together.
    GeometryError, MeshError
        No solid or no usable mesh could be made.
    """
    if rod.cad is None or memory_limit() is not None:  # under a limit the whole program is guarded
        drawn = _drawn(rod, materials, request, clock)
    else:
        with clock("mesh"):
            job = partial(_drawn, rod, materials, request, Clock(say))
            drawn = apart(job, f"read and mesh {rod.cad.path}", clock.tell)
    with clock("mesh"):
        return _put_together(drawn, _cell(request.symmetry, drawn.solid.mirror))


def moved(base: MeshedRod, rod: RodTable) -> MeshedRod | None:
    """Move the mesh of a rod to one of other dimensions; its quality is measured again.

    Parameters
    ----------
    base
        Made with `MeshRequest.movable`.
    rod
        The other dimensions.

    Returns
    -------
    MeshedRod or None
        None where the mesh cannot follow: see `mesh.moving.MovableMesh.moved`.

    Raises
    ------
    GeometryError
        No solid could be made.
    """
    if base.movable is None:
        return None
    with session():
        solid = rod.draw()
        found = base.movable.moved()
    if found is None:
        return None
    mesh, quality = found
    meshing = replace(base.meshing, quality=quality)
    return _put_together(_Drawn(solid, mesh, meshing, base.creases, base.movable), base.symmetry)


def _put_together(drawn: _Drawn, symmetry: Mirror) -> MeshedRod:
    """The cell that is solved and the whole rod, from the smallest cell."""
    solid, base = drawn.solid, drawn.mesh
    bodies, origin = _separate(base, solid)
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
        intake=solid.intake,
        bolts=solid.bolts,
        movable=drawn.movable,
    )


def _drawn(rod: RodTable, materials: MaterialsOf, request: MeshRequest, clock: Clock) -> _Drawn:
    """Draw and mesh in a session of its own."""
    with session() as log:
        with clock("geometry"):
            solid = rod.draw(clock.tell, request.assembly)
        with clock("mesh"):
            length = solid.bores[1].x
            size = request.size or request.coarser * default_size(length)
            refined = refinements(solid.features, size, length, per_touched_bore=request.per_touched_bore)
            sizing = Sizing(size, request.order)
            elements = estimate(refined, sizing)
            _require_few(elements, size)
            allow(_MESHING + _PER_ELEMENT * elements)
            volumes = [part.volumes for part in solid.parts]
            drawing = log.warnings
            made = repaired(
                partial(tetrahedralise, solid.faces, refined, sizing, volumes, request.wanted),
                partial(mesh_flaws, materials, solid),
                log,
                lambda cause: clock.tell(f"meshing again, because {cause}"),
            )
            found = creases(solid.faces, made.mesh, solid.bodies)
            movable = _movable(made.mesh) if request.movable else None
    warnings = tuple(dict.fromkeys((*drawing, *made.warnings)))
    meshing = Meshing(size, made.quality, made.repair, warnings, follows_errors=request.follows_errors)
    return _Drawn(solid, made.mesh, meshing, found, movable)


def _movable(mesh: TetMesh) -> "MovableMesh":
    from mesh.anchors import anchors  # noqa: PLC0415 - only a search for dimensions needs them
    from mesh.moving import MovableMesh  # noqa: PLC0415

    return MovableMesh(mesh, anchors(mesh))


def _separate(mesh: TetMesh, solid: Solid) -> tuple[TetMesh, Ints]:
    """The mesh with nodes of its own for each body, and (n_nodes,) the drawn node behind each."""
    if not solid.interfaces:
        return mesh, np.arange(len(mesh.points))
    doubled, origin = separated(mesh, {one.parts: one.sides for one in solid.interfaces})
    ordered, order = numbered(doubled)
    return ordered, origin[order]


def _require_few(elements: float, size: float) -> None:
    """Refuse an element size with which gmsh would take hours."""
    coarser = size * (elements / _MOST_ELEMENTS) ** (1 / 3)
    require(
        elements <= _MOST_ELEMENTS,
        "mesh.size_mm",
        size,
        f"gives about {elements:.2g} elements; at most {_MOST_ELEMENTS / 1e6:.0f} million are allowed",
        f"Use {1.05 * coarser:.2g} mm or more.",
    )


def _cell(asked: Symmetry, smallest: Mirror) -> Mirror:
    """The mirror cell to solve: the smallest one unless a larger one is requested.

    Raises
    ------
    InvalidValue
        The rod does not have the requested symmetry.
    """
    if asked is Symmetry.AUTO:
        return smallest
    cell = Mirror(asked.value)
    rule = f"the rod is not that symmetric: its smallest mirror cell is {smallest}"
    possible = set(cell.planes) <= set(smallest.planes)
    require(possible, "analysis.symmetry", str(asked), rule, f"Choose auto or {smallest}.")
    return cell


def _spared(symmetry: Mirror) -> tuple[Omission, ...]:
    half = Omission("elements at z < 0", "rod and loads are symmetric about z = 0")
    quarter = Omission(
        "elements at y < 0",
        "the rod is symmetric about y = 0; loads are split into a symmetric and an antisymmetric part",
    )
    return {Mirror.QUARTER: (half, quarter), Mirror.HALF: (half,), Mirror.NONE: ()}[symmetry]
