"""HTML pages that run what they hold and fetch nothing."""

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Iterable
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fea.base.shipped import shipped_text
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


# Before a number, but not within a name or a range.
_MINUS = re.compile(r"(?<![\w)-])-(?=\.?\d)")


@cache
def environment(room: str) -> Environment:
    """Return the templates of a room."""
    templates = Environment(
        loader=PackageLoader("fea.output", f"{room}/page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: in_text(value) if type(value) is str else value,
    )
    templates.filters["sentence"] = _sentence
    templates.filters["proper"] = lambda text: _MINUS.sub("−", str(text))
    return templates


def _sentence(value: object) -> str:
    """Return a text with a capital letter at its beginning, unless its first word is the name of a key."""
    text = str(value)
    first = text.partition(" ")[0]
    return text if "_" in first or not text else f"{text[0].upper()}{text[1:]}"


def policy(style: str, script: str) -> str:
    """Return what a page may do: run its own script and style, show pictures that it holds; nothing else."""
    scripts = f"'{_hash(script)}'" if script else "'none'"
    return (
        f"default-src 'none'; script-src {scripts}; style-src '{_hash(style)}'; img-src data:; "
        "connect-src 'none'; base-uri 'none'; form-action 'none'"
    )


def embedded_json(value: object) -> Markup:
    """Return JSON that cannot end the element that holds it."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace("&", "\\u0026"))  # noqa: S704 - escaped here


def packed_json(value: object) -> Markup:
    """Return JSON as letters, deflated and in base64: a quarter as long."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":")).encode()
    return Markup(base64.b64encode(zlib.compress(text)).decode())  # noqa: S704 - base64


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
