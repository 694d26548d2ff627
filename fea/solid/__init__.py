"""Linear elasticity on tetrahedra: from a mesh and loads to stress."""
