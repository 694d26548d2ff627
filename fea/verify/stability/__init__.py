"""Ill-conditioned and extreme cases with known answers: where methods fail, and whether that is noticed."""
