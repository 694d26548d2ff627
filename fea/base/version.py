"""The version of this program, which `CITATION.cff` and the conda recipe repeat."""

__version__ = "0.1.0"
