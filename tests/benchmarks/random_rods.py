"""Rods drawn at random: each meshes with the solid's mass, or is refused by a rule that names a dimension.

    python tests/benchmarks/random_rods.py --count 500

Every rod is meshed at its default size in a process that may crash or hang without taking the others with it.
"""

import argparse
import json
import multiprocessing
import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

TIMEOUT = 300.0  # seconds a rod


def outcome(seed: int) -> dict[str, object]:
    """What became of one rod."""
    from rods import random_rod

    from fea.solid.inertia import inertia
    from geometry.errors import GeometryError, InvalidValue
    from geometry.session import session
    from geometry.solid import build
    from mesh.generate import tetrahedralise
    from mesh.sizing import Sizing, default_size, refinements
    from mesh.tetmesh import MeshError

    rod = random_rod(seed)
    if isinstance(rod, InvalidValue):
        return {"outcome": "refused", "by": rod.name}
    start = time.perf_counter()
    with session() as log:
        try:
            solid = build(rod)
            size = default_size(rod.length)
            refined = refinements(solid.features, size, rod.length)
            volumes = [part.volumes for part in solid.parts]
            mesh, quality = tetrahedralise(solid.faces, refined, Sizing(size), volumes)
        except (GeometryError, MeshError) as error:
            return {"outcome": "failed", "by": str(error)}
    return {
        "outcome": "meshed",
        "seconds": time.perf_counter() - start,
        "elements": len(mesh.tets),
        "scaled_jacobian": quality.least_scaled_jacobian,
        "shape": quality.least_shape,
        "straightened": quality.straightened,
        "mass_error": abs(inertia(mesh, 1.0).properties.mass / solid.mass.mass - 1),
        "warnings": list(log.warnings()),
    }


def main() -> None:
    """Draw, mesh and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--resume", type=Path, help="a JSON file to keep outcomes in")
    arguments = parser.parse_args()
    kept = json.loads(arguments.resume.read_text()) if arguments.resume and arguments.resume.exists() else {}
    pool = None
    for seed in range(arguments.first, arguments.first + arguments.count):
        if str(seed) in kept:
            continue
        pool = pool or multiprocessing.get_context("spawn").Pool(1)
        try:
            kept[str(seed)] = pool.apply_async(outcome, (seed,)).get(TIMEOUT)
        except multiprocessing.TimeoutError:
            kept[str(seed)] = {"outcome": "hung"}
            pool.terminate()
            pool = None
        except Exception as error:  # a crash of the benchmark's own making is an outcome too
            kept[str(seed)] = {"outcome": "crashed", "by": repr(error)}
        if arguments.resume:
            arguments.resume.write_text(json.dumps(kept))
    if pool:
        pool.close()
        pool.join()
    report(kept)


def report(kept: dict[str, dict]) -> None:
    """Print the counts and the extremes."""
    print(dict(Counter(entry["outcome"] for entry in kept.values())))
    print(
        "refused by",
        dict(Counter(e["by"] for e in kept.values() if e["outcome"] == "refused").most_common(8)),
    )
    meshed = {seed: entry for seed, entry in kept.items() if entry["outcome"] == "meshed"}
    for name, worst in (("scaled_jacobian", min), ("shape", min), ("mass_error", max), ("seconds", max)):
        seed = worst(meshed, key=lambda s, name=name: meshed[s][name])
        print(f"{worst.__name__} {name}: {meshed[seed][name]:.3g} (rod {seed})")
    mended = [entry["straightened"] for entry in meshed.values() if entry["straightened"]]
    print(f"{len(mended)} meshes with straightened elements, {sum(mended)} elements in all")
    print(f"{sum(bool(entry['warnings']) for entry in meshed.values())} with warnings of gmsh")
    for seed, entry in kept.items():
        if entry["outcome"] not in ("meshed", "refused"):
            print(f"rod {seed}: {entry}")


if __name__ == "__main__":
    main()
