"""Draw and mesh the rod of a study, or move the mesh of another."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fea.base.checks import LIMITS
from fea.base.choices import Symmetry
from fea.base.material import Material, of_parts
from fea.machine.clock import Clock
from fea.machine.isolated import IsolatedProcess, allow, begun, say
from fea.machine.system import memory_limit
from fea.rod.meshed_rod import Drawn, MeshedRod, Meshing, mass_error, put_together
from fea.rod.reading import SECONDS, reading_errors
from fea.study.rod_table import RodTable
from geometry.assembly import Assembly
from geometry.errors import require
from geometry.session import GmshLog, session
from geometry.solid import Solid
from geometry.surfaces import Mirror
from mesh.creases import creases
from mesh.generate import NOTHING, Repair, of_elements, of_folds, repaired, tetrahedralise
from mesh.quality import Quality, scaled_jacobian, shape
from mesh.sizing import PER_BORE, PER_TOUCHED_BORE, SizeField, Sizing, default_size, estimate, refinements
from mesh.tetmesh import TetMesh

# Processor time, s, after which gmsh is assumed not to finish (on a damaged file), and more of it for each
# element to be made, several times what one takes.
_MESHING, _PER_ELEMENT = 120.0, 1.5e-4
# Estimated number of elements of the drawn cell that gmsh makes within that time.
_MOST_ELEMENTS = 1e7


# From the names of parts to the material of each.
MaterialsOf = Callable[[Iterable[str]], tuple[Material, ...]]
_LEAST_SHAPE = 1 / LIMITS["flattest_element"]
_BENT = 0.25  # scaled Jacobian of an element that can no longer follow its arc


@dataclass(frozen=True, kw_only=True)
class MeshRequest:
    """What a mesh is asked for."""

    size: float | None  #: element size, mm; None for `coarser` times the default of the rod's length
    order: int  #: of the elements, 1 or 2
    symmetry: Symmetry = Symmetry.AUTO  #: which symmetry cell to solve
    #: Sizes that errors of earlier solutions ask for, on their `MeshedRod.drawn`
    wanted: Sequence[SizeField] = ()
    coarser: float = 1.0  #: factor on the default size
    touched: bool = False  #: whether pins touch the bores, which need smaller elements then
    assembly: Assembly | None = None  #: what is separate in the rod; None for a rod in one piece
    movable: bool = False  #: whether the mesh is to follow other dimensions of the rod

    @property
    def per_touched_bore(self) -> int:
        """Least number of elements around a bore that a pin touches; 0 where none does."""
        # In a rod in parts no more than around any bore, as each adds to the seats behind it.
        least = PER_TOUCHED_BORE if self.assembly is None else min(PER_TOUCHED_BORE, PER_BORE)
        provisional = self.coarser != 1.0 and not self.wanted
        return int(self.touched) * (least // 2 if provisional else least)

    @property
    def follows_errors(self) -> bool:
        """Whether errors of solutions set the sizes: this mesh, or the one that it is the first for."""
        return bool(self.wanted) or self.coarser != 1.0


def discretise(rod: RodTable, materials: MaterialsOf, request: MeshRequest, clock: Clock) -> MeshedRod:
    """Draw and mesh a rod; within `drawn_once`, one that is meshed again is not drawn again.

    The smallest symmetry cell is meshed; larger cells are assembled from its reflections, so that the mesh of
    the whole rod does not depend on which part is solved.

    `materials`: gives the material of each named part: a mesh whose mass is off is made again. Raises
    `InvalidValue`: the rod has no dimensions or not the requested symmetry, or its parts do not go together;
    `GeometryError` and `MeshError`: no solid or no usable mesh could be made.
    """
    drawing, kept = _Drawing(rod, materials, request.assembly), _kept.get()
    if kept is not None:
        drawing = next((one for one in kept if one.rod == rod and one.assembly == request.assembly), drawing)
    try:
        with clock("mesh"):
            drawn = drawing.meshed(request, clock)
    finally:
        if kept is None:
            drawing.close()
        elif drawing not in kept:
            kept.append(drawing)
    with clock("mesh"):
        return put_together(drawn, _cell(request.symmetry, drawn.solid.mirror))


_kept: ContextVar["list[_Drawing] | None"] = ContextVar("_kept", default=None)


@contextmanager
def drawn_once() -> Iterator[None]:
    """Keep what is drawn for `discretise` within this block, and what was learnt of its meshes."""
    if _kept.get() is not None:
        yield
        return
    drawings: list[_Drawing] = []
    token = _kept.set(drawings)
    try:
        yield
    finally:
        _kept.reset(token)
        for drawing in drawings:
            drawing.close()


@dataclass
class _Drawing:
    """A rod that may be meshed several times; one from a CAD file stays open in a process of its own."""

    rod: RodTable
    materials: MaterialsOf
    assembly: Assembly | None
    repair: Repair = NOTHING  #: what an earlier mesh needed
    process: IsolatedProcess | None = None

    def meshed(self, request: MeshRequest, clock: Clock) -> Drawn:
        """Draw it, where it is not open yet, and mesh it."""
        if self.rod.cad is None or memory_limit() is not None:  # under a limit the whole program is guarded
            with session() as log:
                drawn = _Model(self, log, clock).meshed(request, clock)
        else:
            what = f"read and mesh {self.rod.cad.path}"
            job = partial(_mesh_opened, _Drawing(self.rod, self.materials, self.assembly), request)
            if self.process is None or not self.process.alive:
                self.close()
                self.process = begun(job, seconds=SECONDS)
            else:
                self.process.begin(job)
            process = self.process
            drawn = reading_errors(lambda: process.result(clock.tell), what)
        self.repair = drawn.meshing.repair
        return drawn

    def close(self) -> None:
        if self.process is not None:
            self.process.close()
            self.process = None


def moved(base: MeshedRod, rod: RodTable) -> MeshedRod | None:
    """Move the mesh of a rod to one of other dimensions; its quality is measured again.

    `base`: made with `MeshRequest.movable`.

    Returns None where the mesh cannot follow: see `mesh.moving.MovableMesh.moved`. Raises `GeometryError`: no
    solid could be made.
    """
    if base.movable is None:
        return None
    with session():
        solid = rod.draw()
        result = base.movable.moved()
    if result is None:
        return None
    mesh, quality = result
    meshing = replace(base.meshing, quality=quality)
    return put_together(Drawn(solid, mesh, meshing, base.creases, base.movable), base.symmetry)


class _Model:  # drawn in the open session
    def __init__(self, drawing: _Drawing, log: GmshLog, clock: Clock) -> None:
        self._log, self._materials = log, drawing.materials
        with clock("geometry"):
            self._solid = drawing.rod.draw(clock.tell, drawing.assembly)
        self._drawing_warnings = log.warnings()
        self._repair = drawing.repair

    def meshed(self, request: MeshRequest, clock: Clock) -> Drawn:
        """Mesh it, again where it has been meshed, with the repairs that were needed then."""
        solid = self._solid
        with clock("mesh"):
            length = solid.bores[1].x
            size = request.size or request.coarser * default_size(length)
            refined = refinements(solid.features, size, length, per_touched_bore=request.per_touched_bore)
            sizing = Sizing(size, request.order)
            elements = estimate(refined, sizing)
            most = f"at most {_MOST_ELEMENTS / 1e6:.0f} million are allowed"
            remedy = f"Use {1.05 * size * (elements / _MOST_ELEMENTS) ** (1 / 3):.2g} mm or more."
            rule = f"gives about {elements:.2g} elements; {most}"
            require(elements <= _MOST_ELEMENTS, "mesh.size_mm", size, rule, remedy)
            allow(_MESHING + _PER_ELEMENT * elements)
            volumes, of_file = [part.volumes for part in solid.parts], solid.imported is not None
            made = repaired(
                partial(
                    tetrahedralise, solid.faces, refined, sizing, volumes, request.wanted, keep_bow=of_file
                ),
                partial(mesh_flaws, self._materials, solid),
                self._log,
                lambda cause: clock.tell(f"meshing again, because {cause}"),
                self._repair,
            )
            self._repair = made.repair
            edges = creases(solid.faces, made.mesh, solid.bodies)
            movable = None
            if request.movable:
                from mesh.moving import MovableMesh, classify  # noqa: PLC0415 - few meshes are moved

                movable = MovableMesh(made.mesh, classify(made.mesh))
        warnings = tuple(dict.fromkeys((*self._drawing_warnings, *made.warnings)))
        of_errors = request.follows_errors, bool(request.wanted)
        meshing = Meshing(size, made.quality, made.repair, warnings, *of_errors)
        return Drawn(solid, made.mesh, meshing, edges, movable)


def mesh_flaws(materials: MaterialsOf, solid: Solid, mesh: TetMesh, quality: Quality) -> Repair | None:
    """Find elements that are too flat or whose straightened or bent edges miss too much mass, and folds.

    `materials`: gives the material of each named part; `solid`: as drawn in the open session.

    Returns None if the mesh passes the checks, or misses mass only because its elements are large.
    """
    flaws = {"too flat": shape(mesh) < _LEAST_SHAPE} if quality.least_shape < _LEAST_SHAPE else {}
    suspect = quality.mended or quality.least_scaled_jacobian < _BENT
    if mesh.order > 1 and suspect:
        from fea.solid.inertia import inertia  # noqa: PLC0415 - only a suspect mesh needs it

        of_each = materials(part.name for part in solid.parts)
        meshed = inertia(mesh, of_parts(of_each, mesh.part).density).properties.mass
        missing = mass_error(meshed, (part.mass.mass for part in solid.parts), of_each)
        if missing > LIMITS["mesh_mass"] and quality.mended:
            flaws["straight where the solid is curved"] = np.isin(np.arange(len(mesh.tets)), quality.mended)
        elif missing > LIMITS["mesh_mass"]:
            flaws["too distorted"] = scaled_jacobian(mesh) < _BENT
    if not flaws:
        return of_folds()
    counts = ((int(bad.sum()), kind) for kind, bad in flaws.items())
    what = " and ".join(f"{n} {'element was' if n == 1 else 'elements were'} {kind}" for n, kind in counts)
    return of_elements(mesh.points[mesh.tets[np.any(list(flaws.values()), axis=0), :4]], what)


# In the process of a `_Drawing`: the session, which ends with the process, and what is drawn in it.
_sessions, _models = ExitStack(), list[_Model]()


def _mesh_opened(drawing: _Drawing, request: MeshRequest) -> Drawn:
    if not _models:
        with ExitStack() as opening:
            log = opening.enter_context(session())
            _models.append(_Model(drawing, log, Clock(say)))
            _sessions.enter_context(opening.pop_all())
    return _models[-1].meshed(request, Clock(say))


def _cell(asked: Symmetry, smallest: Mirror) -> Mirror:
    """The smallest symmetry cell, or the one asked for. Raises `InvalidValue`: the rod does not have it."""
    if asked is Symmetry.AUTO:
        return smallest
    cell = Mirror(asked.value)
    rule = f"the rod is not that symmetric: its smallest symmetry cell is {smallest}"
    possible = set(cell.planes) <= set(smallest.planes)
    require(possible, "analysis.symmetry", str(asked), rule, f"Choose auto or {smallest}.")
    return cell
