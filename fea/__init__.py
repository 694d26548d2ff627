"""Stress analysis of connecting rods, from a study to stresses and safety factors.

`analyse` computes and returns a `Result`; `run` does what ``fea run`` does in the shell and leaves files.
Importing this package loads nothing else: a name is loaded when it is first used. It keeps OpenBLAS in one
thread, unless ``OPENBLAS_NUM_THREADS`` says otherwise.

>>> import fea
>>> result = fea.analyse(fea.load_study("leon-2001"), rpm=6000, size=14)
>>> result.trusted
True
"""

import os
import sys
from importlib import import_module
from pathlib import Path
from types import FunctionType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fea.analysis.prepared_rod import PreparedRod
    from fea.apps.bolts.run_bolts import bolts
    from fea.apps.limits.run_limits import limits
    from fea.apps.many import Results, analyse_many
    from fea.apps.result import Result, analyse, prepare
    from fea.output.folder import OccupiedError, PictureError, StorageError
    from fea.solid.errors import (
        ContactError,
        SingularMatrixError,
        SolverUnavailableError,
        StagnationError,
        UnderconstrainedError,
    )
    from fea.solid.scikit_fem import basis, stiffness_coo, to_skfem
    from fea.study.study import Study, load_study
    from geometry.errors import GeometryError, InvalidValue
    from mesh.tetmesh import MeshError

__all__ = [
    "ContactError",
    "GeometryError",
    "InvalidValue",
    "MeshError",
    "OccupiedError",
    "PictureError",
    "PreparedRod",
    "Result",
    "Results",
    "SingularMatrixError",
    "SolverUnavailableError",
    "StagnationError",
    "StorageError",
    "Study",
    "UnderconstrainedError",
    "analyse",
    "analyse_many",
    "basis",
    "bolts",
    "limits",
    "load_study",
    "prepare",
    "run",
    "stiffness_coo",
    "to_skfem",
]

# Over small matrices, more threads are several times slower, and beside other work they wait for each other.
# OpenBLAS reads this as it is loaded; where NumPy has been loaded before, it is told.
if os.environ.setdefault("OPENBLAS_NUM_THREADS", "1") == "1" and "numpy" in sys.modules:
    from threadpoolctl import ThreadpoolController

    ThreadpoolController().select(internal_api="openblas").limit(limits=1)

# Where each public name is defined; a wheel rewrites the packages that lie inside it (`.ci/wheel.py`).
_HOMES = (
    "fea.base.version:__version__",
    "fea.analysis.prepared_rod:PreparedRod",
    "fea.apps.bolts.run_bolts:bolts",
    "fea.apps.limits.run_limits:limits",
    "fea.apps.many:Results",
    "fea.apps.many:analyse_many",
    "fea.apps.result:Result",
    "fea.apps.result:analyse",
    "fea.apps.result:prepare",
    "fea.output.folder:OccupiedError",
    "fea.output.folder:PictureError",
    "fea.output.folder:StorageError",
    "fea.solid.errors:ContactError",
    "fea.solid.errors:SingularMatrixError",
    "fea.solid.errors:SolverUnavailableError",
    "fea.solid.errors:StagnationError",
    "fea.solid.errors:UnderconstrainedError",
    "fea.solid.scikit_fem:basis",
    "fea.solid.scikit_fem:stiffness_coo",
    "fea.solid.scikit_fem:to_skfem",
    "fea.study.study:Study",
    "fea.study.study:load_study",
    "geometry.errors:GeometryError",
    "geometry.errors:InvalidValue",
    "mesh.tetmesh:MeshError",
)


def __getattr__(name: str) -> Any:
    home = next((home for home in _HOMES if home.endswith(f":{name}")), None)
    if home is None:
        raise AttributeError(f"module 'fea' has no attribute {name!r}")
    try:
        found = getattr(import_module(home.partition(":")[0]), name)
    except ImportError as error:
        from fea.machine.remedies import foreign_package

        if said := foreign_package(error):
            raise ImportError(said) from error
        raise
    if isinstance(found, FunctionType):  # the command line calls the function itself, and keeps its own words
        from fea.study.changes import python_words

        found = python_words()(found)
        found.__module__ = "fea"  # by which it is pickled
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return [*__all__, "__doc__", "__version__"]


def run(study: "str | Path | Study" = "leon-2001", **flags: Any) -> dict[str, Any] | list[dict[str, Any]]:
    """Analyse a study at each of its speeds and write a run for each, as ``fea run`` does.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
    **flags
        Those of ``fea run`` by their Python names: ``rpm`` (a number, a list or text), ``size``,
        ``element``, ``support``, ``symmetry``, ``pressure``, ``solver``, ``tolerance``, ``min_safety``,
        ``matrix_assembly``, ``material``, ``engine``, ``screenshot``, ``report``, ``pvd_step``, ``cycle``,
        ``fatigue``, ``buckling``, ``animate``, ``out``, ``unusual``; of a rod from a file ``unit``,
        ``solids``, ``cap``, ``big_end_bore``, ``small_end_bore``, ``swap_ends``.

    Returns
    -------
    dict or list of dict
        What ``summary.json`` holds; a list for several speeds.

    Raises
    ------
    InvalidValue
        A value breaks a rule.
    """
    from fea.apps.run_study import run_study
    from fea.output.json_file import as_dict
    from fea.study.changes import python_words
    from fea.study.flags import python_flags
    from fea.study.study import Study, load_study

    with python_words():
        asked = study if isinstance(study, Study) else load_study(study)
        summaries = [as_dict(report.summary) for report in run_study(python_flags(flags).applied(asked))]
    return summaries[0] if len(summaries) == 1 else summaries
