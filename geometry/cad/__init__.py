"""Solids from CAD files: read, classified, placed in the rod's frame and cut at their mirror planes."""
