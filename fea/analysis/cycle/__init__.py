"""Stress over the whole crank cycle, superposed from unit solutions."""
