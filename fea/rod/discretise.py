"""From a study's rod to the meshed cell and the whole it stands for."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from fea.choices import Symmetry
from fea.machine.clock import Clock
from fea.machine.forked import allow, apart
from fea.machine.guard import memory_limit
from fea.material import Material
from fea.rod.case_forces import Bores
from fea.rod.flaws import mass_error, mesh_flaws
from fea.rod.omission import Omission
from fea.study.study import Study
from geometry.arrays import Ints
from geometry.invalid import require
from geometry.mirror import Mirror
from geometry.session import session
from geometry.solid import Solid
from geometry.surfaces import Surface
from mesh.estimate import estimate
from mesh.generate import tetrahedralise
from mesh.mirror import MirroredMesh, reflect, unmirrored
from mesh.quality import Quality
from mesh.repair import Repair
from mesh.repaired import repaired
from mesh.size_field import SizeField
from mesh.sizing import PER_ARC, Sizing, default_size, refinements
from mesh.tetmesh import TetMesh

# Processor time, s, after which gmsh is taken to be lost in a damaged file: ten million elements take less.
_MESHING = 3600.0
# Elements of the drawn cell, by estimate, that gmsh makes within that time.
_MOST_ELEMENTS = 1e7
# gmsh says so of elements that are mended afterwards: what is left of it, the mesh's own measure tells.
_MENDED = "worst distortion"


@dataclass(frozen=True)
class Discretised:
    """A meshed rod.

    Attributes
    ----------
    cell
        What is solved.
    whole
        The whole rod, from the cell.
    drawn
        What gmsh meshed, the smallest mirror cell: its nodes and elements come first in the others.
    drawn_node
        (n_nodes,) node of `drawn` behind each node of the whole.
    quality
        Of the mesh.
    bores
        Dimensions the pressures need.
    parts
        Volume of each part of the whole solid by the CAD kernel, mm³, by name.
    symmetry
        Which part the cell is.
    size
        Element size, mm.
    repair
        What was done otherwise than this size asks for.
    left_out
        What the symmetry spares.
    warnings
        What gmsh had to say.
    refined
        Whether earlier solutions had a say in the sizes.
    """

    cell: TetMesh
    whole: MirroredMesh
    drawn: TetMesh
    drawn_node: Ints
    quality: Quality
    bores: Bores
    parts: dict[str, float]
    symmetry: Mirror
    size: float
    repair: Repair
    left_out: tuple[Omission, ...]
    warnings: tuple[str, ...]
    refined: bool

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader must know of the mesh: a coarse size, mended elements, complaints of gmsh."""
        coarser = self.size / default_size(self.bores.rod_length)
        count = self.quality.straightened
        notes = []
        if coarser > 1.01 and not self.refined:
            notes.append(
                f"elements of {self.size:g} mm are {coarser:.2g} times the default: {PER_ARC / coarser:.1f} "
                f"in place of {PER_ARC} through a fillet's arc, so peaks may be too low"
            )
        notes += self.repair.notes
        if count:
            elements = "1 element has" if count == 1 else f"{count} elements have"
            notes.append(f"{elements} straight edges where curved ones would have distorted the shape")
        warnings = (warning for warning in self.warnings if _MENDED not in warning)
        return (*notes, *(f"gmsh: {warning}" for warning in warnings))

    @property
    def cut_y(self) -> bool:
        """Whether the cell is cut at y = 0."""
        return Surface.SYMMETRY_Y in self.symmetry.planes

    def mass_error(self, meshed: float, materials: Sequence[Material]) -> float:
        """Relative difference of the meshed mass (whole rod, t) from the solid's."""
        return mass_error(meshed, self.parts.values(), materials)


@dataclass(frozen=True)
class _Drawn:
    """What leaves the session of gmsh."""

    solid: Solid
    mesh: TetMesh
    quality: Quality
    size: float
    repair: Repair
    warnings: tuple[str, ...]


