"""Error against total run time."""
