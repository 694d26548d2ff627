"""Lay out the wheel: `fea` is its only package, and `geometry`, `mesh` and `loads` lie inside it.

Their names stand at the top of the repository, but other projects install packages of these names, too.
Import statements are rewritten line by line (``from geometry.rod import Rod`` becomes ``from fea.geometry.rod
import Rod``), so that tracebacks name the lines of the repository. hatchling calls this as its build hook;
as a program, ``wheel.py SOURCE TARGET``, it rewrites a copy of a folder: tests that a wheel is to pass.
"""

import re
import shutil
import sys
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # as a program
    BuildHookInterface = object

INSIDE = ("geometry", "mesh", "loads")
_NAMES = "|".join(INSIDE)
_STATEMENT = re.compile(rf"(?m)^([ \t]*(?:>>> )?(?:from|import) )({_NAMES})(?=[. ])")
# A module named in a text: of a string, as tests patch it, or of code that a test hands to Python.
_IN_STRING = re.compile(rf"(?<=[\"'])({_NAMES})(?=\.[a-z_]+[.:][\w.]+[\"'])|(?<=import )({_NAMES})(?=\.)")
_LEFT = re.compile(rf"(?m)^[ \t]*(?:from|import) ({_NAMES})\b")


def moved(text: str) -> str:
    """Return Python code that imports the packages from where they are in the wheel."""
    text = _STATEMENT.sub(r"\1fea.\2", text)
    return _IN_STRING.sub(lambda found: f"fea.{found[0]}", text)


def copied(source: Path, target: Path) -> None:
    """Copy a folder with its code rewritten; caches stay behind."""
    shutil.copytree(source, target, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__", ".*"))
    for path in target.rglob("*.py"):
        text = moved(path.read_bytes().decode())
        if _LEFT.search(text):
            raise ValueError(f"{path} imports a package in a way that is not rewritten")
        path.write_bytes(text.encode())


class OnePackage(BuildHookInterface):
    """The layout of a wheel; an editable installation uses the repository as it is."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the package and have it packed."""
        if self.target_name != "wheel" or version == "editable":
            return
        root, self._made = Path(self.root), Path(mkdtemp())
        package = self._made / "fea"
        copied(root / "fea", package)
        for name in INSIDE:
            copied(root / name, package / name)
        build_data["force_include"][str(package)] = "fea"

    def finalize(self, *_: object) -> None:
        """Remove what was made for the wheel."""
        shutil.rmtree(getattr(self, "_made", ""), ignore_errors=True)


if __name__ == "__main__":
    copied(Path(sys.argv[1]), Path(sys.argv[2]))
