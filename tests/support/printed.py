"""Printed output as a reader sees it."""

WIDTH, MOST = 80, 10


def flowing(text):
    """The text without its line breaks and indents."""
    return " ".join(text.split())


def after_the_table(text):
    """The lines below the last table, which ends with a blank line."""
    lines = text.splitlines()
    last = max(number for number, line in enumerate(lines) if not line.strip())
    return lines[last + 1 :]


def require_brief(text):
    """The output of a run: nothing wider than the terminal, and few lines after the table."""
    assert max(map(len, text.splitlines())) <= WIDTH
    assert 3 <= len(after_the_table(text)) <= MOST
