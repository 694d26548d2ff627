"""The version of this program, which nothing else states but `CITATION.cff`."""

__version__ = "0.1.0"
