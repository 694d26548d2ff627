"""Directives that run the program while the manual is built, so that what a page shows is what happens.

Each page has a working folder, in which its blocks run one after another::

    ```{run}            commands, and what they print
    ```{file} my.toml   a file, which is written before it is shown
    ```{python}         a script, and what it prints
    ```{notebook} PATH  a notebook beside the page: its cells, run one after another, and what they show
    ```{made} PATH      a picture that a block has made (`:alt:` and a caption are required)
    ```{report} PATH    a report that a block has made, on the page
    ```{keys}           the keys of a study
    ```{verification} CASE …   rows of `results/verification.md`, which `fea verify` makes

What a block did is kept beside the working folder, with its wall and processor seconds, until the program, or
a block up to there, changes. Sphinx's builder `dummy` runs nothing: it checks syntax and references.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from run_notebook import cells
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = os.environ | {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONPATH": str(ROOT),
    "COLUMNS": "80",
    "NO_COLOR": "1",
    "MPLBACKEND": "agg",
}


@functools.cache
def program() -> str:
    """A fingerprint of the program."""
    paths = [path for package in ("geometry", "mesh", "loads", "fea") for path in (ROOT / package).rglob("*")]
    sources = sorted(path for path in paths if path.is_file() and "__pycache__" not in path.parts)
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


def _processor_seconds() -> float:
    """Processor time of the commands that have ended."""
    times = os.times()
    return times.children_user + times.children_system


class Folder:
    """The working folder of a page, with a log of the blocks that ran in it."""

    def __init__(self, path: Path) -> None:
        self.path, self.log = path, path.with_suffix(".json")
        self.steps: list[tuple[str, str]] = []
        try:
            kept = json.loads(self.log.read_text())
        except FileNotFoundError:
            kept = {}
        self.kept = kept["blocks"] if kept.get("program") == program() else []
        if not self.kept:
            shutil.rmtree(path, ignore_errors=True)

    def run(self, kind: str, text: str) -> str:
        """What a block prints; it and those before it run only if one of them is new."""
        self.steps.append((kind, text))
        count = len(self.steps)
        if [tuple(block[:2]) for block in self.kept[:count]] != self.steps:
            new = self.steps[-1:]
            if len(self.kept) != count - 1:  # another block stood here: what it left must not be there
                shutil.rmtree(self.path, ignore_errors=True)
                self.kept, new = [], self.steps
            self.path.mkdir(parents=True, exist_ok=True)
            self.kept += [(*step, *self._timed(*step)) for step in new]
            self.log.write_text(json.dumps({"program": program(), "blocks": self.kept}))
        return str(self.kept[count - 1][2])

    def _timed(self, kind: str, text: str) -> tuple[str, float, float]:
        begun = time.monotonic(), _processor_seconds()
        printed = self._execute(kind, text)
        return printed, round(time.monotonic() - begun[0], 1), round(_processor_seconds() - begun[1], 1)

    def _execute(self, kind: str, text: str) -> str:
        if kind.startswith("file "):
            path = self.path / kind.removeprefix("file ")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text + "\n")
            return ""
        if kind == "python":
            return self._call([sys.executable, "-c", text], 0)
        if kind == "notebook":
            (self.path / "notebook.ipynb").write_text(text, encoding="utf-8")
            runner = str(Path(__file__).with_name("run_notebook.py"))
            return self._call([sys.executable, runner, "notebook.ipynb"], 0)
        code = int(kind.removeprefix("run "))
        return "".join(f"$ {line}\n{self._call(line, code)}" for line in text.splitlines())

    def _call(self, command: str | list[str], code: int) -> str:
        done = subprocess.run(
            command, shell=isinstance(command, str), cwd=self.path, env=ENVIRONMENT, check=False,
            capture_output=True, text=True, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        if done.returncode != code:
            printed = f"{done.stdout}{done.stderr}"
            raise RuntimeError(f"{command} ended with {done.returncode}, not {code}:\n{printed}")
        return done.stdout + (done.stderr if code else "")


class Block(SphinxDirective):
    """What the directives share: the working folder of the page."""

    has_content = True

    @property
    def dry(self) -> bool:
        """Whether this build runs nothing."""
        return self.env.app.builder.name == "dummy"

    def folder(self) -> Folder:
        data = self.env.temp_data
        if "program folder" not in data:
            name = self.env.docname.replace("/", "-")
            data["program folder"] = Folder(Path(self.env.app.outdir).parent / "runs" / name)
        return data["program folder"]

    def executed(self, kind: str, text: str) -> str:
        self.env.note_dependency(__file__)
        if self.dry:
            return ""
        self.env.metadata[self.env.docname]["program"] = program()
        try:
            return self.folder().run(kind, text)
        except RuntimeError as error:
            raise self.error(str(error)) from error

    def path(self) -> Path:
        path = self.folder().path / self.arguments[0]
        if not path.is_file():
            raise self.error(f"no block of this page has made {self.arguments[0]}")
        return path


def literal(text: str, language: str) -> nodes.literal_block:
    return nodes.literal_block(text, text, language=language)


class Run(Block):
    """Commands, one a line, and what they print."""

    option_spec: ClassVar = {
        "quiet": directives.flag,  # the commands alone
        "exit": directives.nonnegative_int,
        "head": directives.nonnegative_int,  # so many lines of the output
        "only": directives.unchanged,  # the statements of which this expression matches the first line
    }

    def run(self) -> list[nodes.Node]:
        text = "\n".join(self.content)
        printed = self.executed(f"run {self.options.get('exit', 0)}", text).rstrip()
        lines = printed.splitlines()
        if "quiet" in self.options:
            lines = [f"$ {line}" for line in self.content]
        elif "only" in self.options:
            lines = matching(lines, self.options["only"])
        elif "head" in self.options and len(lines) > self.options["head"]:
            lines = [*lines[: self.options["head"]], "…"]
        return [literal("\n".join(lines), "console")]


def matching(lines: list[str], pattern: str) -> list[str]:
    """Return commands, and statements that match with the indented lines that continue them."""
    kept, take = [], False
    for line in lines:
        if not (take and line.startswith("  ")):
            take = line.startswith("$ ") or re.search(pattern, line) is not None
        kept += [line] * take
    return kept


class File(Block):
    """A file, which is written and shown."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        text = "\n".join(self.content)
        self.executed(f"file {self.arguments[0]}", text)
        language = {".toml": "toml", ".py": "python"}.get(Path(self.arguments[0]).suffix, "text")
        caption = nodes.caption("", "", nodes.literal("", self.arguments[0]))
        return [nodes.container("", caption, literal(text, language), literal_block=True,
                                classes=["literal-block-wrapper"])]  # fmt: skip


