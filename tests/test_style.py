"""The manual, the help texts and the messages use plain words; the glossary lists what they avoid."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
GLOSSARY = ROOT / "docs" / "carry-on" / "glossary.md"
PACKAGES = ("fea", "geometry", "loads", "mesh")


def avoided() -> re.Pattern:
    """What the glossary's second table lists in its first column."""
    table = GLOSSARY.read_text(encoding="utf-8").partition("## Plain words")[2]
    rows = re.findall(r"^\| ([^|-]+) \|", table, re.MULTILINE)[1:]
    words = [re.escape(word) for row in rows for word in row.split(", ")]
    assert len(words) > 20
    return re.compile(rf"(?<!there )\b(?:{'|'.join(words)})\b", re.IGNORECASE)


def messages(source: str) -> list[tuple[int, str]]:
    """The texts of a module with their lines, without its docstrings."""
    nodes = list(ast.walk(ast.parse(source)))
    bodies = [node.body[0] for node in nodes if isinstance(getattr(node, "body", None), list) and node.body]
    described = {id(first.value) for first in bodies if isinstance(first, ast.Expr)}
    texts = (node for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return [(node.lineno, node.value) for node in texts if id(node) not in described]


def test_messages_are_texts_without_docstrings():
    source = '"""Whoever reads."""\ndef f():\n    """Anew."""\n    raise ValueError(f"whoever {1} asks")\n'
    assert messages(source) == [(4, "whoever "), (4, " asks")]


def test_pages_avoid_what_the_glossary_lists():
    words = avoided()
    pages = [*(ROOT / "docs").glob("[!_]*/*.md"), *ROOT.glob("[CR]*.md"), ROOT / "results" / "README.md"]
    written = [page for page in pages if page.parent.name != "trust" or page.name == "index.md"]
    wrong = [
        f"{page.relative_to(ROOT)}:{number}: {found[0]}"
        for page in written
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1)
        if (found := words.search(line)) and not (page == GLOSSARY and line.startswith("|"))
    ]
    assert not wrong, "\n".join(wrong)


def test_the_address_of_a_doi_is_that_of_its_text():
    text = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("[!_]*/*.md"))
    links = re.findall(r"\[doi:([^\]]*)\]\((\S+)\)[,.;]", text)
    assert len(links) == text.count("[doi:") > 10
    for name, address in links:
        assert re.fullmatch(r"10\.\d{4,9}/\S+", name)
        assert address == f"https://doi.org/{name}"


def test_messages_avoid_what_the_glossary_lists():
    words = avoided()
    wrong = []
    for path in (path for package in PACKAGES for path in (ROOT / package).rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        if words.search(source):
            found = [(line, words.search(text)) for line, text in messages(source)]
            wrong += [f"{path.relative_to(ROOT)}:{line}: {hit[0]}" for line, hit in found if hit]
    for path in (path for package in PACKAGES for path in (ROOT / package).rglob("*.toml")):
        lines = enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        found = [(number, words.search(line.partition("#")[0])) for number, line in lines]
        wrong += [f"{path.relative_to(ROOT)}:{line}: {hit[0]}" for line, hit in found if hit]
    assert not wrong, "\n".join(wrong)
