"""Jobs built on analyses: write, export and report runs, analyse many rods, find the lightest rod."""