class Python(Block):
    """A script, and what it prints."""

    def run(self) -> list[nodes.Node]:
        text = "\n".join(self.content)
        printed = self.executed("python", text).rstrip()
        return [literal(text, "python"), *([literal(printed, "text")] if printed else [])]


class Notebook(Block):
    """The cells of a notebook beside the page, and what they show."""

    has_content = False
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        path = Path(self.env.srcdir, self.env.docname).parent / self.arguments[0]
        self.env.note_dependency(str(path))
        printed = self.executed("notebook", path.read_text(encoding="utf-8"))
        outputs = iter(json.loads(printed or "[]"))
        parts: list[nodes.Node] = []
        for cell in cells(path):
            if cell["cell_type"] == "markdown":
                # The page has the title, and no section can end within a directive.
                heading, text = re.fullmatch(r"(?:(#+ [^\n]*)\n)?(.*)", cell["source"], re.DOTALL).groups()
                if heading and heading.startswith("## "):
                    parts.append(nodes.rubric(text=heading.lstrip("# ")))
                parts += self.parse_text_to_nodes(text)
            else:
                parts += [literal(cell["source"], "python"), *shown(next(outputs, {}), cell["metadata"])]
        return parts


def shown(output: dict[str, str], metadata: dict[str, str]) -> list[nodes.Node]:
    """What a cell shows; its picture is described by `alt` in the metadata of the cell."""
    parts: list[nodes.Node] = [literal(output["text"].rstrip(), "text")] if output.get("text") else []
    if "html" in output:
        parts.append(nodes.raw("", f'<div class="output">{output["html"]}</div>', format="html"))
    if "png" in output:
        picture = f'<img src="data:image/png;base64,{output["png"]}" alt="{metadata["alt"]}">'
        parts.append(nodes.raw("", picture, format="html"))
    return parts


