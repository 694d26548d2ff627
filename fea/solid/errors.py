"""The errors of solving a meshed model."""


class UnderconstrainedError(RuntimeError):
    """The supports leave a rigid-body motion free."""


class SingularMatrixError(RuntimeError):
    """The factorisation met a pivot that is not positive: the model is under-constrained or faulty."""


class SolverUnavailableError(RuntimeError):
    """The named solver is not installed on this machine."""


class StagnationError(RuntimeError):
    """The iterative solver did not reach its tolerance."""


class ContactError(RuntimeError):
    """No contact pressure balances the load."""


class UnsettledError(ContactError):
    """A step of parts in contact did not settle; a smaller one may."""


class FilmError(ContactError):
    """An oil film was not solved."""
