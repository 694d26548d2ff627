"""scikit-fem's general assembly of the same stiffness matrix, through its own bases; nothing is solved.

python peer_skfem.py CASE.npz OUT
"""

import meshio
import numpy as np
from skfem import CellBasis, ElementTetP2, ElementVector
from skfem.io.meshio import from_meshio
from skfem.models.elasticity import lame_parameters, linear_elasticity
from worker import Run


def main() -> None:
    run = Run()
    with np.load(run.case) as data:
        points, tets = data["points"], data["tets"]
        lame = lame_parameters(float(data["young"]), float(data["poisson"]))
    form = linear_elasticity(*lame)
    run.start()
    with run.stage("assembly"):
        mesh = from_meshio(meshio.Mesh(points, [("tetra10", tets)]))
        K = form.assemble(CellBasis(mesh, ElementVector(ElementTetP2()), intorder=2))
    run.facts["matrix_entries"] = float(K.nnz)
    run.finish()


if __name__ == "__main__":
    main()
