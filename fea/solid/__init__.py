"""Linear elasticity on tetrahedra: stiffness, inertia, loads and supports."""
