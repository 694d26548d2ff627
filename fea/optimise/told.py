"""What a search says while it is under way."""

from collections.abc import Callable
from math import inf

from fea.optimise.designs import Design


def telling(say: Callable[[str], None], most: int) -> Callable[[Design, int], None]:
    """Return what is to be told each design, and how many meshes of at most so many were solved."""
    lightest = inf

    def tell(design: Design, count: int) -> None:
        nonlocal lightest
        if design.margin >= 0:
            lightest = min(lightest, design.mass_kg)
        found = f"lightest that holds: {1000 * lightest:.4g} g" if lightest < inf else "none holds yet"
        say(f"{count} of at most {most} meshes solved, {found}")

    return tell
