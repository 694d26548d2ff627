"""Stiff and extreme cases with known answers: where each method breaks, and whether it is noticed."""
