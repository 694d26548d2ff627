"""An assembled rod at two crank angles, solved directly by CalculiX on the same mesh.

    python tests/benchmarks/assembly_calculix.py [--size 14] [--report FILE.md]

León's rod with cap, bolts, pressed-in bushing and bearing shells, a quarter of it, without friction. CalculiX
(`ccx` on the path) solves the whole stiffness with penalty contact between the parts, first tightened, then
loaded with locked bolts: by the axial parts of the forces at two crank angles. The pins' pressures and the
inertia are given to it as nodal forces; what it finds are bolt forces and stresses.
"""

import dataclasses
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scripts import command, publish, reporting

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import calculix
from assemblies import EVERY, study

from fea.analysis.pipeline import prepare
from fea.solid.parity import Parity
from fea.solid.recovery import PartRecovery
from fea.solid.stress import von_mises
from fea.verify.body import held
from geometry.surfaces import INTERFACES, Surface

CASES = ("tension", "compression")


def shifted(rod):
    """The mesh with the parts as made: those that are pressed in are larger by their interference."""
    mesh, assembly = rod.mesh.cell, rod.structure.assembly
    points = mesh.points.copy()
    for seat, back in INTERFACES:
        overlap = assembly.interference.get(seat, 0.0)
        if not overlap or seat not in mesh.facets:
            continue
        own = np.unique(mesh.part[np.isin(mesh.tets, mesh.facets[back]).any(axis=1)])
        nodes = np.unique(mesh.tets[np.isin(mesh.part, own)])
        x = rod.mesh.bores.rod_length if seat is Surface.BUSHING_SEAT else 0.0
        away = (points[nodes] - [x, 0, 0]) * [1, 1, 0]
        points[nodes] += overlap * away / np.linalg.norm(away, axis=1)[:, None]
    return dataclasses.replace(mesh, points=points)


def supports(mesh):
    """Degrees of freedom that stop the rod's own rigid motions and those of the mirror planes."""
    fixed = held(mesh, {})
    own = np.unique(mesh.tets[mesh.part == 0])
    fixed[own[mesh.points[own, 0].argmax()], 0] = True
    return fixed


def solved(rod, case, folder):
    """Both solutions of a case: forces of the bolts, displacements, seconds of CalculiX."""
    pins, problem = rod.pins, rod.pins.contact.problem
    (found,) = pins.states(case[None])
    values = problem.unfolding.parts(found.values)[Parity.SYMMETRIC]
    pins = np.zeros_like(values)
    pins[: problem.starts[2]] = values[: problem.starts[2]]
    forces = (problem.forces @ pins).reshape(-1, 3)
    forces = forces + rod.inertia.forces(case).symmetric
    u = rod.equilibrium(case[None]).solution.displacement[Parity.SYMMETRIC][..., 0]
    mesh, fixed = shifted(rod), supports(rod.mesh.cell)
    moduli = [(m.youngs_modulus, m.poissons_ratio) for m in rod.materials]
    pulls = [bolt.forces.reshape(-1, 3) / bolt.share for bolt in problem.bolts]
    k = [bolt.share * bolt.stiffness for bolt in problem.bolts]
    preload = np.array([bolt.share * rod.structure.assembly.preload for bolt in problem.bolts])
    pairs = [calculix.Pair(b, a) for a, b in INTERFACES if a in mesh.facets]
    start = time.perf_counter()
    nothing = np.zeros_like(forces)
    first = calculix.solve(
        folder, mesh, moduli, pairs, fixed, [calculix.Load(nothing, tuple(preload))],
        [calculix.Bolt(pull) for pull in pulls],
    )  # fmt: skip
    locked = first.shortened[0]
    tension = tuple(preload + k * locked)
    loads = [calculix.Load(nothing, tension), calculix.Load(forces, tension)]
    bolts = [calculix.Bolt(pull, own) for pull, own in zip(pulls, k, strict=True)]
    second = calculix.solve(folder, mesh, moduli, pairs, fixed, loads, bolts)
    seconds = time.perf_counter() - start
    theirs = (preload - k * (second.shortened[1] - locked)) / [bolt.share for bolt in problem.bolts]
    return values[-len(problem.bolts) :], theirs, (u, second.u[1]), seconds


