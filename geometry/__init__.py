"""What the rod is: its dimensions, its solid, its named surfaces."""
