"""Text files damaged as disks, editors and other programs damage them."""

import re

NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
NUMBERS = ("0", "-1", "1e308", "-1e-300", "nan", "99999999999999999999", "1e9", ".", "")


def mutated(text, draw, *, most=6):
    """The text (one letter a byte) with up to `most` kinds of damage.

    Parameters
    ----------
    draw
        A `random.Random`.
    """
    kinds = (flipped, cut, ended, swapped, renumbered, renumbered, scaled, pointed, doubled)
    for _ in range(draw.randint(1, most)):
        if text:
            text = draw.choice(kinds)(text, draw)
    return text


def flipped(text, draw):
    """One bit wrong."""
    at = draw.randrange(len(text))
    return text[:at] + chr(ord(text[at]) ^ (1 << draw.randrange(8))) + text[at + 1 :]


def cut(text, draw):
    """A stretch lost."""
    at = draw.randrange(len(text))
    return text[:at] + text[at + draw.randint(1, 200) :]


def ended(text, draw):
    """The rest lost, seldom: not much is left to test then."""
    return text[: draw.randrange(len(text))] if draw.random() < 0.3 else text


def swapped(text, draw):
    """Two lines in each other's places."""
    lines = text.split("\n")
    a, b = draw.randrange(len(lines)), draw.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return "\n".join(lines)


def doubled(text, draw):
    """A line twice."""
    lines = text.split("\n")
    at = draw.randrange(len(lines))
    return "\n".join([*lines[: at + 1], *lines[at:]])


def renumbered(text, draw):
    """A number that is none, or far off."""
    return _changed(text, draw, NUMBER, lambda _: draw.choice(NUMBERS))


def scaled(text, draw):
    """A number somewhat off."""
    return _changed(text, draw, NUMBER, lambda found: f"{_value(found) * draw.uniform(-2, 3):.6g}")


def pointed(text, draw):
    """A reference of a STEP file that leads elsewhere."""
    return _changed(text, draw, re.compile(r"#\d+"), lambda _: f"#{draw.randint(0, 900)}")


def _changed(text, draw, pattern, change):
    found = list(pattern.finditer(text))
    if not found:
        return text
    match = draw.choice(found)
    return text[: match.start()] + change(match[0]) + text[match.end() :]


def _value(number):
    try:
        return float(number)
    except ValueError:
        return 1.0
