"""Why rods failed, with what differs in its numbers alone told once."""

import re
from collections.abc import Iterable

from fea.sweep.journal import Entry, State

_NUMBER = re.compile(r"\d[\d.e+-]*")


def failures(entries: Iterable[Entry]) -> list[tuple[int, str, int]]:
    """Return the first row and the reason of each kind of failure, and how many rows it has."""
    found: dict[str, list[Entry]] = {}
    for entry in entries:
        if entry.state is State.FAILED:
            found.setdefault(_NUMBER.sub("#", entry.reason), []).append(entry)
    return [(alike[0].number, alike[0].reason, len(alike)) for alike in found.values()]
