"""Assess stresses: safety factors, fatigue, buckling as a column, error bars and verdicts."""