def axial(case):
    """Part of a case that is symmetric about y = 0: without friction, nothing holds the cap across."""
    straight = {name: getattr(case, name) * [1.0, 0.0] for name in ("pin", "crank", "acceleration")}
    return dataclasses.replace(case, angular_acceleration=np.zeros(()), **straight)


def peaks(rod, u, margin):
    """Von Mises stress (n_nodes,) by the same recovery of any displacement, NaN near the edges."""
    mesh = rod.mesh.cell
    recovery = PartRecovery(mesh, ())
    found = recovery.nodal_stress(u[..., None], rod.materials)
    stress = np.nanmax([von_mises(own[..., 0]) for own in found], axis=0)
    from scipy.spatial import cKDTree

    surfaces = [side for sides in INTERFACES for side in sides] + [Surface.BOLT_HEAD, Surface.BOLT_THREAD]
    near = np.unique(np.concatenate([mesh.facets[side].ravel() for side in surfaces if side in mesh.facets]))
    away, _ = cKDTree(mesh.points[near]).query(mesh.points)
    stress[away < margin] = np.nan
    return stress


def report(size):
    rod = prepare(study(dataclasses.replace(EVERY, joint_friction=0.0), size=size))
    cases = {case.name: axial(case) for case in rod.loading.at(rod.mass, 6000.0).cases if case.in_cycle}
    margin = size / 2
    lines = []
    for name in CASES:
        with tempfile.TemporaryDirectory(prefix="fea-ccx-") as folder:
            own, theirs, us, seconds = solved(rod, cases[name], Path(folder))
        for number, (mine, other) in enumerate(zip(own, theirs, strict=True), 1):
            off = f"{100 * (mine / other - 1):+.2f}"
            lines.append(f"| {name} | force of bolt {number}, N | {mine:.0f} | {other:.0f} | {off} |")
        stress = [peaks(rod, u, margin) for u in us]
        node = [int(np.nanargmax(s)) for s in stress]
        a, b = (s[n] for s, n in zip(stress, node, strict=True))
        where = ", ".join(f"{v:.1f}" for v in rod.mesh.cell.points[node[0]])
        what = f"largest von Mises stress {margin:g} mm away from edges, at ({where}), MPa"
        lines.append(f"| {name} | {what} | {a:.2f} | {b:.2f} | {100 * (a / b - 1):+.2f} |")
        off = 100 * np.nanmax(np.abs(stress[0] - stress[1])) / b
        lines.append(f"| {name} | largest difference of it there, of the peak | | | {off:.2f} |")
        lines.append(f"| {name} | seconds of CalculiX | | {seconds:.0f} | |")
        print(*lines[-5:], sep="\n", file=sys.stderr, flush=True)
    return rod, lines


def main():
    parser = reporting(__doc__)
    parser.add_argument("--size", type=float, default=14.0)
    arguments = parser.parse_args()
    rod, lines = report(arguments.size)
    unknowns = rod.pins.contact.problem.unfolding.size
    text = "\n".join(
        [
            "# An assembled rod against CalculiX",
            "",
            f"Made by `{command()}`: León's rod with cap, bolts, bushing and",
            "shells under the axial loads of 6000 rpm, without friction; a quarter of it,",
            f"{len(rod.mesh.cell.points)} nodes, {unknowns} unknowns of contact here.",
            "",
            "| case | quantity | here | CalculiX | difference % |",
            "| --- | --- | ---: | ---: | ---: |",
            *lines,
            "",
        ]
    )
    publish(text, arguments.report)


if __name__ == "__main__":
    main()
