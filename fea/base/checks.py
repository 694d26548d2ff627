"""The checks that decide whether a result can be trusted."""

from dataclasses import dataclass

# The limit of each check and the reason for it; limits are relative unless stated otherwise.
LIMITS = {
    # Number of load cases with values that are not finite: there must be none.
    "finite": 0.0,
    # Facets and oil holes change the area of a bore, so the pressure is scaled to give the force. A larger
    # correction means that the pressure is no longer the intended one.
    "bore_pressure_scale": 0.2,
    # Pin, crank and inertia forces (and their moments about z) come from the same quadrature, so that only
    # rounding errors remain.
    "force_balance": 1e-8,
    "moment_balance": 1e-8,
    # Moment out of the plane of motion over force times length. In reality the pins react it, in the model
    # inertia does. A force that is off its line by a thousandth of the length raises the stress by a
    # twentieth in a shank whose thickness is an eighth of the length.
    "tilt": 1e-3,
    # Largest strain, and displacement over the rod's length: the error of linear elasticity is of this order.
    # Metals yield at a strain of about 0.01, so that only rubber or a modulus in the wrong unit fails.
    "small_strain": 0.1,
    "small_displacement": 0.1,
    # Reactions at the restraints of inertia relief: rounding errors of the balance and of the solver only.
    "reactions": 1e-6,
    # The normwise backward error of a backward stable solver is of the order of machine precision.
    "backward_error": 1e-12,
    # Largest residual force at any node, relative to the largest nodal force: far below any error of the
    # mesh. An independent recheck of the written files uses the same limit.
    "imbalance": 1e-6,
    # Equilibrium check at mid-shank sections: resultant of the recovered stress against the forces beyond
    # the section. Half of what counts as mesh-converged. On a sufficient mesh only the error of the mesh is
    # left; first-order elements too coarse for bending fail.
    "section_balance": 2.5e-2,
    # Rounding errors may reach ε κ of the displacement: a thousandth is a fiftieth of the 5 % that counts as
    # mesh-converged.
    "condition": 1e-3 / 2.2e-16,
    # uᵀKu = uᵀf; the condition number amplifies the backward error here.
    "energy_balance": 1e-6,
    # Mass of the mesh against that of the solid: the error of curved elements is far smaller unless some
    # had to be straightened.
    "mesh_mass": 1e-3,
    # The straight edges of first-order elements are chords: 32 of them reduce the area of a bore by 0.6 %,
    # partly compensated on the outside of the ring. The loads err by at most this much: a tenth of a 5 % mesh
    # error.
    "mesh_mass_p1": 5e-3,
    # Overlap, and gap under pressure, relative to what the gap is made of; and the resultants of the contact
    # pressures against the forces of the pins: rounding errors only.
    "contact_gap": 1e-9,
    "contact_balance": 1e-8,
    # How far an oil film is from that a cycle before, over its smallest gap (`fea.film.cycle`).
    "film_repeats": 1e-3,
    # Oil that is supplied against what leaks over the cycle, and the film's force against the load: what the
    # iteration leaves, and what the cycle does not repeat.
    "film_oil": 1e-3,
    "film_force": 1e-4,
    # Power of the journal and of the bore's motion against what the film dissipates: what steps leave that
    # had to be halved, and rough surfaces, whose mean gap is not the distance that they move.
    "film_power": 1e-2,
    # What the heat balance leaves of the film's temperature, K: 2 % of the viscosity.
    "film_heat": 1.0,
    # Superposed against directly solved peak cases, and the error that a small basis states
    # (`fea.analysis.cycle.basis`), which grows until it is below: a tenth of a 5 % mesh error.
    "superposition": 5e-3,
    # The same of each part of an assembly, relative to its own stress: a third of what the increments of a
    # cycle with friction leave of single pressures.
    "superposition_of_parts": 2e-2,
    # Residual at which the iteration ends; a larger one means that a buckling load factor did not converge.
    "buckling": 1e-4,
    # Largest Poisson's ratio among the parts solved with displacement elements: above it their mean stress
    # oscillates, and first-order elements lock as well. Second-order elements get a pressure field above it
    # (`fea.solvers.mixed`; `fea stability incompressible` shows why the limit is at this ratio).
    "poissons_ratio_p1": 0.4,
    "poissons_ratio_p2": 0.4,
    # 1 if any element is inverted (its Jacobian is not positive everywhere), else 0.
    "inverted_elements": 0.0,
    # The inverse of the smallest mean ratio: a sound mesh stays below ten. A single sliver of 200 increases
    # the condition number about fourfold, flatter ones even more (`fea stability slivers`).
    "flattest_element": 200.0,
}


@dataclass(frozen=True)
class Check:
    """A checked value and its limit."""

    value: float  #: the measured value
    limit: float  #: the largest value that passes

    @property
    def passed(self) -> bool:
        """Whether the value is within the limit (NaN is not)."""
        return self.value <= self.limit


def check(name: str, value: float) -> Check:
    """Check `value` against the limit called `name`."""
    return Check(value, LIMITS[name])
