"""What every stage shares: closed choices, limits of the checks, materials, notes, units."""
