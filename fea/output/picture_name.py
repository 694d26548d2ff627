"""The name of a result's picture."""

from pathlib import Path


def picture_name(result: str) -> str:
    """Return the name of the picture of a result file, which stands beside it."""
    return Path(result).with_suffix(".png").name
