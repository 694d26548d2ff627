"""The text of error bars and notes, the same in tables, pictures and lists."""

from collections.abc import Iterable, Sequence

_AT_SPEED = " at\0rpm"  # stands for the speed in a note
_WHOLE = 9.95  # percent: error bars from here on have no decimals


def error_bar(percent: float) -> str:
    """Return an error bar as text with two digits."""
    return f"{percent:.{0 if percent >= _WHOLE else 1}f}"


def gathered(notes: Iterable[tuple[float, Sequence[str]]]) -> list[str]:
    """Return the notes of several speeds, rpm; those that differ only in the speed are merged."""
    speeds: dict[str, list[str]] = {}
    for rpm, said in notes:
        for note in said:
            speeds.setdefault(note.replace(f" at {rpm:g} rpm", _AT_SPEED), []).append(f"{rpm:g}")
    return [note.replace(_AT_SPEED, f" at {', '.join(rpm)} rpm") for note, rpm in speeds.items()]
