"""Linear and eigenvalue solvers, and the systems they solve."""
