"""The errors of solving a meshed model."""

from geometry.errors import public


@public
class UnderconstrainedError(RuntimeError):
    """The supports leave a rigid-body motion free."""


@public
class SingularMatrixError(RuntimeError):
    """The factorisation met a pivot that is not positive: the model is under-constrained or faulty."""


@public
class SolverUnavailableError(RuntimeError):
    """The named solver is not installed on this machine."""


@public
class StagnationError(RuntimeError):
    """The iterative solver did not reach its tolerance."""


@public
class ContactError(RuntimeError):
    """No contact pressure balances the load."""


class UnsettledError(ContactError):
    """A step of parts in contact did not settle; a smaller one may."""


class FilmError(ContactError):
    """An oil film was not solved."""
