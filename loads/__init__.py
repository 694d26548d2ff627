"""Why the rod is stressed: crank, rod and piston over the cycle."""
