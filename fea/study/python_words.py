"""Messages in Python's words: `--size` of the command line is the argument `size=`."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from fea.study.all_tables import TABLES
from fea.study.tables import hints_of, keys_of, options_of
from geometry.errors import InvalidValue

# Commands of the shell stay as they are; a word beside a flag may be its value.
_SHELL = r"`[^`]*`|\b(?:fea|pip) (?!is\b|has\b)[a-z]+(?: --[\w-]+| [\w.-]+\.toml)+"
_FLAG = re.compile(rf"{_SHELL}|--(?P<no>no-)?(?P<name>[a-z][a-z-]+)(?: (?P<value>[\w.-]*\w)(?P<end>\))?)?")


@cache
def _values() -> dict[str, Any]:
    """Return by each flag what words its value may be; None for a switch."""
    flags: dict[str, Any] = {}
    for cls in TABLES.values():
        for key, declared in keys_of(cls).items():
            options = options_of(declared.kind or hints_of(cls)[key])
            words = {str(word) for option in options if hasattr(option, "__members__") for word in option}
            flags[declared.flag] = None if options == [bool] else words
    return flags


def in_python(text: str) -> str:
    """Return a message whose flags are named as arguments: ``--tolerance 0`` is ``tolerance=0``."""

    def argument(found: re.Match[str]) -> str:
        if found["name"] is None:
            return found[0]
        name, value = found["name"].replace("-", "_"), found["value"]
        words = _values().get(name, set())
        rest = found[0].partition(" ")[2]
        if words is None or found["no"]:
            return f"{name}={not found['no']}" + (f" {rest}" if rest else "")
        if value and re.fullmatch(r"[\d.]+|[A-Z]+", value):
            return f"{name}={rest}"
        if value and (value in words or found["end"] or "." in value):
            return f'{name}="{value}"{found["end"] or ""}'
        return f"{name}=" + (f" {rest}" if rest else "")

    return _FLAG.sub(argument, text)


@contextmanager
def python_words() -> Iterator[None]:
    """Let errors that leave the block, or the function that this decorates, speak Python's words."""
    try:
        yield
    except InvalidValue as error:
        name = "study" if error.name == "STUDY" else error.name
        name = name[2:].replace("-", "_") if name.startswith("--") else name
        words = in_python(error.rule), in_python(error.remedy), error.example
        InvalidValue.__init__(error, name, error.value, *words)
        raise
    except Exception as error:
        error.args = tuple(in_python(arg) if isinstance(arg, str) else arg for arg in error.args)
        raise
