"""The choice of a linear solver by the memory that it needs."""

from pathlib import Path

from fea.base.choices import SolverName
from fea.base.material import Material, Materials
from fea.machine.system import free_under_limit, memory_of_machine
from fea.solvers.direct import direct, direct_solver, require_packages
from fea.solvers.iterative import Multigrid
from fea.solvers.linear_solver import LinearSolver
from mesh.tetmesh import TetMesh


def chosen(choice: SolverName, n_dofs: int, slots: int) -> SolverName:
    """Resolve `AUTO`: direct while factors fit into memory, else multigrid; `MemoryError` beyond that."""
    if choice is not SolverName.AUTO:
        return choice
    free = SHARE * available_bytes()
    if direct_bytes(n_dofs, slots) <= free:
        return direct()
    # Multigrid takes a part proportional to the degrees of freedom, and a coarse factor.
    need = slots * (2300.0 * n_dofs + direct_bytes(n_dofs // 8, 1))
    if need <= free:
        return SolverName.AMG
    coarser = (need / free) ** (1 / 3)
    message = (
        f"{n_dofs} degrees of freedom need about {need / MIB:.0f} MiB even with the iterative solver, "
        f"but only {free / MIB:.0f} MiB are available. Use elements {coarser:.2f} times as large "
        "(--size)"
    )
    raise MemoryError(message)


def linear_solver(
    choice: SolverName, mesh: TetMesh, material: Material | Materials, slots: int
) -> LinearSolver:
    """Return a solver for a mesh's stiffness. `SolverUnavailableError`: not installed; `MemoryError`."""
    choice = chosen(choice, mesh.points.size, slots)
    if choice is not SolverName.AMG:
        return direct_solver(slots, choice)
    if mesh.order == 1:
        require_packages(choice)
    return Multigrid(mesh, material)


MIB = 2**20
# Fraction of the free memory that a solver may use; the rest is for stress, output and other programs.
SHARE = 0.8


def direct_bytes(n_dofs: int, slots: int) -> float:
    """Predicted bytes of direct factors.

    The entries of the factor grow like n^1.5 for rods of second-order tetrahedra with 40 000 to 280 000
    degrees of freedom (nested dissection in three dimensions tends to n^(4/3), so that the prediction is too
    high for larger ones). Pardiso's factor that condenses forces has 5 % more entries for the bores of a rod
    in one piece, 20 % more for all interfaces of one in parts, and its analysis takes 1.4 kB per degree of
    freedom: the prediction holds for it to 15 %, which `SHARE` leaves free.
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
