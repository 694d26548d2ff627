"""Stress out of displacement: recovery, error estimate, singular places."""
