"""From a study's rod to the meshed cell and the whole it stands for."""

from dataclasses import dataclass

from fea.case_loads import Bores
from fea.choices import Symmetry
from fea.clock import Clock
from fea.omission import Omission
from fea.study import Study
from geometry.mirror import Mirror
from geometry.rod import Rod
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Surface
from mesh.generate import tetrahedralise
from mesh.mirror import MirroredMesh, reflect, unmirrored
from mesh.quality import Quality
from mesh.sizing import Sizing, default_size, refinements
from mesh.tetmesh import TetMesh

# Planes the solved cell keeps.
_KEPT = {
    Symmetry.QUARTER: (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z),
    Symmetry.HALF: (Surface.SYMMETRY_Z,),
    Symmetry.NONE: (),
}


@dataclass(frozen=True)
class Discretised:
    """A meshed rod.

    Attributes
    ----------
    cell
        What is solved.
    whole
        The whole rod, from the cell.
    quality
        Of the mesh.
    bores
        Dimensions the pressures need.
    volume
        Of the whole solid by the CAD kernel, mm³.
    symmetry
        Which part the cell is.
    size
        Element size, mm.
    left_out
        What the symmetry spares.
    warnings
        What gmsh had to say.
    """

    cell: TetMesh
    whole: MirroredMesh
    quality: Quality
    bores: Bores
    volume: float
    symmetry: Symmetry
    size: float
    left_out: tuple[Omission, ...]
    warnings: tuple[str, ...]

    @property
    def planes(self) -> tuple[Surface, ...]:
        """Mirror planes the cell is cut at."""
        return _KEPT[self.symmetry]

    @property
    def cut_y(self) -> bool:
        """Whether the cell is cut at y = 0."""
        return Surface.SYMMETRY_Y in self.planes

    @property
    def images(self) -> int:
        """How many cells make the whole."""
        return 1 << len(self.planes)

    def volume_error(self, meshed: float) -> float:
        """Relative difference of a meshed volume (whole rod, mm³) from the solid's."""
        return abs(meshed / self.volume - 1)


def discretise(study: Study, clock: Clock) -> Discretised:
    """Draw and mesh the rod of a study.

    The smallest mirror cell is meshed; larger cells are put together from its reflections, so that
    the mesh of the whole is the same whichever part is solved.

    Raises
    ------
    InvalidValue
        The rod has no dimensions or not the symmetry asked for.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """
    rod = study.rod.solid()
    with session() as log:
        with clock("geometry"):
            solid = build(rod, rod.smallest_cell)
        with clock("mesh"):
            size = study.mesh.size_mm or default_size(rod.length)
            refined = refinements(solid.features, size, rod.length)
            sizing = Sizing(size, study.mesh.element.order)
            base, quality = tetrahedralise(solid.faces, refined, sizing)
    symmetry = study.analysis.symmetry
    if symmetry is Symmetry.AUTO:
        symmetry = Symmetry.QUARTER
    with clock("mesh"):
        cell = unmirrored(base)
        for plane in _planes(solid.mirror):
            if plane not in _KEPT[symmetry]:
                cell = reflect(cell, plane)
        whole = unmirrored(cell.mesh)
        for plane in _KEPT[symmetry]:
            whole = reflect(whole, plane)
    return Discretised(
        cell.mesh,
        whole,
        quality,
        _bores(rod),
        solid.mass.mass,
        symmetry,
        size,
        _spared(symmetry),
        log.warnings,
    )


def _planes(mirror: Mirror) -> tuple[Surface, ...]:
    return mirror.planes


def _bores(rod: Rod) -> Bores:
    return Bores(
        rod.length, rod.big_end_bore / 2, rod.big_end_width, rod.small_end_bore / 2, rod.small_end_width
    )


def _spared(symmetry: Symmetry) -> tuple[Omission, ...]:
    half = Omission("elements at z < 0", "rod and loads are symmetric about z = 0")
    quarter = Omission(
        "elements at y < 0",
        "the rod is symmetric about y = 0; loads are split into a symmetric and an antisymmetric part",
    )
    return {Symmetry.QUARTER: (half, quarter), Symmetry.HALF: (half,), Symmetry.NONE: ()}[symmetry]
