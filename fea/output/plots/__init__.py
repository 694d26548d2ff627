"""Plots over crank angle and speed."""
