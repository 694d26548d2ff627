"""Run the code cells of a notebook, without Jupyter, and print what each shows as JSON: see `Notebook`.

`python run_notebook.py FILE.ipynb` prints a list with an entry for each cell: ``{"text": …}`` for what it
prints or for the text of its last line, ``{"html": …}`` and ``{"png": …}`` for what a notebook shows of that.
"""

import ast
import base64
import io
import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any


def cells(notebook: Path) -> list[dict[str, Any]]:
    """Return the cells of a notebook, each with its source as one text."""
    every = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return [cell | {"source": "".join(cell["source"])} for cell in every]


def run(source: str, names: dict[str, Any]) -> dict[str, str]:
    """Run a cell in the names of those before it and return what it shows."""
    body = ast.parse(source).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile(ast.Module(body, []), "cell", "exec"), names)  # noqa: S102 - of the manual
        value = None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)  # noqa: S307
    shown = {"text": printed.getvalue()}
    for kind in ("html", "png"):
        if hasattr(value, f"_repr_{kind}_"):
            found = getattr(value, f"_repr_{kind}_")()
            shown[kind] = found if kind == "html" else base64.b64encode(found).decode()
    if figure := _figure():
        shown["png"] = figure
    elif value is not None and shown.keys() == {"text"}:
        shown["text"] += f"{value!r}\n"
    return shown


def _figure() -> str:
    """Return the figure that a cell has drawn, as PNG; "" for none."""
    plots = sys.modules.get("matplotlib.pyplot")
    if plots is None or not plots.get_fignums():
        return ""
    drawn = io.BytesIO()
    plots.gcf().savefig(drawn, format="png", dpi=100, bbox_inches="tight")
    plots.close("all")
    return base64.b64encode(drawn.getvalue()).decode()


if __name__ == "__main__":
    names: dict[str, Any] = {"__name__": "__main__"}
    code = [cell["source"] for cell in cells(Path(sys.argv[1])) if cell["cell_type"] == "code"]
    shown = [run(source, names) for source in code]
    sys.stdout.write(json.dumps(shown))
