"""Judges a stress."""
