"""How the solid is discretised: tetrahedra as arrays."""
