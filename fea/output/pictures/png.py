"""Check that a file is a complete picture."""

from pathlib import Path

import numpy as np
from PIL import Image


def is_complete_png(path: Path) -> bool:
    """Return whether `path` is a PNG with every chunk intact and more than one colour in it."""
    try:
        with Image.open(path, formats=["PNG"]) as image:
            image.verify()  # of the chunks; after it an image cannot be read
        with Image.open(path, formats=["PNG"]) as image:
            bands = np.atleast_2d(image.getextrema())
    except (OSError, SyntaxError, ValueError):  # Pillow's for a chunk that is damaged or missing
        return False
    return bool((bands[:, 0] < bands[:, 1]).any())
