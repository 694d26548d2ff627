"""Predicted memory of a solver, and the memory available."""

import os
import sys
from pathlib import Path

MIB = 2**20
# Fraction of the free memory that a solver may use; the rest is for stress, output and other programs.
SHARE = 0.8


def direct_bytes(n_dofs: int, slots: int) -> float:
    """Predicted bytes of Cholesky factors.

    The entries of the factor grow like n^1.5 for rods of second-order tetrahedra with 40 000 to 280 000
    degrees of freedom (nested dissection in three dimensions tends to n^(4/3), so that the prediction is too
    high for larger ones).
    """
    return float(slots * 8 * 1.2 * n_dofs**1.5)


def iterative_bytes(n_dofs: int, slots: int) -> float:
    """Predicted bytes of multigrid: a part proportional to the degrees of freedom, and a coarse factor."""
    return slots * (2300.0 * n_dofs + direct_bytes(n_dofs // 8, 1))


def available_bytes() -> float:
    """Memory still available to this process, on the machine, in its control group and under its ulimit."""
    limits = [_free_on_machine(), _free_in_group(), _free_under_limit()]
    return min((limit for limit in limits if limit is not None), default=float("inf"))


def _free_on_machine() -> float | None:
    if sys.platform.startswith("linux"):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * int(line.split()[1])
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return None


def _free_in_group() -> float | None:
    """Limit of a version 2 control group minus its current use."""
    group = Path("/sys/fs/cgroup")
    try:
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        used = (group / "memory.current").read_text(encoding="ascii").strip()
    except OSError:
        return None
    return None if limit == "max" else float(limit) - float(used)


def _free_under_limit() -> float | None:
    """Address space left under ``ulimit -v``."""
    try:
        import resource  # noqa: PLC0415 - not on Windows
    except ImportError:
        return None
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    if soft == resource.RLIM_INFINITY:
        return None
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    return float(soft) - pages * resource.getpagesize()
