"""Meshes of other programs: read, checked, mended and placed in the rod's frame."""
