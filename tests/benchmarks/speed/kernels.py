"""Pardiso's phases one by one on the whole rod's matrix, and its operations beside a plain matrix product.

The operations of the factorisation are those Pardiso itself counts (iparm 19; it does so only under its
classic scheduling, on the same ordering). The matrix product is NumPy's, of double precision, with as many
threads.
"""

import time

import numpy as np
from case import read_case
from worker import Run

from fea.base.choices import Support
from fea.solid.assembly import SymmetricMatrix
from fea.solid.parity import Parity
from fea.solvers.direct import _BY_NODES, _FACTORISE, _POSITIVE_DEFINITE, _SOLVE, _Handle
from fea.solvers.static import Model
from fea.study.study import load_study

COUNT, SCHEDULING = 18, 23  # iparm(19): −1 asks for the count, in millions; iparm(24): 0 is the classic one
BLOCK_PRODUCT = 27  # of two 3×3 blocks: Pardiso counts these
SIDE = 3000


def main() -> None:
    run = Run()
    case = read_case(run.case)
    run.facts["product_gflops"] = matrix_product_rate()
    model = Model(case.whole.mesh, load_study("leon-2001").material.material(), Support.INERTIA_RELIEF)
    matrix = model._K.constrained(model._fixed(Parity.SYMMETRIC))
    load = case.forces.reshape(-1, 1)
    run.start()
    with run.stage("analysis"):
        handle = analysed(matrix, {})
    with run.stage("factor"):
        handle(_FACTORISE, 0, matrix.upper.data)
    with run.stage("solve"):
        handle(_SOLVE, 0, matrix.upper.data, load, np.empty_like(load))
    run.facts["factor_gflop"] = operations(matrix) / 1e9
    run.facts["factor_entries"] = float(handle._options[17] * 9)  # 3×3 blocks
    run.facts["matrix_entries"] = float(matrix.upper.data.size)
    run.finish()


def operations(matrix: SymmetricMatrix) -> float:
    """Floating point operations of the factorisation."""
    handle = analysed(matrix, {SCHEDULING: 0, COUNT: -1})
    return 1e6 * BLOCK_PRODUCT * float(handle._options[COUNT])


def analysed(matrix, options):
    """Pardiso's handle of a matrix, with options in place of its usual ones."""
    upper = matrix.upper
    parts = upper.data, upper.indptr, upper.indices
    return _Handle(_POSITIVE_DEFINITE, 1, _BY_NODES | options, parts)


def matrix_product_rate() -> float:
    """GFLOP/s of a product of two dense matrices, the best of five."""
    a = np.random.default_rng(0).normal(size=(SIDE, SIDE))
    best = np.inf
    for _ in range(5):
        start = time.perf_counter()
        a @ a
        best = min(best, time.perf_counter() - start)
    return 2 * SIDE**3 / best / 1e9


if __name__ == "__main__":
    main()
