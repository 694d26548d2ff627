"""Grades and threads of bolts that fit a rod, compared from one run."""