def discretise(
    study: Study, clock: Clock, wanted: Sequence[SizeField] = (), coarser: float = 1.0
) -> Discretised:
    """Draw and mesh the rod of a study.

    The smallest mirror cell is meshed; larger cells are put together from its reflections, so that
    the mesh of the whole is the same whichever part is solved.

    Parameters
    ----------
    study
        What is asked.
    clock
        Times the stages ``geometry`` and ``mesh``.
    wanted
        Sizes that earlier solutions ask for, on their `Discretised.drawn`.
    coarser
        Factor on the default size.

    Raises
    ------
    InvalidValue
        The rod has no dimensions or not the symmetry asked for.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """
    if study.rod.step is None or memory_limit() is not None:  # under a limit the whole program is guarded
        drawn = _drawn(study, clock, wanted, coarser)
    else:
        with clock("mesh"):
            drawn = apart(
                lambda: _drawn(study, Clock(), wanted, coarser), f"read and mesh {study.rod.step.path}"
            )
    solid, base = drawn.solid, drawn.mesh
    symmetry = _cell(study.analysis.symmetry, solid.mirror)
    with clock("mesh"):
        cell = unmirrored(base)
        for plane in solid.mirror.planes:
            if plane not in symmetry.planes:
                cell = reflect(cell, plane)
        whole = unmirrored(cell.mesh)
        for plane in symmetry.planes:
            whole = reflect(whole, plane)
    return Discretised(
        cell=cell.mesh,
        whole=whole,
        drawn=base,
        drawn_node=cell.source[whole.source],
        quality=drawn.quality,
        bores=_bores(solid),
        parts={part.name: part.mass.mass for part in solid.parts},
        symmetry=symmetry,
        size=drawn.size,
        repair=drawn.repair,
        left_out=_spared(symmetry),
        warnings=drawn.warnings,
        refined=bool(wanted),
    )


def _drawn(study: Study, clock: Clock, wanted: Sequence[SizeField], coarser: float) -> _Drawn:
    """Draw and mesh in a session of its own."""
    with session() as log:
        with clock("geometry"):
            solid = study.rod.draw()
        allow(_MESHING)
        with clock("mesh"):
            length = solid.bores[1].x
            size = study.mesh.size_mm or coarser * default_size(length)
            refined = refinements(solid.features, size, length)
            sizing = Sizing(size, study.mesh.element.order)
            _require_few(estimate(refined, sizing), size)
            volumes = [part.volumes for part in solid.parts]
            drawing = log.warnings
            made = repaired(
                partial(tetrahedralise, solid.faces, refined, sizing, volumes, wanted),
                partial(mesh_flaws, study, solid),
                log,
                lambda cause: clock.tell(f"meshing again: {cause}"),
            )
    warnings = tuple(dict.fromkeys((*drawing, *made.warnings)))
    return _Drawn(solid, made.mesh, made.quality, size, made.repair, warnings)


def _require_few(elements: float, size: float) -> None:
    """Refuse a size that gmsh would work on for hours."""
    coarser = size * (elements / _MOST_ELEMENTS) ** (1 / 3)
    require(
        elements <= _MOST_ELEMENTS,
        "mesh.size_mm",
        size,
        f"makes about {elements:.2g} elements, and more than {_MOST_ELEMENTS:.0e} are not meshed",
        f"Take {1.05 * coarser:.2g} mm or more.",
    )


def _cell(asked: Symmetry, smallest: Mirror) -> Mirror:
    """The mirror cell to solve: the smallest one unless a larger one is asked for.

    Raises
    ------
    InvalidValue
        The rod does not have the symmetry asked for.
    """
    if asked is Symmetry.AUTO:
        return smallest
    cell = Mirror(asked.value)
    rule = f"the rod's smallest mirror cell is {smallest}"
    possible = set(cell.planes) <= set(smallest.planes)
    require(possible, "analysis.symmetry", str(asked), rule, "Choose auto.")
    return cell


def _bores(solid: Solid) -> Bores:
    big, small = solid.bores
    return Bores(small.x, big.radius, big.width, small.radius, small.width, small.taper)


def _spared(symmetry: Mirror) -> tuple[Omission, ...]:
    half = Omission("elements at z < 0", "rod and loads are symmetric about z = 0")
    quarter = Omission(
        "elements at y < 0",
        "the rod is symmetric about y = 0; loads are split into a symmetric and an antisymmetric part",
    )
    return {Mirror.QUARTER: (half, quarter), Mirror.HALF: (half,), Mirror.NONE: ()}[symmetry]
