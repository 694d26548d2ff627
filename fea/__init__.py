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
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fea.analysis.prepared_rod import PreparedRod
    from fea.apps.limits.run_limits import limits
    from fea.apps.result import Result, analyse, prepare
    from fea.solid.scikit_fem import basis, stiffness_coo, to_skfem
    from fea.study.study import Study, load_study

__all__ = [
    "PreparedRod",
    "Result",
    "Study",
    "analyse",
    "basis",
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

# Where each public name is defined.
_HOMES = {
    "__version__": "fea.base.version",
    "PreparedRod": "fea.analysis.prepared_rod",
    "Result": "fea.apps.result",
    "Study": "fea.study.study",
    "analyse": "fea.apps.result",
    "basis": "fea.solid.scikit_fem",
    "limits": "fea.apps.limits.run_limits",
    "load_study": "fea.study.study",
    "prepare": "fea.apps.result",
    "stiffness_coo": "fea.solid.scikit_fem",
    "to_skfem": "fea.solid.scikit_fem",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'fea' has no attribute {name!r}")
    try:
        return getattr(import_module(_HOMES[name]), name)
    except ImportError as error:
        from fea.machine.remedies import foreign_package

        if said := foreign_package(error):
            raise ImportError(said) from error
        raise


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
    geometry.errors.InvalidValue
        A value breaks a rule.
    """
    from fea.apps.run_study import run_study
    from fea.output.json_file import as_dict
    from fea.study.flags import python_flags
    from fea.study.study import Study, load_study

    asked = study if isinstance(study, Study) else load_study(study)
    summaries = [as_dict(report.summary) for report in run_study(python_flags(flags).applied(asked))]
    return summaries[0] if len(summaries) == 1 else summaries
