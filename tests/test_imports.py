"""What is imported inside functions: only what start-up would pay for (CONTRIBUTING.md says the rule)."""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
PACKAGES = ("fea", "geometry", "loads", "mesh")
# Commands load what they need, and so do errors and names of the program.
FREE = ("fea.cli", "fea.__main__", "fea")
# Of the standard library: what takes some milliseconds to load, and what exists on some systems only.
SLOW, SYSTEMS = {"asyncio", "concurrent", "secrets", "subprocess"}, {"fcntl", "msvcrt", "resource"}
FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*.py"))
}


def imported(node: ast.stmt) -> list[str]:
    """The modules that a statement imports; of scipy, whose packages load apart, the package."""
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        inside = [f"{node.module}.{alias.name}" for alias in node.names]
        names = [name if name in FILES or node.module == "scipy" else node.module for name in inside]
    else:
        return []
    packages = {name: ".".join(name.split(".")[: 1 + name.startswith("scipy")]) for name in names}
    return [name if name in FILES else packages[name] for name in names]


def statements(body: list[ast.stmt], *, inside: bool = False) -> Iterator[tuple[ast.stmt, bool]]:
    """Every statement of a module that runs, and whether it is inside a function."""
    for node in body:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        yield node, inside
        within = inside or isinstance(node, ast.FunctionDef)
        for name in ("body", "orelse", "finalbody"):
            yield from statements(getattr(node, name, []), inside=within)
        for handler in getattr(node, "handlers", []):
            yield from statements(handler.body, inside=within)


@cache
def imports(module: str) -> tuple[set[str], list[tuple[int, str]]]:
    """What a module imports at its top, and what inside functions, with the lines."""
    top, late = set[str](), list[tuple[int, str]]()
    for node, inside in statements(ast.parse(FILES[module].read_text(encoding="utf-8")).body):
        for name in imported(node):
            late.append((node.lineno, name)) if inside else top.add(name)
    return top, late


@cache
def loaded(module: str) -> set[str]:
    """All modules and packages that come with a module."""
    found, open_ = {module}, [module]
    while open_:
        for name in imports(open_.pop())[0] - found:
            found.add(name)
            if name in FILES:
                open_.append(name)
    return found


def foreign(module: str) -> set[str]:
    """The packages of others that come with a module, and the slow ones of the standard library."""
    packages = {name for name in loaded(module) if name not in FILES} if module in FILES else {module}
    quick = sys.stdlib_module_names - SLOW
    return {name for name in packages if name.split(".")[0] not in quick}


def needless(module: str) -> list[str]:
    """Imports inside functions of a module that defer nothing."""
    return [
        f"{module}:{line}: {name}"
        for line, name in imports(module)[1]
        if name not in SYSTEMS and not foreign(name) - foreign(module)
    ]


def test_an_import_inside_a_function_defers_a_package_of_others():
    checked = [name for name in FILES if name not in FREE and not name.startswith("fea.cli.")]
    assert len(checked) > 200
    assert [line for module in checked for line in needless(module)] == []


def test_what_defers_nothing_is_found():
    assert foreign("fea.base.units") == set()
    assert {"scipy.optimize", "skfem"} <= foreign("fea.analysis.pipeline")
    assert "gmsh" not in foreign("fea.study.rod_table")  # drawing is deferred
