"""Discretisation of the solid: tetrahedra as arrays."""
