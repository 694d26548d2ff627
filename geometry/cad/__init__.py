"""Solids from CAD files: read, told apart, placed in the rod's frame and cut at their mirror planes."""
