"""A coarse run with its cycle and a report, under a name that would run a script if it could."""

from dataclasses import fields, replace
from functools import cache

import numpy as np
from studies import plain_study

from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.apps.result import Result
from fea.machine.clock import Clock
from fea.study.flags import Flags

HOSTILE = '</script><img src="x" onerror="window.hacked = 1">'
RPM = 6000.0
SIZE = 14.0


@cache
def reported_rod():
    """The prepared rod, its result, 20 angles of the cycle in degrees, and what is solved for at each."""
    study = replace(plain_study(), name=HOSTILE)
    study = Flags(rpm="6000", size=SIZE, cycle=True, report=True).applied(study)
    adapted = refined_rod(study, [RPM], Clock())
    run = run_result(study, adapted, adapted.at(RPM))
    result = Result(**{field.name: getattr(run, field.name) for field in fields(run)})
    degrees = np.sort(np.random.default_rng(20).integers(0, 721, 20))
    return adapted.rod, result, degrees, solved_at(adapted.rod, degrees)


def solved_at(rod, degrees):
    """Stress (n_nodes, 6, n) and displacement (n_nodes, 3, n) of the whole rod, directly solved."""
    angles = np.radians(np.asarray(degrees, float))
    solved = rod.equilibrium(rod.crank_cycle(RPM).at(angles))
    return rod.fields.stresses(solved)[0], rod.fields.displaced(solved)
