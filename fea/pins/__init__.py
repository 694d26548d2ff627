"""What loads the bores: one model a file, each for load cases and for the crank cycle."""
