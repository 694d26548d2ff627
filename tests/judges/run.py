"""Files of this program read by programs that did not write them: python tests/judges/run.py [JUDGE ...]

Every other file of this folder is a judge. Its first line names the packages that it needs, with versions,
behind ``# requires:``; this script makes an environment of its own for each, in the directory for temporary
files, and runs the judge there with the folder of a run (`run`) and its exports beside it as its argument.
The variable FEA_PYTHON names the Python that runs `fea`. A judge prints rows ``file | what | figure |
expected | yes or no`` and exits with 1 where one is wrong. Outside CI, as the packages are large.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
EXPORTS = ("med", "bdf", "msh", "vtk", "xdmf", "stl", "ply", "inp")
RUN = ("run", "leon-2001", "--pressure", "cosine-180", "--size", "12", "--tolerance", "0", "--quiet")


def environment(judge: Path, folder: Path) -> Path:
    """Return Python in an environment that has what a judge names in its first line."""
    packages = judge.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# requires:").split()
    place = folder / judge.stem
    python = place / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(place)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *packages], check=True)
    return python


def written(folder: Path) -> Path:
    """Return the folder of the files that are judged, made by this checkout."""
    folder.mkdir(parents=True, exist_ok=True)
    known = os.environ | {"PYTHONPATH": str(HERE.parents[1])}
    fea = [sys.executable, "-m", "fea"]
    if not (folder / "run" / "summary.json").is_file():
        subprocess.run([*fea, *RUN, "--out", "run"], cwd=folder, env=known, check=True)
    for ending in EXPORTS:
        subprocess.run([*fea, "export", "run", f"run.{ending}", "--quiet"], cwd=folder, env=known, check=True)
    return folder


def main(names: list[str]) -> int:
    """Run the judges of these names, or all; return the exit code."""
    scratch = Path(tempfile.gettempdir()) / "conrod-fea-judges"
    judges = sorted(path for path in HERE.glob("*.py") if path.name != "run.py")
    chosen = [judge for judge in judges if not names or judge.stem in names]
    folder, wrong = written(scratch / "files"), 0
    for judge in chosen:
        print(f"{judge.stem}:", flush=True)
        python = environment(judge, scratch)
        known, command = os.environ | {"FEA_PYTHON": sys.executable}, [str(python), str(judge), str(folder)]
        wrong += subprocess.run(command, env=known, check=False).returncode != 0
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
