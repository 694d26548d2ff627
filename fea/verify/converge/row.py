"""A computation and what it cost."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Computation:
    """What is computed, and how.

    Attributes
    ----------
    tool
        ``fea``, ``fea, mean`` (stress at the boundary averaged over elements as inside), ``fea, whole`` (no
        mirror plane used), ``fea --tolerance`` (at the default size, or with a ``--size`` before it) or
        ``CalculiX``.
    element
        ``p1`` or ``p2``.
    problem
        ``rod``, ``lame`` or ``goodier``.
    size
        Element size, mm; the tolerance in percent where one is asked for.
    first_size
        Element size, mm, that a refinement to a tolerance begins with; None for the default.
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
        """The tool, and the tolerance where one is asked for."""
        return f"{self.tool} {self.size:g}" if self.adaptive else self.tool

    @property
    def order(self) -> int:
        """1 or 2."""
        return int(self.element[1])

    @property
    def series(self) -> tuple[str, str, str]:
        """What only the size tells apart."""
        return self.problem, self.tool, self.element


@dataclass(frozen=True)
class Measured:
    """A computation's outcome.

    Attributes
    ----------
    size
        Element size, mm (of the first mesh where there are several).
    dofs
        Degrees of freedom of the body as it was meshed (the whole rod).
    seconds
        Wall time from the drawing to the stress, the median of its runs.
    peak_memory
        Of the process, MiB.
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
