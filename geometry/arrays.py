"""Array types, named after what they hold."""

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Reals = npt.NDArray[np.floating[Any]]  # of either precision
Ints = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
