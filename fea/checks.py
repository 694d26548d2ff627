"""Checks that decide whether a result may be trusted."""

from dataclasses import dataclass

# Limits, each relative unless its name says otherwise, and why.
LIMITS = {
    # Every number of the result is finite: a count of those that are not.
    "finite": 0.0,
    # Facets and oil holes change a bore's area; beyond this the pressure is not the one intended.
    "bore_pressure_scale": 0.2,
    # Pin, crank and inertia forces (and moments about z) come from one quadrature: rounding only.
    "force_balance": 1e-8,
    "moment_balance": 1e-8,
    # Moment out of the plane of motion, over force times length, that inertia balances where pins would: a
    # force a thousandth of the length off its line adds a twentieth to the stress of a shank an eighth thick.
    "tilt": 1e-3,
    # Strain anywhere, and displacement over the rod's length: linear elasticity errs by about as much. Metals
    # yield at a hundredth, so that it is rubber, or a modulus in the wrong unit, that fails.
    "small_strain": 0.1,
    "small_displacement": 0.1,
    # Restraints of inertia relief carry what the balance and the solver leave over.
    "reactions": 1e-6,
    # Normwise backward error of a backward stable solver is of the order of machine precision.
    "backward_error": 1e-12,
    # Forces that the solution leaves over at any node, of the largest nodal force: far below any error of the
    # mesh, and what a recheck of the written files is held to.
    "imbalance": 1e-6,
    # What the stress shown amid the shank misses of the forces beyond it: half of what is called converged.
    # Recovered stress does so by the error of the mesh only; bending that first order cannot follow fails.
    "section_balance": 2.5e-2,
    # Rounding may take ε κ of the displacement: a thousandth, a fiftieth of what is called converged.
    "condition": 1e-3 / 2.2e-16,
    # uᵀKu = uᵀf amplifies the backward error by the condition number.
    "energy_balance": 1e-6,
    # The mesh's mass against the solid's: curved elements miss it by far less unless some were straightened.
    "mesh_mass": 1e-3,
    # Straight edges are chords: 32 of them take 0.6 % off a bore's disc, which part of a ring's outside makes
    # good. The most that loads may be off by: a tenth of what a 5 % mesh error is.
    "mesh_mass_p1": 5e-3,
    # Superposed against directly solved peak cases: a tenth of what a 5 % mesh error is.
    "superposition": 5e-3,
    # Where the iteration ends; more means that a factor of buckling was not reached.
    "buckling": 1e-4,
    # Poisson's ratio of the least compressible part without a pressure of its own: beyond these the mean
    # stress of displacement elements oscillates, and those of first order lock too. Those of second order get
    # the pressure there (`fea.solvers.mixed`; `fea stability incompressible` shows why at this ratio).
    "poissons_ratio_p1": 0.4,
    "poissons_ratio_p2": 0.4,
    # Negative: an element is inside out.
    "inverted_elements": 0.0,
    # One over the least mean ratio: a mesher that worked leaves ten at most. A single sliver of 200 makes
    # the condition some four times what it was, flatter ones ever more (`fea stability slivers`).
    "flattest_element": 200.0,
}


@dataclass(frozen=True)
class Check:
    """A checked value and its limit.

    Attributes
    ----------
    value
        What was measured.
    limit
        What it may not exceed.
    """

    value: float
    limit: float

    @property
    def passed(self) -> bool:
        """Whether the value is within the limit (a value that is no number is not)."""
        return self.value <= self.limit


def check(name: str, value: float) -> Check:
    """Hold `value` against the limit called `name`."""
    return Check(value, LIMITS[name])
