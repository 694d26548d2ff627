"""Interfaces condensed in the state in which they are closed and stick: the parts then move as one body.

With the stresses λ_J between the parts and the bolt forces as unknowns that keep their gaps y_J, what is left
is the compliance of the joined body for its pins:

    w_p = A λ_p + Bᵀ (y_J − g_J) + G f + g_p − R d
    λ_J = S (y_J − g_J) − B λ_p + V f

This is a principal pivot transform of the contact problem (Cottle, Pang & Stone 1992, section 2.3), in which
the rigid motions of the parts have gone as well. Only what opens or slips is an unknown beside the pins.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, lapack

from geometry.arrays import Floats, Ints

# Motions of the parts whose moments are smaller than this part of the largest are resisted by no interface.
_UNRESISTED = 1e-9


@dataclass(frozen=True)
class CondensedInterface:
    """The condensed problem. The private ones are the terms of `motions`."""

    #: pins, interface: (n_p,), (n_J,) numbers of the unknowns: pressures of the pins; stresses between parts
    #: and bolt forces
    pins: Ints
    interface: Ints
    #: A, B, S: (n_p, n_p), (n_J, n_p), (n_J, n_J) as in the module's description
    A: Floats
    B: Floats
    S: Floats
    #: G, V: (n_p, k), (n_J, k) of the forces (k,) of other loads along the motions of the parts
    G: Floats
    V: Floats
    #: (n_p, m) moments of motions that only the pins resist, and (m, k) their share in the motions of the
    #: parts
    free: tuple[Floats, Floats]
    _back: Floats
    _share: Floats
    _reach: Floats
    _moved: Floats

    @classmethod
    def of(cls, compliance: Floats, parts: Floats, pins: Ints) -> "CondensedInterface":
        """Condense C (n, n) to the pins (n_p,), with moments P (n, k) of the parts' free motions."""
        interface = np.setdiff1d(np.arange(len(compliance)), pins)
        P_p, P_J = parts[pins], parts[interface]
        size = np.abs(parts).max(axis=0, initial=0.0)
        size[size == 0] = 1.0
        _, values, rows = np.linalg.svd(P_J / size, full_matrices=len(interface) < len(size))
        values = np.append(values, np.zeros(len(rows) - len(values)))
        resisted = values > _UNRESISTED * values.max(initial=1e-300)
        share = rows.T / size[:, None]
        kept, loose = share[:, resisted], share[:, ~resisted]
        # The transpose is stored by columns, so that LAPACK overwrites it.
        factor = cho_factor(compliance[np.ix_(interface, interface)].T, lower=True, overwrite_a=True)
        C_Jp = compliance[np.ix_(interface, pins)]
        moved = cho_solve(factor, P_J @ kept)
        schur = (P_J @ kept).T @ moved
        inverse = np.linalg.inv((schur + schur.T) / 2)
        V = moved @ inverse
        of_pins = P_p @ kept
        # S C_Jp, of which the product would lose several digits to rigid motions.
        solved = cho_solve(factor, C_Jp)
        stiff = solved - V @ ((P_J @ kept).T @ solved)
        B = stiff + V @ of_pins.T
        reach = C_Jp.T @ moved - of_pins
        A = compliance[np.ix_(pins, pins)] - C_Jp.T @ stiff
        inverted, _ = lapack.dpotri(factor[0], lower=1, overwrite_c=1)
        below = np.tril(inverted - V @ moved.T)
        S = below + below.T
        S[np.diag_indices_from(S)] /= 2
        A += of_pins @ inverse @ of_pins.T - C_Jp.T @ V @ of_pins.T - of_pins @ V.T @ C_Jp
        return cls(
            pins=pins,
            interface=interface,
            A=(A + A.T) / 2,
            B=B,
            S=S,
            G=reach @ inverse @ kept.T,
            V=V @ kept.T,
            free=(P_p @ loose, loose.T),
            _back=kept @ inverse,
            _share=kept,
            _reach=reach,
            _moved=moved,
        )

    def motions(self, open_gap: Floats, pressure: Floats, forces: Floats, loose: Floats) -> Floats:
        """Motions (k,) of the parts from y_J − g_J (n_J,), λ_p (n_p,), f (k,) and the loose motions (m,)."""
        acting = self._share.T @ forces + self._reach.T @ pressure - self._moved.T @ open_gap
        resisted = self._back @ acting
        return np.asarray(resisted + self.free[1].T @ loose)
