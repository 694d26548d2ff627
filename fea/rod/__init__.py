"""A study's rod: meshed, its load cases, the nodal forces on it."""
