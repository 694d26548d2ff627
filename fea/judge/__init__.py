"""Verdicts: safety against yielding, fatigue and buckling, bolts and press fits, error bars."""
