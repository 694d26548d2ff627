"""What every stage shares: closed choices, the limits of checks, materials."""
