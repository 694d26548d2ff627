"""What is done with analyses: runs written, exported and reported; many rods; the lightest rod."""
