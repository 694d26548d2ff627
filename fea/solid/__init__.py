"""Solid mechanics on tetrahedra: stiffness, inertia, loads and supports; stresses and their errors."""
