"""Simple bodies with named surfaces: the geometry of published benchmark problems."""
