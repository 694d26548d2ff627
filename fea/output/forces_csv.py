"""The crank cycle as CSV."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fea.output.text import write_text

COLUMNS = (
    "rpm",
    "crank_deg",
    "gas_N",
    "piston_position_mm",
    "piston_velocity_m_s",
    "piston_acceleration_m_s2",
    "rod_deg",
    "rod_angular_velocity_rad_s",
    "rod_angular_acceleration_rad_s2",
    "pin_axial_N",
    "pin_transverse_N",
    "crank_axial_N",
    "crank_transverse_N",
    "wall_N",
    "torque_Nm",
    "shaking_x_N",
    "shaking_y_N",
)


def write_cycle_csv(path: Path, columns: Mapping[str, npt.ArrayLike]) -> None:
    """Write the cycle, one row per crank angle.

    Parameters
    ----------
    path
        The file to write; its directory must exist.
    columns
        Every name of `COLUMNS` (and optionally ``cylinder``, which then comes first) with its values: (n,),
        or one number for all rows, in the units of the names.

    Raises
    ------
    ValueError
        A column is missing or unknown, or the lengths differ.
    StorageError
        The file could not be written.
    """
    names = ("cylinder", *COLUMNS) if "cylinder" in columns else COLUMNS
    if wrong := set(names) ^ set(columns):
        raise ValueError(f"missing or unknown columns {sorted(wrong)}: a cycle has {', '.join(names)}.")
    values = np.broadcast_arrays(*(np.atleast_1d(np.asarray(columns[name], float)) for name in names))
    write_text(path, ",".join(names) + "\n" + _rows(np.stack(values, axis=1)))


def _rows(values: npt.NDArray[np.float64]) -> str:
    """Rows with seven digits, without negative zeros; values that do not apply (NaN) are blank."""
    row = ",".join(["%.7g"] * values.shape[1]) + "\n"
    return (row * len(values) % tuple((values + 0.0).ravel().tolist())).replace("nan", "")
