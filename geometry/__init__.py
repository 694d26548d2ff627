"""The rod: its dimensions, its solid, its named surfaces."""
