"""The page: laid out by its script from what the server tells of the study."""

from markupsafe import Markup

from fea.output.html import environment, page_file
from fea.output.report.coding import policy

# In this order, as one script: each uses what stands before it.
_OF_REPORT = (
    "vectors.js",
    "numbers.js",
    "surface.js",
    "camera.js",
    "painter.js",
    "pick.js",
    "hands.js",
    "legend.js",
)
_OWN = ("wire.js", "stage.js", "sliders.js", "answer.js", "variants.js", "studio.js")


def studio_page(title: str) -> tuple[str, str]:
    """Return the page, and the policy of what it may do, with {socket} for the address of its socket."""
    style = page_file("report", "report.css") + page_file("studio", "studio.css")
    parts = [page_file("report", name) for name in _OF_REPORT] + [page_file("studio", name) for name in _OWN]
    body = "\n".join(parts)
    script = f'(() => {{\n"use strict";\n{body}}})();\n'
    page = (
        environment("studio")
        .get_template("studio.html.jinja")
        .render(
            title=title,
            style=Markup(style),  # noqa: S704 - our own
            script=Markup(script),  # noqa: S704 - our own
        )
    )
    return page, policy(style, script).replace("connect-src 'none'", "connect-src {socket}")
