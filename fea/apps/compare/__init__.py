"""Some studies, or one with several materials, side by side."""
