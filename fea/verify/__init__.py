"""Figures that others have, against ours."""
