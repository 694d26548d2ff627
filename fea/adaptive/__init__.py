"""Errors of the peaks, and meshes that bring them within a tolerance."""
