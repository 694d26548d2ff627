"""Simple bodies with named surfaces: what published benchmark problems are about."""
