"""A computation, its result and its cost."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Computation:
    """A computation: problem, tool, element and size.

    Attributes
    ----------
    tool
        ``fea``, ``fea, mean`` (stress at the boundary averaged over elements, as inside), ``fea, whole`` (no
        mirror plane used), ``fea --tolerance`` (from the default size, or with a ``--size``) or ``CalculiX``.
    element
        ``p1`` or ``p2``.
    problem
        ``rod``, ``lame`` or ``goodier``.
    size
        Element size, mm, or the tolerance in percent for ``--tolerance``.
    first_size
        Element size, mm, from which the refinement to a tolerance starts; None for the default.
    """

    tool: str
    element: str
    problem: str
    size: float
    first_size: float | None = None

    @property
    def adaptive(self) -> bool:
        """Whether `size` is a tolerance."""
        return self.tool.endswith("--tolerance")

    @property
    def name(self) -> str:
        """The tool, with the tolerance if there is one."""
        return f"{self.tool} {self.size:g}" if self.adaptive else self.tool

    @property
    def order(self) -> int:
        """1 or 2."""
        return int(self.element[1])

    @property
    def series(self) -> tuple[str, str, str]:
        """Key of the series: computations that differ only in the size."""
        return self.problem, self.tool, self.element


@dataclass(frozen=True)
class Measured:
    """The outcome of a computation.

    Attributes
    ----------
    size
        Element size, mm (of the first mesh if there are several).
    dofs
        Degrees of freedom of the meshed body (the whole rod).
    seconds
        Wall time from the geometry to the stress, the median of its runs.
    peak_memory
        Peak memory of the process, MiB.
    value
        The quantity, MPa.
    """

    size: float
    dofs: int
    seconds: float
    peak_memory: float
    value: float


@dataclass(frozen=True)
class Row:
    """A computation with its outcome and its error."""

    computation: Computation
    measured: Measured
    quantity: str
    error_percent: float

    def as_dict(self) -> dict[str, object]:
        """Return the row with the names that other programs rely on."""
        return {
            "tool": self.computation.tool,
            "element": self.computation.element,
            "size_mm": self.measured.size,
            "dofs": self.measured.dofs,
            "seconds": self.measured.seconds,
            "peak_memory_MiB": self.measured.peak_memory,
            "quantity": self.quantity,
            "value": self.measured.value,
            "error_percent": self.error_percent,
        }
