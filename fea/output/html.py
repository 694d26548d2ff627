"""HTML pages that run what they hold and fetch nothing."""

from collections.abc import Iterable
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fea.base.shipped import shipped_text
from fea.output.report.coding import policy
from fea.output.units import in_text


def html_page(room: str, template: str, style: str, script: str, **values: Any) -> str:
    """Return a page from a template of a room of `fea.output`, with its style, its script and the values."""
    return (
        environment(room)
        .get_template(template)
        .render(
            policy=policy(style, script),
            style=Markup(style),  # noqa: S704 - our own
            script=Markup(script),  # noqa: S704 - our own
            **values,
        )
    )


def page_file(room: str, name: str) -> str:
    """Return a file that stands with the templates of a room."""
    return shipped_text(f"output/{room}/page/{name}")


def joined_script(*parts: tuple[str, Iterable[str]]) -> str:
    """Return one script of the files of rooms, each of which uses what stands before it."""
    body = "\n".join(page_file(room, name) for room, names in parts for name in names)
    return f'(() => {{\n"use strict";\n{body}}})();\n'


@cache
def environment(room: str) -> Environment:
    """Return the templates of a room."""
    templates = Environment(
        loader=PackageLoader(f"fea.output.{room}", "page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: in_text(value) if type(value) is str else value,
    )
    templates.filters["sentence"] = _sentence
    templates.filters["proper"] = lambda text: str(text).replace("-", "−")
    return templates


def _sentence(said: object) -> str:
    """A sentence begins with a capital letter, unless its first word is the name of a key."""
    text = str(said)
    first = text.partition(" ")[0]
    return text if "_" in first or not text else f"{text[0].upper()}{text[1:]}"
