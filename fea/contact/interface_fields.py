"""Contact pressures and gaps at the nodes of a cell, from the unknowns of its contact problem."""

from dataclasses import replace

import numpy as np

from fea.contact.multipliers import Multipliers
from fea.contact.problem import ContactProblem
from fea.solid.parity import Parity, Split
from geometry.arrays import Floats, Ints


def pressure_at_nodes(problem: ContactProblem, values: Floats) -> Split:
    """Pressure (n_nodes,) of pins and on both sides of interfaces, of unknowns (n,): MPa, 0 elsewhere.

    Where a bore and an interface meet, that of the interface counts.
    """
    found = {}
    for parity, own in problem.fold.parts(values).items():
        nodal = np.zeros(len(problem.mesh.points))
        for number, bore in enumerate(problem.bores):
            nodes, pressure = bore.multipliers.at_nodes(own[problem.own(number)][:, None])
            nodal[nodes] = pressure[:, 0]
        found[parity] = _on_interfaces(problem, own, nodal)
    return Split(found[Parity.SYMMETRIC], found.get(Parity.ANTISYMMETRIC))


def gap_at_nodes(problem: ContactProblem, normal: Ints, gap: Floats) -> Split:
    """Gap (n_nodes,) on both sides of interfaces: mm, 0 elsewhere.

    Parameters
    ----------
    problem
        The parts.
    normal
        (k,) unknowns that are pressures between parts.
    gap
        (k,) at their places, mm.
    """
    every = np.zeros(problem.fold.size)
    every[normal] = gap
    found = {
        parity: _on_interfaces(problem, own, np.zeros(len(problem.mesh.points)))
        for parity, own in problem.fold.parts(every).items()
    }
    return Split(found[Parity.SYMMETRIC], found.get(Parity.ANTISYMMETRIC))


def _on_interfaces(problem: ContactProblem, own: Floats, nodal: Floats) -> Floats:
    """Put the values that belong to the vertices of interfaces at the nodes of both sides."""
    for number, faces in enumerate(problem.faces, len(problem.bores)):
        pressing: Multipliers = faces.pressing
        at_vertices = own[problem.own(number)][: pressing.size, None]
        for side in (pressing, replace(pressing, facets=faces.opposite[1])):
            nodes, values = side.at_nodes(at_vertices)
            nodal[nodes] = values[:, 0]
    return nodal
