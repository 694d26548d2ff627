"""Damaged CAD, mesh, TOML and CSV files through the program: each ends with its exit code and one message.

    python tests/benchmarks/fuzz.py --count 1000 --kinds step igs brep FCStd toml csv
    python tests/benchmarks/fuzz.py --count 40 --kinds inp msh bdf vtu vtk med xdmf mesh

A run that ends otherwise, takes too long, or leaves a file or a process behind is printed with its seed.
CAD files take seconds each: `--resume FILE.json` keeps what was done and goes on from there.
"""

import argparse
import random
import sys
from collections import Counter
from functools import cache
from importlib.resources import files
from pathlib import Path

from scripts import keep, kept_in

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from cad_files import CAD_ENDINGS, cad_file
from damage import KINDS as MESHES
from damage import damaged, mutated
from program import contained

ENGINE = """
[engine]
stroke_mm = 94.0
bore_mm = 76.0
piston_mass_kg = 1.3345
cylinders = 4
gas = {gas}
[speed]
rpm = [6000]
[mesh]
size_mm = 14
element = "p2"
[analysis]
support = "inertia-relief"
symmetry = "auto"
pressure = "cosine-180"
solver = "auto"
[material]
preset = "leon-2001"
"""
CAD = '[rod]\ncad = "rod.{ending}"\n'
MASSES = "[rod]\nlength_mm = 141.0\nmass_kg = 0.785\ncenter_of_gravity_mm = 64.0\ninertia_kg_m2 = 3.9e-3\n"
ROD = '[rod]\npreset = "leon-2001"\nbig_end_bore_mm = 50.0\nweb_thickness_mm = 5.0\n'
SHIPPED = '"leon-2001"'


@cache
def whole(ending: str, number: int) -> str:
    """One of three rods as a CAD file: I-section, rectangular with holes, with a bushing."""
    from geometry.presets import PRESETS
    from geometry.rod import proportioned

    rods = (
        PRESETS["leon-2001"],
        proportioned(120, 40, 20, shank_section="rectangular", oil_hole=3.0),
        proportioned(150, 52, 22, bushing=1.5),
    )
    return cad_file(rods[number], ending).decode("latin-1")


def ended(kind: str, seed: int):
    """One damaged file through the program."""
    draw = random.Random(f"{kind} {seed}")  # noqa: S311
    if kind in CAD_ENDINGS:
        cad = mutated(whole(kind, seed % 3), draw, most=draw.choice([1, 1, 2, 6]))
        study = CAD.format(ending=kind) + ENGINE.format(gas=SHIPPED)
        command = ["rod", "s.toml", "--quiet"] if seed % 2 else ["run", "s.toml", "--quiet"]
        return contained(
            [*command, "--size", 14], {"s.toml": study.encode(), f"rod.{kind}": cad.encode("latin-1")}
        )
    if kind == "toml":
        rod, command = (ROD, "run") if seed % 5 == 0 else (MASSES, "loads")
        study = mutated(rod + ENGINE.format(gas=SHIPPED), draw)
        return contained(
            [command, "s.toml", *["--quiet"][: command == "run"]], {"s.toml": study.encode("latin-1")}
        )
    if kind in MESHES:
        study = f'[rod]\nmesh = "rod.{kind}"\n' + ENGINE.replace("[mesh]\nsize_mm = 14\n", "[mesh]\n")
        command = ["rod", "s.toml", "--quiet"] if seed % 4 else ["run", "s.toml", "--quiet"]
        text = study.format(gas=SHIPPED).replace('element = "p2"\n', "")
        return contained(command, {"s.toml": text.encode(), **damaged(kind, draw)})
    shipped = (files("fea") / "studies" / "leon-2001-gas.csv").read_bytes().decode("latin-1")
    trace = mutated(shipped, draw)
    study = MASSES + ENGINE.format(gas='"g.csv"')
    return contained(["loads", "s.toml"], {"s.toml": study.encode(), "g.csv": trace.encode("latin-1")})


def main() -> None:
    """Damage, run and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", default=["step", "toml", "csv"])
    parser.add_argument("--resume", type=Path, help="a JSON file to keep outcomes in")
    arguments = parser.parse_args()

    kept = kept_in(arguments.resume)
    for kind in arguments.kinds:
        for seed in range(arguments.first, arguments.first + arguments.count):
            if (key := f"{kind} {seed}") not in kept:
                kept[key] = outcome(kind, seed)
                keep(arguments.resume, kept)
        print(
            summary(kind, [(key, entry) for key, entry in kept.items() if key.startswith(kind)]), flush=True
        )


def outcome(kind: str, seed: int) -> dict[str, object]:
    """How one run ended: exit code, whether the CAD kernel died in it, the fault if there is one."""
    found = ended(kind, seed)
    ends = ("it crashed (", "it did not finish within", "it stopped without a message")
    died = "the CAD kernel could not" in found.said and any(end in found.said for end in ends)
    return {"code": found.code, "died": died, "fault": found.fault(), "said": found.said[-300:]}


def summary(kind: str, entries: list[tuple[str, dict]]) -> str:
    """Counts, after a line for each fault."""
    codes = Counter(entry["code"] for _, entry in entries)
    faults = [f"{key}: {entry['fault']}: {entry['said']}" for key, entry in entries if entry["fault"]]
    died = sum(entry["died"] for _, entry in entries)
    ends = f"{kind}: {len(entries)} files, exit codes {dict(sorted(codes.items()))},"
    return "\n".join([*faults, f"{ends} {died} deaths of the CAD kernel survived, {len(faults)} faults"])


if __name__ == "__main__":
    main()
