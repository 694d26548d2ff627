"""What can go wrong between a mesh and its stress."""


class UnderconstrainedError(RuntimeError):
    """A rigid motion is left free."""


class SingularMatrixError(RuntimeError):
    """The factorisation met a pivot that is not positive: the model can move or is broken."""


class SolverUnavailableError(RuntimeError):
    """The named solver is not installed on this machine."""


class StagnationError(RuntimeError):
    """The iterative solver did not reach its tolerance."""
