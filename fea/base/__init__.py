"""Shared by every stage: closed choices, limits of the checks, materials, notes, units."""
