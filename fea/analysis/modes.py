"""The job behind `fea modes`: free vibration of the free rod."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fea.analysis.figures import Figures
from fea.analysis.meshing import mesh_study
from fea.base.material import of_parts
from fea.base.note import Note
from fea.rod.meshed_rod import MeshedRod
from fea.solvers.vibration import RIGID, VibrationModes, free_modes
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import require
from mesh.tetmesh import TetMesh

MOST = 50
# Rigid motions have no frequency: what rounding leaves, in parts of the first elastic one.
RIGID_LIMIT = 1e-3
BACKWARD_LIMIT = 1e-10
# Of the polynomials along the rod that tell twisting from bending.
_DEGREE = 6
# Greatest Poisson's ratio by element order: displacement elements lock beyond, those of second order late. On
# a rod of 0.4999 their frequencies still come within 0.7 % of those of smaller elements.
MOST_POISSONS_RATIO = {1: 0.4, 2: 0.4999}
_DIRECTIONS = ("lengthwise", "in the plane of motion", "sideways")


class ModeFigures(Figures):
    """One mode; `orders` are multiples of the crank's rate: a four-stroke engine excites half ones, too."""

    frequency_Hz: float
    moves: str
    orders: Mapping[str, float]


class ModesFigures(Figures):
    """The figures of ``fea modes``."""

    study: str
    nodes: int
    modes: tuple[ModeFigures, ...]
    rigid_share: float
    backward_error: float
    trusted: bool
    notes: tuple[Note, ...]


@dataclass(frozen=True)
class ModesReport:
    """Free vibration of a rod."""

    study: str  #: its name
    speeds: tuple[float, ...]  #: at which the orders are told, rpm
    mesh: TetMesh  #: the whole rod
    modes: VibrationModes  #: the six rigid motions first
    notes: tuple[Note, ...] = ()  #: what a reader must know of the study

    @property
    def elastic(self) -> Floats:
        """Elastic frequencies (n,), Hz, rising."""
        return self.modes.frequencies[RIGID:]

    @property
    def shapes(self) -> dict[str, Floats]:
        """Elastic mode shapes (n_nodes, 3) by name, their largest displacement 1 mm."""
        elastic = np.moveaxis(self.modes.shapes[..., RIGID:], -1, 0)
        return {
            f"mode_{number}": shape / np.linalg.norm(shape, axis=1).max()
            for number, shape in enumerate(elastic, start=1)
        }

    @property
    def rigid_share(self) -> float:
        """Largest frequency of a rigid motion in parts of the first elastic one."""
        return float(self.modes.frequencies[:RIGID].max() / self.elastic[0])

    @property
    def trusted(self) -> bool:
        """Whether the rigid motions are six and the modes solve their equation."""
        return self.rigid_share <= RIGID_LIMIT and self.modes.backward_error <= BACKWARD_LIMIT

    def figures(self) -> ModesFigures:
        """Return the figures in the units their names say."""
        return ModesFigures(
            study=self.study,
            nodes=len(self.mesh.points),
            modes=tuple(
                ModeFigures(
                    frequency_Hz=float(frequency),
                    moves=moves(self.mesh.points, shape),
                    orders={f"{rpm:g}rpm": float(60 * frequency / rpm) for rpm in self.speeds if rpm > 0},
                )
                for frequency, shape in zip(self.elastic, self.shapes.values(), strict=True)
            ),
            rigid_share=self.rigid_share,
            backward_error=self.modes.backward_error,
            trusted=self.trusted,
            notes=self.notes,
        )


def moves(points: Floats, shape: Floats) -> str:
    """Say which way a mode shape (n_nodes, 3) of a rod with nodes at `points` mostly moves."""
    x, y, z = points.T
    along = np.polynomial.chebyshev.chebvander(2 * (x - x.min()) / np.ptp(x) - 1, _DEGREE)
    # Sections that turn about the rod's own axis move by u_y ∝ −z and u_z ∝ y.
    turn = np.concatenate([-z[:, None] * along, y[:, None] * along])
    whole = np.zeros_like(along)
    slide = np.block([[along, whole], [whole, along]])
    across = np.concatenate([shape[:, 1], shape[:, 2]])
    both = np.hstack([turn, slide])
    coefficients = np.linalg.lstsq(both.T @ both, both.T @ across)[0]
    twist = turn @ coefficients[: turn.shape[1]]
    if twist @ twist > (shape**2).sum() / 2:
        return "twisting"
    return _DIRECTIONS[int((shape**2).sum(axis=0).argmax())]


def modes_report(study: Study, count: int, mesh: MeshedRod | None = None) -> ModesReport:
    """Find the lowest `count` elastic modes of a study's rod, by default on a mesh of its own.

    Raises `InvalidValue`: a value of the study breaks a rule; `GeometryError`, `MeshError`: no solid or no
    usable mesh came out; `SingularMatrixError`: the factorisation broke down.
    """
    require(1 <= count <= MOST, "--count", count, f"must lie within 1…{MOST}")
    mesh = mesh_study(study) if mesh is None else mesh
    whole = mesh.whole
    materials = study.materials(mesh.parts)
    most = MOST_POISSONS_RATIO[whole.order]
    nu = max(material.poissons_ratio for material in materials)
    rule = f"must not exceed {most} for fea modes: its displacement elements lock above that"
    require(nu <= most, "material.nu", nu, rule, "Use a smaller value.")
    elastic = of_parts(materials, whole.part)
    speeds = study.engine_speeds(study.engine) if study.engine else ()
    modes = free_modes(whole, elastic, elastic.density, count)
    return ModesReport(study.name, speeds, whole, modes, study.unusual_notes(mesh.bores.lengths))