class Made(Block):
    """A picture that a block has made."""

    required_arguments = 1
    option_spec: ClassVar = {"alt": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        if self.dry:
            return []
        path = self.path()
        relative = os.path.relpath(path, Path(self.env.srcdir) / Path(self.env.docname).parent)
        figure = nodes.figure("", nodes.image(uri=relative, alt=self.options["alt"]))
        if self.content:
            inline, messages = self.state.inline_text(" ".join(self.content), self.lineno)
            figure += [nodes.caption("", "", *inline), *messages]
        return [figure]


class Report(Block):
    """A report that a block has made, shown on the page."""

    required_arguments = 1
    option_spec: ClassVar = {"title": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        if self.dry:
            return []
        name = f"{self.env.docname.replace('/', '-')}-{Path(self.arguments[0]).parent.name}.html"
        target = Path(self.env.app.outdir) / "reports" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(self.path(), target)
        address = "../" * self.env.docname.count("/") + f"reports/{name}"
        title = self.options["title"]
        text = (
            f'<p><a href="{address}">{title}: open it alone</a></p>'
            f'<iframe class="report" loading="lazy" src="{address}" title="{title}"></iframe>'
        )
        return [nodes.raw("", text, format="html")]


class Verification(SphinxDirective):
    """The rows of some problems from the report of `fea verify`."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        report = ROOT / "results" / "verification.md"
        self.env.note_dependency(str(report))
        cases = self.arguments[0].split()
        table = [line for line in report.read_text().splitlines() if line.startswith("| ")]
        lines = [line.strip("| ").split(" | ") for line in table]
        rows = [[case, *cells[1:6], cells[6]] for case in cases for cells in lines if cells[0] == case]
        missing = set(cases) - {row[0] for row in rows}
        if missing:
            raise self.error(f"results/verification.md has no rows of {', '.join(sorted(missing))}")
        heads = ["problem", "quantity", "unit", "known", "computed", "error %", "limit %"]
        group = nodes.tgroup("", *(nodes.colspec(colwidth=1) for _ in heads), cols=len(heads))
        group += nodes.thead("", table_row(heads))
        group += nodes.tbody("", *map(table_row, rows))
        return [nodes.table("", group, classes=["verification"])]


def table_row(cells: list[str]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph(text=cell)) for cell in cells))


class Keys(SphinxDirective):
    """The keys of a study, table by table, from its JSON Schema."""

    def run(self) -> list[nodes.Node]:
        from fea.study.documents import study_schema

        self.env.metadata[self.env.docname]["program"] = program()
        tables = study_schema()["$defs"]
        parts: list[nodes.Node] = []
        for name, table in tables.items():
            if "properties" not in table:
                continue
            section = nodes.section(ids=[f"key-{name}"])
            section += nodes.title(text=f"[{name}]")
            group = nodes.tgroup("", *(nodes.colspec(colwidth=width) for width in (1, 3)), cols=2)
            rows = [
                nodes.row("", nodes.entry("", nodes.paragraph("", "", nodes.literal(text=key))),
                          nodes.entry("", nodes.paragraph(text=described(entry))))
                for key, entry in table["properties"].items()
                if ", as a text with its unit" not in entry.get("description", "")
            ]  # fmt: skip
            group += nodes.tbody("", *rows)
            section += nodes.table("", group)
            parts.append(section)
        return parts


def described(entry: dict[str, Any]) -> str:
    """A key in words: its description, its choices and its default."""
    words = entry.get("description", "")
    if "enum" in entry:
        words += ": " + ", ".join(map(str, entry["enum"]))
    if "default" in entry:
        words += f"; default {entry['default']}"
    return words


def outdated(_app: Sphinx, env: BuildEnvironment, *_: set[str]) -> list[str]:
    """Return the pages that show what another program did."""
    return [page for page in env.found_docs if env.metadata[page].get("program", program()) != program()]


def by_last_name(app: Sphinx, env: BuildEnvironment, node: addnodes.pending_xref, text: nodes.Element) -> Any:
    """Resolve a Python name without its package, too, such as `InvalidValue`."""
    if node.get("refdomain") != "py" or "refspecific" in node:
        return None
    node["refspecific"] = True
    where, kind, name = node["refdoc"], node["reftype"], node["reftarget"]
    return env.domains["py"].resolve_xref(env, where, app.builder, kind, name, node, text)


def write_reports(app: Sphinx) -> None:
    """Write a page for each of the reports in `results`, which includes it."""
    folder = Path(app.srcdir) / "trust"
    for report in sorted((ROOT / "results").glob("*.md")):
        page = folder / report.name
        text = f"```{{include}} ../../results/{report.name}\n:relative-images:\n```\n"
        if report.name != "README.md" and (not page.exists() or page.read_text() != text):
            page.write_text(text)


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("run", Run)
    app.add_directive("file", File)
    app.add_directive("python", Python)
    app.add_directive("notebook", Notebook)
    app.add_directive("made", Made)
    app.add_directive("report", Report)
    app.add_directive("keys", Keys)
    app.add_directive("verification", Verification)
    app.connect("builder-inited", write_reports)
    app.connect("env-get-outdated", outdated)
    app.connect("missing-reference", by_last_name)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
