"""Connecting-rod stress analysis: solves, judges, tells."""
