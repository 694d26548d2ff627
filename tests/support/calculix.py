"""Separate parts that touch, as decks of CalculiX, and what it finds.

A bolt is a node of its own whose displacement is, by an equation, the mean approach of the bolt's seats: a
force on it is the force of the bolt, and a spring its stiffness.
"""

import subprocess
from dataclasses import dataclass, field

import numpy as np

from fea.output.inp import _mesh, _rows, _surfaces, read_frd

# Stiffness of the contact, MPa per mm: Young's modulus over a hundredth of a millimetre.
STIFFNESS = 2e7


@dataclass(frozen=True)
class Pair:
    """An interface: the surface that follows and the one that leads, and its friction."""

    follows: str
    leads: str
    friction: float = 0.0


@dataclass(frozen=True)
class Bolt:
    """Nodal forces (n_nodes, 3) of a tension of 1 N on its two seats, and its stiffness, N/mm (0: none)."""

    pull: np.ndarray
    stiffness: float = 0.0


@dataclass(frozen=True)
class Load:
    """Nodal forces (n_nodes, 3), and the force on each bolt beside that of its spring, N.

    `warmer`: by how much the materials that expand are warmer, K.
    """

    forces: np.ndarray
    tension: tuple = ()
    warmer: float = 0.0


@dataclass
class Found:
    """Displacement (n_nodes, 3), stress (n_nodes, 6), and the shortening of each bolt, mm, of every load."""

    u: list = field(default_factory=list)
    stress: list = field(default_factory=list)
    shortened: list = field(default_factory=list)


def solve(  # noqa: PLR0917
    folder,
    mesh,
    moduli,
    pairs,
    held,
    loads,
    bolts=(),
    *,
    stiffness=STIFFNESS,
    lines=(),
    pressed="SURFACE TO SURFACE",
    ties=(),
):
    """Solve the loads one after another, as steps of one deck in `folder`.

    Parameters
    ----------
    mesh
        `TetMesh` of second order; `part` numbers the parts.
    moduli
        (E, ν) of each part, and its expansion along x, 1/K, where it has one.
    ties
        Pairs of surfaces that are joined: that which follows, and that which leads.
    held
        (n_nodes, 3) fixed degrees of freedom.
    stiffness
        Of the contact, MPa per mm.
    """
    text = ["*HEADING", "parts that touch", *_mesh(mesh), *_surfaces(mesh), *_materials(mesh, moduli)]
    first = len(mesh.points) + 1
    for number, bolt in enumerate(bolts):
        text += _bolt(first + number, len(mesh.tets) + 1 + number, bolt, held)
    for number, pair in enumerate(pairs):
        text += [
            f"*SURFACE INTERACTION, NAME=I{number}",
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
            f"{stiffness:.6g}",
        ]
        if pair.friction:
            text += ["*FRICTION", f"{pair.friction:.6g},{stiffness / 10:.6g}"]
        text += [
            f"*CONTACT PAIR, INTERACTION=I{number}, TYPE={pressed}",
            f"{pair.follows.upper()}_FACES,{pair.leads.upper()}_FACES",
        ]
    for number, (follows, leads) in enumerate(ties):
        text += [
            f"*TIE, NAME=T{number}, POSITION TOLERANCE=0.5",
            f"{follows.upper()}_FACES,{leads.upper()}_FACES",
        ]
    text += ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "NALL,0."]
    text += ["*BOUNDARY", *(f"{node + 1},{axis + 1},{axis + 1}" for node, axis in np.argwhere(held).tolist())]
    for load in loads:
        text += _step(load, first)
    (folder / "job.inp").write_text("\n".join([*text, *lines]) + "\n")
    done = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode or "*ERROR" in done.stdout:
        raise RuntimeError(done.stdout[-3000:])
    found = Found()
    for step in range(1, len(loads) + 1):
        u, stress = (
            read_frd(folder / "job.frd", name, len(mesh.points) + len(bolts), step)[: len(mesh.points)]
            for name in ("DISP", "STRESS")
        )
        found.u.append(u)
        found.stress.append(stress)
        found.shortened.append(np.array([(bolt.pull * u).sum() for bolt in bolts]))
    return found


def _materials(mesh, moduli):
    for number, (E, nu, *expansion) in enumerate(moduli):
        yield f"*ELSET, ELSET=PART{number}"
        yield from _rows((np.flatnonzero(mesh.part == number) + 1).tolist())
        yield from (f"*MATERIAL, NAME=M{number}", "*ELASTIC", f"{E:.12g},{nu:.12g}")
        yield from ("*EXPANSION, TYPE=ORTHO", f"{expansion[0] if expansion else 0.0:.12g},0.,0.")
        yield f"*SOLID SECTION, ELSET=PART{number}, MATERIAL=M{number}"


def _bolt(node, element, bolt, held):
    yield from ("*NODE, NSET=BOLTS", f"{node},0.,0.,0.")
    terms = np.argwhere((np.abs(bolt.pull) > 1e-12 * np.abs(bolt.pull).max()) & ~held)
    values = bolt.pull[tuple(terms.T)]
    order = np.argsort(-np.abs(values))  # the first one depends on the others
    yield from ("*EQUATION", f"{len(terms) + 1}")
    rows = [f"{n + 1},{axis + 1},{values[k]:.12e}" for k in order for n, axis in [terms[k].tolist()]]
    rows.append(f"{node},1,-1.")
    yield from (",".join(rows[k : k + 4]) for k in range(0, len(rows), 4))
    yield from ("*BOUNDARY", f"{node},2,3")
    if bolt.stiffness:
        yield from (f"*ELEMENT, TYPE=SPRING1, ELSET=B{element}", f"{element},{node}")
        yield from (f"*SPRING, ELSET=B{element}", "1", f"{bolt.stiffness:.12e}")


def _step(load, first):
    yield from ("*STEP, INC=200", "*STATIC", "1.,1.,1e-6,1.", "*CLOAD, OP=NEW")
    for node, axis in np.argwhere(
        np.abs(load.forces) > 1e-12 * np.abs(load.forces).max(initial=0.0)
    ).tolist():
        yield f"{node + 1},{axis + 1},{load.forces[node, axis]:.12e}"
    for number, tension in enumerate(load.tension):
        yield f"{first + number},1,{tension:.12e}"
    yield from ("*TEMPERATURE", f"NALL,{load.warmer:.12e}")
    yield from (
        "*NODE FILE, FREQUENCY=999",
        "U",
        "*EL FILE, FREQUENCY=999",
        "S",
        "*CONTACT FILE, FREQUENCY=999",
        "CDIS,CSTR",
    )
    yield "*END STEP"
