"""Linear solvers with a common interface."""
