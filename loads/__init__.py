"""The loads on the rod: dynamics of crank, rod and piston over the cycle."""
