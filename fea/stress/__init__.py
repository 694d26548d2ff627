"""Stress from displacement: recovery, error estimate, stress singularities."""
