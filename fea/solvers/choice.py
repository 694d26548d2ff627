"""The choice of a linear solver by the memory that it needs."""

from pathlib import Path

from fea.base.choices import SolverName
from fea.base.material import Material, Materials
from fea.machine.system import free_under_limit, memory_of_machine
from fea.solvers.direct import LinearSolver, direct, direct_solver
from fea.solvers.iterative import Multigrid
from mesh.tetmesh import TetMesh


def chosen(choice: SolverName, n_dofs: int, slots: int, order: int = 2) -> SolverName:
    """Resolve `AUTO`: direct while factors fit into memory, else multigrid; `MemoryError` beyond that.

    First-order meshes, which have no coarse level, are always solved directly.
    """
    if choice is not SolverName.AUTO:
        return direct() if choice is SolverName.AMG and order == 1 else choice
    solver, need, free = direct(), direct_bytes(n_dofs, slots), SHARE * available_bytes()
    if need > free and order > 1:
        # Multigrid takes a part proportional to the degrees of freedom, and a coarse factor.
        solver, need = SolverName.AMG, slots * (2300.0 * n_dofs + direct_bytes(n_dofs // 8, 1))
    if need <= free:
        return solver
    coarser = (need / free) ** (1 / 3)
    message = (
        f"{n_dofs} degrees of freedom need about {need / MIB:.0f} MiB, but only {free / MIB:.0f} MiB are "
        f"available. Use elements {coarser:.2f} times as large (--size)"
    )
    raise MemoryError(message)


def linear_solver(
    choice: SolverName, mesh: TetMesh, material: Material | Materials, slots: int
) -> LinearSolver:
    """Return a solver for a mesh's stiffness. `SolverUnavailableError`: not installed; `MemoryError`."""
    choice = chosen(choice, mesh.points.size, slots, mesh.order)
    return Multigrid(mesh, material) if choice is SolverName.AMG else direct_solver(slots, choice)


MIB = 2**20
# Fraction of the free memory that a solver may use; the rest is for stress, output and other programs.
SHARE = 0.8


def direct_bytes(n_dofs: int, slots: int) -> float:
    """Predicted bytes of direct factors.

    Their entries grow like n^1.5 for rods of second-order tetrahedra with 40 000 to 280 000 degrees of
    freedom, and more slowly beyond (nested dissection: n^(4/3)). Pardiso's factor that condenses forces has 5
    % more for the bores of a rod in one piece, 20 % more for one in parts, and its analysis takes 1.4 kB per
    degree of freedom: the prediction holds to 15 %, which `SHARE` leaves free.
    """
    return float(slots * 8 * 1.2 * n_dofs**1.5)


def available_bytes() -> float:
    """Memory still available to this process, on the machine, in its control group and under its ulimit."""
    limits = [memory_of_machine().available, _free_in_group(), free_under_limit()]
    return float(min(limit for limit in limits if limit is not None))


def _free_in_group() -> float | None:
    group = Path("/sys/fs/cgroup")
    try:
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        used = (group / "memory.current").read_text(encoding="ascii").strip()
    except OSError:
        return None
    return None if limit == "max" else float(limit) - float(used)
