"""Pins that touch their bores: unilateral contact with clearance or interference."""
