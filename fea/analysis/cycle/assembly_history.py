"""Bolts, joint and fits over the crank angle."""

from collections.abc import Sequence

import numpy as np

from fea.base.units import UM
from fea.contact.assembly_state import AssemblyState
from geometry.arrays import Floats
from geometry.surfaces import Surface

# In the names of columns, by the seat.
_FITS = {Surface.BUSHING_SEAT: "bushing", Surface.SHELL_SEAT: "shells"}


def bolt_forces(states: Sequence[AssemblyState]) -> Floats:
    """Forces (n_bolts, n) of the bolts in a sequence of states, N."""
    return np.array([[bolt.force for bolt in state.bolts] for state in states]).T


def bolt_bending(states: Sequence[AssemblyState]) -> Floats:
    """Largest bending stress (n_bolts, n) of the bolts in a sequence of states, MPa."""
    return np.array([[bolt.bending for bolt in state.bolts] for state in states]).T


def assembly_columns(states: Sequence[AssemblyState]) -> dict[str, Floats]:
    """Return the columns of a table over a sequence of states; none for a rod of one piece."""
    if not states:
        return {}
    joint = [state.joint for state in states]
    columns = {f"bolt_{number}_N": force for number, force in enumerate(bolt_forces(states), 1)}
    columns |= {f"bolt_{number}_bending_MPa": bent for number, bent in enumerate(bolt_bending(states), 1)}
    columns |= {
        "joint_clamp_N": np.array([own.force for own in joint]),
        "joint_shear_N": np.array([own.shear for own in joint]),
        "joint_open_percent": np.array([100 * own.open_share for own in joint]),
        "joint_opening_um": np.array([own.opening / UM for own in joint]),
    }
    for seat, name in _FITS.items():
        if seat in states[0].faces:
            fit = [state.faces[seat] for state in states]
            columns[f"{name}_mean_MPa"] = np.array([own.mean for own in fit])
            columns[f"{name}_least_MPa"] = np.array([own.least for own in fit])
            columns[f"{name}_lifted_percent"] = np.array([100 * own.open_share for own in fit])
    return columns
