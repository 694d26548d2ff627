"""How many threads the libraries may use; to be said before they are loaded."""

import os

from geometry.invalid import require

_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def limit_threads(threads: int | None) -> None:
    """Limit OpenMP, MKL and OpenBLAS to `threads`; None leaves what the environment says.

    Raises
    ------
    InvalidValue
        Not a positive number.
    """
    if threads is None:
        return
    require(threads >= 1, "--threads", threads, "must be at least 1")
    for variable in _VARIABLES:
        os.environ[variable] = str(threads)
