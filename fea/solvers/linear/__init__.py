"""Linear solvers behind one small protocol."""
