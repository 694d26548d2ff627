"""What a page holds, and what it may do: its own script and style, and nothing from elsewhere."""

import base64
import hashlib
import json

from markupsafe import Markup


def policy(style: str, script: str) -> str:
    """What the page may do: run its own script and style, show pictures that it holds, and nothing else."""
    scripts = f"'{_hash(script)}'" if script else "'none'"
    return (
        f"default-src 'none'; script-src {scripts}; style-src '{_hash(style)}'; img-src data:; "
        "connect-src 'none'; base-uri 'none'; form-action 'none'"
    )


def embedded_json(value: object) -> Markup:
    """JSON that cannot end the element that holds it."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace("&", "\\u0026"))  # noqa: S704 - escaped here


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
