"""The rod of a study: its mesh, its load cases and the nodal forces on it."""
