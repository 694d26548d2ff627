"""Notes of several speeds as one list."""

from collections.abc import Iterable, Sequence

_AT_SPEED = " at\0rpm"  # stands for the speed in a note


def gathered(notes: Iterable[tuple[float, Sequence[str]]]) -> list[str]:
    """Return the notes of several speeds, rpm; those that only the speed tells apart become one."""
    speeds: dict[str, list[str]] = {}
    for rpm, said in notes:
        for note in said:
            speeds.setdefault(note.replace(f" at {rpm:g} rpm", _AT_SPEED), []).append(f"{rpm:g}")
    return [note.replace(_AT_SPEED, f" at {', '.join(rpm)} rpm") for note, rpm in speeds.items()]
